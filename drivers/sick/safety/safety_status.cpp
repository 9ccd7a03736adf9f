// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/safety_status.h"

#include <array>
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

SelfReport troubles(const SafetyStatus& status) {
  SelfReport report;
  if (!status.state) return report;
  const Ms3State& s = *status.state;
  report.add(s.device_error, Severity::fault,
             "the scanner reports a device error; read it on the display, switch the power off and on");
  report.add(s.application_error, Severity::fault,
             "the scanner reports an application error; read it in Safety Designer and correct its cause");
  report.add(s.contamination_error, Severity::fault,
             "the scanner reports a contamination error: clean its optics cover");
  report.add(s.contamination_warning && !s.contamination_error, Severity::warning,
             "the scanner warns of contamination: clean its optics cover before it switches off");
  report.add(s.manipulation, Severity::fault,
             "the scanner reports manipulation; remove what covers it, and check its mount");
  report.add(
      s.reference_contour, Severity::warning,
      "the scanner's reference contour is violated; check its mount, and the contour in Safety Designer");
  return report;
}

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

namespace {

constexpr std::size_t evaluation_paths = 20;

constexpr std::array<std::string_view, 4> case_names = {"monitoring_case_1", "monitoring_case_2",
                                                        "monitoring_case_3", "monitoring_case_4"};

/// "status_1", "is_safe_1", "is_valid_1" and so on, as sick_safetyscanners/OutputPathsMsg calls them.
struct PathNames {
  std::array<std::string, evaluation_paths> status, is_safe, is_valid;

  PathNames() {
    for (std::size_t i = 0; i < evaluation_paths; ++i) {
      const std::string number = std::to_string(i + 1);
      status[i] = "status_" + number;
      is_safe[i] = "is_safe_" + number;
      is_valid[i] = "is_valid_" + number;
    }
  }
};

const PathNames& path_names() {
  static const PathNames names;
  return names;
}

double bit(std::uint32_t bits, std::size_t i) { return (bits >> i & 1U) != 0 ? 1 : 0; }

bool is_interrupted(ByteView bits, std::size_t beam) {
  return bits.has(beam / 8, 1) && (bits.u8(beam / 8) >> (beam % 8) & 1U) != 0;
}

/// The cut-off paths that the beam interrupts, path 1 in bit 0. 24 bits, which a float holds exactly.
std::uint32_t interrupted_paths(const Ms3Telegram& telegram, std::size_t beam) {
  std::uint32_t paths = 0;
  for (std::size_t i = 0; i < telegram.intrusion.size(); ++i) {
    if (is_interrupted(telegram.intrusion[i], beam)) paths |= 1U << i;
  }
  return paths;
}

}  // namespace

void SafetyTopics::publish_states(const Ms3Telegram& telegram, const PlanarScan& scan, FrameReceiver& out) {
  if (telegram.state) {
    begin(safety_topic::system_state, scan);
    publish_state(*telegram.state, out);
  }
  if (telegram.application) {
    begin(output_paths_topic, scan);
    publish_paths(*telegram.application, out);
  }
}

void SafetyTopics::publish_beams(const Ms3Telegram& telegram, const PlanarScan& scan,
                                 const BeamWindow& window, FrameReceiver& out) {
  publish_intrusion(telegram, scan, window, out);
  publish_beam_status(scan, out);
}

void SafetyTopics::begin(std::string_view topic, const PlanarScan& scan) {
  state_->topic = topic;
  state_->frame_id = scan.frame_id;
  state_->stamp = scan.stamp;
  state_->values.clear();
}

void SafetyTopics::publish_state(const Ms3State& s, FrameReceiver& out) {
  add("run_mode_active", s.run_mode);
  add("standby_mode_active", s.standby);
  add("contamination_warning", s.contamination_warning);
  add("contamination_error", s.contamination_error);
  add("reference_contour_status", s.reference_contour);
  add("manipulation_status", s.manipulation);
  add("safe_cut_off_paths", s.safe_paths);
  add("non_safe_cut_off_paths", s.non_safe_paths);
  add("reset_required_cut_off_paths", s.reset_required_paths);
  for (std::size_t i = 0; i < case_names.size(); ++i) add(case_names[i], s.monitoring_case[i]);
  add("application_error", s.application_error);
  add("device_error", s.device_error);
  out.message(state_);
}

void SafetyTopics::publish_paths(const Ms3Application& a, FrameReceiver& out) {
  const PathNames& names = path_names();
  add("active_monitoring_case", a.cases[0]);
  for (std::size_t i = 0; i < evaluation_paths; ++i) {
    add(names.status[i], bit(a.evaluation_paths, i));
    add(names.is_safe[i], bit(a.evaluation_safe, i));
    add(names.is_valid[i], bit(a.evaluation_valid, i));
  }
  out.message(state_);
}

void SafetyTopics::publish_intrusion(const Ms3Telegram& telegram, const PlanarScan& scan,
                                     const BeamWindow& window, FrameReceiver& out) {
  bool any_path = false;
  for (const ByteView path : telegram.intrusion) any_path = any_path || !path.empty();
  if (!any_path) return;
  intrusion_ = scan;
  intrusion_.reset(scan.beams);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const std::uint32_t paths = interrupted_paths(telegram, window.first + i);
    intrusion_.intensities[i] = static_cast<float>(paths);
    if (paths == 0) continue;
    intrusion_.ranges[i] = scan.ranges[i];
    intrusion_.statuses[i] = scan.statuses[i];
  }
  intrusion_.hide_gap(window);
  out.extra_scan(safety_topic::intrusion, intrusion_);
}

void SafetyTopics::publish_beam_status(const PlanarScan& scan, FrameReceiver& out) {
  if (scan.flags.empty()) return;
  beam_status_ = scan;
  beam_status_.intensities.assign(scan.flags.begin(), scan.flags.end());
  out.extra_scan(beam_status_scan, beam_status_);
}

}  // namespace lidard::sick
