// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/output.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

namespace lidard {

ScanGrid grid_of(const ScanGridSpec& spec) {
  const auto grid = make_grid(spec);
  if (!grid) throw std::logic_error("configuration accepted a grid that is wrong: " + grid.reason());
  return *grid;
}

HeightBand band_of(const OutputScanConfig& config) {
  HeightBand band;
  if (config.min_height) band.min = *config.min_height;
  if (config.max_height) band.max = *config.max_height;
  return band;
}

float value_of(EmptyBeam beam, const OutputScanConfig& config) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  switch (beam) {
    case EmptyBeam::inf:
      return infinite;
    case EmptyBeam::nan:
      return std::numeric_limits<float>::quiet_NaN();
    case EmptyBeam::range_max_plus_one:
      return static_cast<float>(config.grid.range_max) + 1;
    case EmptyBeam::minus_inf:
      return -infinite;
    case EmptyBeam::zero:
      return 0;
  }
  return infinite;
}

void set_encoding(const OutputScanConfig& output, PlanarScan& scan) {
  scan.none_as = value_of(output.empty, output);
  scan.invalid_as = value_of(output.unobserved, output);
}

DiagnosticItem health_of(const std::string& name, const OutputCounters& counters, Stamp now, bool starting) {
  DiagnosticItem item{name};
  const double age = seconds(now - counters.last_published);
  if (starting && counters.no_pose == 0 && (counters.published == 0 || age > 3)) {
    item.message = "waiting for input";
  } else if (counters.published == 0) {
    item.set(Health::error, counters.no_pose > 0 ? "no output: " + counters.why_no_pose
                                                 : "no output: no input has come in yet");
  } else if (age > 3) {
    item.set(Health::error, counters.no_pose > 0
                                ? "no output any more: " + counters.why_no_pose
                                : "no output for more than 3 s: see the state of its sensors");
  } else {
    item.message = "publishing";
  }
  item.awaited = counters.published == 0;
  item.add("Published", counters.published);
  item.add("Inputs without pose", counters.no_pose);
  return item;
}

bool ReportedState::update(SourceState now, Span passed) {
  constexpr Span least = std::chrono::seconds(1);
  passed = std::clamp(passed, Span(0), least);
  const bool stale = now == SourceState::stale;
  stale_ = std::clamp(stale_ + (stale ? passed : -passed), Span(0), least);
  if (stale && state_ == SourceState::lost) stale_ = least;  // it has not been of use meanwhile
  if (stale || now == SourceState::ok) {
    const bool still = state_ == SourceState::stale && stale_ > Span(0);
    now = stale_ == least || still ? SourceState::stale : SourceState::ok;
  }
  return std::exchange(state_, now) != now;
}

void Outlet::configure(std::vector<OutputTopic> topics, std::size_t sensors) {
  const std::vector<OutputReport> before = std::exchange(reports_, {});
  topics_ = std::move(topics);
  sensors_ = sensors;
  consumers_.assign(sensors + topics_.size(), {});
  for (const OutputTopic& topic : topics_) {
    const auto known = std::find_if(before.begin(), before.end(),
                                    [&](const OutputReport& report) { return report.name == topic.name; });
    reports_.push_back(known == before.end() ? OutputReport() : *known);
    reports_.back().name = topic.name;
    reports_.back().promised = topic.promised;
  }
}

void Outlet::publish(const OutputTopic& topic, const Payload& payload, Stamp now) {
  reports_[topic.id].count(now);
  Cloud* const* const cloud = std::get_if<Cloud*>(&payload);
  for (FrameSink* const sink : sinks_) {
    // A sink may keep the points.
    const bool needs_copy = cloud != nullptr && sink != sinks_.back();
    if (needs_copy) copy_ = **cloud;
    sink->publish(topic, needs_copy ? Payload(copy_) : payload, now);
  }
}

bool Outlet::wants(const OutputTopic& topic) const {
  return std::any_of(sinks_.begin(), sinks_.end(), [&](const FrameSink* sink) { return sink->wants(topic); });
}

void Outlet::skip(const OutputTopic& topic, Stamp now) {
  reports_[topic.id].count(now);
  for (FrameSink* const sink : sinks_) sink->skip(topic, now);
}

void Outlet::publish(const std::vector<DiagnosticItem>& items, Stamp now) {
  for (FrameSink* const sink : sinks_) sink->diagnostics(items, now);
}

void Outlet::feed(std::size_t source, const PlanarScan& scan, Stamp now) {
  for (const Consumer& consumer : consumers_[source]) {
    if (consumer.output != nullptr)
      consumer.output->add_scan(consumer.place, scan, now);
    else
      hand_over_(consumer.place, scan, now);
  }
}

void Outlet::feed(std::size_t source, const Cloud& cloud, Stamp now) {
  for (const Consumer& consumer : consumers_[source]) {
    if (consumer.output != nullptr) consumer.output->add_cloud(cloud, now);
  }
}

}  // namespace lidard
