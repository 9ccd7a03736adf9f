// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/sopas_device.h"

namespace lidard::sim {
namespace {

constexpr char stx = 2, etx = 3;

bool begins_with(const std::string& text, const std::string& beginning) {
  return text.compare(0, beginning.size(), beginning) == 0;
}

std::string refusal(int code) { return "sFA " + std::to_string(code); }

}  // namespace

SopasDevice::SopasDevice() {
  variables = {{"ScanDataEthSettings", "1 C0 A8 0 64 843"},
               {"ScanDataFormat", "2"},
               {"ScanDataEnable", "1"},
               {"ImuDataEthSettings", "1 C0 A8 0 64 1D4F"},
               {"ImuDataEnable", "1"}};
  at_start_ = variables;
}

void SopasDevice::disconnected() {
  buffer_.clear();
  logged_in_ = false;
}

void SopasDevice::power_cycle() {
  disconnected();
  variables = at_start_;
  measuring = false;
}

std::string SopasDevice::receive(std::string_view bytes) {
  buffer_ += bytes;
  std::string answers;
  for (;;) {
    const std::size_t begin = buffer_.find(stx), end = buffer_.find(etx);
    if (begin == std::string::npos || end == std::string::npos || end < begin) return answers;
    const std::string command = buffer_.substr(begin + 1, end - begin - 1);
    buffer_.erase(0, end + 1);
    commands.push_back(command);
    answers += stx + answer(command) + etx;
  }
}

std::string SopasDevice::answer(const std::string& command) {
  for (const auto& [beginning, code] : refusals) {
    if (begins_with(command, beginning)) return refusal(code);
  }
  const std::size_t blank = command.find(' ', 4);
  const std::string name = command.substr(4, blank == std::string::npos ? blank : blank - 4);
  const std::string arguments = blank == std::string::npos ? "" : command.substr(blank + 1);
  const bool known = variables.count(name) > 0;
  if (begins_with(command, "sRN")) return known ? "sRA " + name + " " + variables[name] : refusal(3);
  if (begins_with(command, "sWN")) {
    if (!known) return refusal(3);
    if (!logged_in_) return refusal(1);
    variables[name] = arguments;
    return "sWA " + name;
  }
  if (name == "SetAccessMode") {
    logged_in_ = arguments == "3 " + password;
    return std::string("sAN SetAccessMode ") + (logged_in_ ? "1" : "0");
  }
  if (name == "Run") {
    logged_in_ = false;
    return "sAN Run 1";
  }
  if (name == "LMCstartmeas") {
    if (!logged_in_) return refusal(1);
    measuring = true;
    return "sAN LMCstartmeas 0";
  }
  return refusal(3);
}

}  // namespace lidard::sim
