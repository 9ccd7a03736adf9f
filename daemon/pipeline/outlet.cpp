// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/outlet.h"

#include <utility>

#include "daemon/pipeline/output.h"

namespace lidard {

Outlet::Outlet(std::vector<OutputTopic> topics, std::vector<FrameSink*> sinks, std::size_t sensors)
    : topics_(std::move(topics)),
      sinks_(std::move(sinks)),
      sensors_(sensors),
      consumers_(sensors + topics_.size()),
      reports_(topics_.size()) {
  for (const OutputTopic& topic : topics_) {
    reports_[topic.id].name = topic.name;
    reports_[topic.id].promised = topic.promised;
  }
}

void Outlet::connect(std::size_t source, Output& output, std::size_t place) {
  consumers_.at(source).push_back({&output, place});
}

void Outlet::publish(const OutputTopic& topic, const PlanarScan& scan, Stamp now) {
  reports_[topic.id].count(now);
  for (FrameSink* const sink : sinks_) sink->scan(topic, scan, now);
}

void Outlet::publish(const OutputTopic& topic, Cloud& cloud, Stamp now) {
  reports_[topic.id].count(now);
  for (FrameSink* const sink : sinks_) {
    // A sink may keep the points.
    const bool last = sink == sinks_.back();
    if (!last) copy_ = cloud;
    sink->cloud(topic, last ? cloud : copy_, now);
  }
}

void Outlet::publish(const OutputTopic& topic, const DeviceMessage& message, Stamp now) {
  reports_[topic.id].count(now);
  for (FrameSink* const sink : sinks_) sink->message(topic, message, now);
}

void Outlet::publish(const std::vector<DiagnosticItem>& items, Stamp now) {
  for (FrameSink* const sink : sinks_) sink->diagnostics(items, now);
}

void Outlet::feed(std::size_t source, const PlanarScan& scan, Stamp now) {
  for (const Consumer& consumer : consumers_[source]) consumer.output->add_scan(consumer.place, scan, now);
}

void Outlet::feed(std::size_t source, const Cloud& cloud, Stamp now) {
  for (const Consumer& consumer : consumers_[source]) consumer.output->add_cloud(cloud, now);
}

}  // namespace lidard
