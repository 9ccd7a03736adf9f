// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/safety_status.h"

#include <tuple>

namespace lidard::sick {
namespace {

auto tied(const SafetyStatus& s) {
  return std::tie(s.serial, s.plug_serial, s.channel, s.version_major, s.version_minor, s.version_release,
                  s.state, s.intruded_paths, s.standby_state);
}

/// "1 3 7"; "none".
std::string paths(std::uint32_t bits) {
  std::string text;
  for (unsigned i = 0; i < 24; ++i) {
    if ((bits >> i & 1U) != 0) text += (text.empty() ? "" : " ") + std::to_string(i + 1);
  }
  return text.empty() ? "none" : text;
}

std::string yes(bool value) { return value ? "yes" : "no"; }

std::string contamination(const Ms3State& s) {
  if (s.contamination_error) return "error";
  return s.contamination_warning ? "warning" : "none";
}

std::string cases(const Ms3State& s) {
  std::string text;
  for (const std::uint8_t number : s.monitoring_case)
    text += (text.empty() ? "" : " ") + std::to_string(number);
  return text;
}

}  // namespace

bool SafetyStatus::in_standby() const { return (state && state->standby) || standby_state == 1; }

bool operator==(const SafetyStatus& a, const SafetyStatus& b) { return tied(a) == tied(b); }

SafetyStatus read_status(const Ms3Telegram& t) {
  SafetyStatus s;
  s.serial = t.serial;
  s.plug_serial = t.plug_serial;
  s.channel = t.channel;
  s.version_major = t.version_major;
  s.version_minor = t.version_minor;
  s.version_release = t.version_release;
  s.state = t.state;
  for (std::size_t i = 0; i < t.intrusion.size(); ++i) {
    if (t.is_intruded(i)) s.intruded_paths |= 1U << i;
  }
  if (t.application && (t.application->valid_flags & 1U) != 0) s.standby_state = t.application->standby_state;
  return s;
}

std::vector<std::pair<std::string, std::string>> describe(const SafetyStatus& s) {
  std::vector<std::pair<std::string, std::string>> list = {
      {"System Plug Serial Number", std::to_string(s.plug_serial)},
      {"Data Output Channel", std::to_string(s.channel)},
      {"Data Output Version", std::to_string(s.version_major) + "." + std::to_string(s.version_minor) + "." +
                                  std::to_string(s.version_release)},
      {"Standby", yes(s.in_standby())},
      {"Cut-off Paths with Interrupted Beams", paths(s.intruded_paths)}};
  if (!s.state) return list;
  const Ms3State& state = *s.state;
  list.insert(list.end(), {{"Run Mode", yes(state.run_mode)},
                           {"Contamination", contamination(state)},
                           {"Monitoring Cases", cases(state)},
                           {"Safe Cut-off Paths ON", paths(state.safe_paths)},
                           {"Non-safe Cut-off Paths ON", paths(state.non_safe_paths)},
                           {"Cut-off Paths Waiting for Reset", paths(state.reset_required_paths)},
                           {"Reference Contour Violated", yes(state.reference_contour)},
                           {"Manipulation Detected", yes(state.manipulation)},
                           {"Application Error", yes(state.application_error)},
                           {"Device Error", yes(state.device_error)}});
  return list;
}

}  // namespace lidard::sick
