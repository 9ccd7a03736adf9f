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
    places_.emplace(topic.info.name, reports_.size());
    reports_.emplace_back();
    reports_.back().name = topic.info.name;
    reports_.back().promised = topic.promised;
  }
}

void CountingSink::count(const std::string& topic, Stamp released) {
  const auto place = places_.find(topic);
  if (place != places_.end()) reports_[place->second].count(released);
}

void CountingSink::scan(const std::string& topic, const PlanarScan& scan, Stamp released) {
  count(topic, released);
  sink_.scan(topic, scan, released);
}

void CountingSink::cloud(const std::string& topic, Cloud& cloud, Stamp released) {
  count(topic, released);
  sink_.cloud(topic, cloud, released);
}

void CountingSink::fix(const std::string& topic, const GnssFix& fix, Stamp released) {
  count(topic, released);
  sink_.fix(topic, fix, released);
}

void CountingSink::time_reference(const std::string& topic, const TimeReference& reference, Stamp released) {
  count(topic, released);
  sink_.time_reference(topic, reference, released);
}

void CountingSink::imu(const std::string& topic, const ImuSample& sample, Stamp released) {
  count(topic, released);
  sink_.imu(topic, sample, released);
}

void CountingSink::state(const std::string& topic, const DeviceState& state, Stamp released) {
  count(topic, released);
  sink_.state(topic, state, released);
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
