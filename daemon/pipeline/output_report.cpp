// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/output_report.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstring>
#include <ostream>

namespace lidard {

void OutputReport::count(Stamp released) {
  if (messages == 0) first = released;
  last = released;
  ++messages;
}

double OutputReport::rate() const {
  const double span = seconds(last - first);
  return messages < 2 || span <= 0 ? 0 : static_cast<double>(messages - 1) / span;
}

CountingSink::CountingSink(FrameSink& sink, const std::vector<OutputTopic>& topics) : sink_(sink) {
  for (const OutputTopic& topic : topics) {
    reports_.emplace_back();
    reports_.back().name = topic.name;
    reports_.back().promised = topic.promised;
  }
}

void CountingSink::scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) {
  reports_[topic.id].count(released);
  sink_.scan(topic, scan, released);
}

void CountingSink::cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) {
  reports_[topic.id].count(released);
  sink_.cloud(topic, cloud, released);
}

void CountingSink::message(const OutputTopic& topic, const DeviceMessage& message, Stamp released) {
  reports_[topic.id].count(released);
  sink_.message(topic, message, released);
}

void print_outputs(const char* head, const std::vector<OutputReport>& outputs, std::ostream& out) {
  std::size_t width = std::strlen(head);
  for (const OutputReport& one : outputs) width = std::max(width, one.name.size());
  out << fmt::format("{:<{}}  {:>8}  {:>7}\n", head, width, "messages", "Hz");
  std::string untold;
  for (const OutputReport& one : outputs) {
    if (!one.promised && one.messages == 0) {
      untold += (untold.empty() ? "" : ", ") + one.name;
      continue;
    }
    const std::string rate = one.rate() > 0 ? fmt::format("{:.1f}", one.rate()) : "-";
    std::string remark = one.remark;
    if (one.messages == 0) remark = "none: " + (remark.empty() ? "nothing of its kind came" : remark);
    out << fmt::format("{:<{}}  {:>8}  {:>7}{}{}\n", one.name, width, one.messages, rate,
                       remark.empty() ? "" : "  ", remark);
  }
  if (!untold.empty()) out << "  not told by the devices: " << untold << '\n';
}

bool all_came(const std::vector<OutputReport>& outputs) {
  return std::all_of(outputs.begin(), outputs.end(),
                     [](const OutputReport& one) { return !one.promised || one.messages > 0; });
}

}  // namespace lidard
