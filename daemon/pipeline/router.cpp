// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/router.h"

#include <algorithm>
#include <stdexcept>

#include "daemon/pipeline/maker.h"

namespace lidard {

void Router::configure(const Config& config) {
  auto topics = std::exchange(topics_, {});
  const auto reports = std::exchange(reports_, {});
  names_.clear();
  for (const SensorConfig& sensor : config.sensors) names_.push_back(sensor.name);
  first_topic_ = names_.size();
  for (const OutputTopic& topic : output_topics(config)) {
    const auto known = std::find_if(topics.begin(), topics.end(),
                                    [&](const auto& one) { return one && one->name == topic.name; });
    const bool is_new = known == topics.end();
    reports_.push_back(is_new ? TopicReport() : reports[(*known)->id]);
    reports_.back().name = topic.name;
    reports_.back().promised = topic.promised;
    topics_.push_back(is_new ? std::make_unique<OutputTopic>() : std::move(*known));
    *topics_.back() = topic;
    names_.push_back(topic.name);
  }
  for (const MergedScanConfig& merged : config.merged_scans) {
    for (const std::string& source : merged.laserscan_topics)
      if (!find_source(source)) names_.push_back(source);
  }
  consumers_.assign(names_.size(), {});
  is_forwarded_.clear();
  for (const std::string& name : names_) is_forwarded_.push_back(config.elsewhere.merged.count(name) > 0);
}

std::optional<std::size_t> Router::find_source(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found == names_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names_.begin());
}

std::size_t Router::source(const std::string& name) const {
  const auto found = find_source(name);
  if (!found) throw std::logic_error("no source " + name);
  return *found;
}

const OutputTopic& Router::topic(const std::string& name) const {
  for (const auto& topic : topics_) {
    if (topic->name == name) return *topic;
  }
  throw std::logic_error("no topic " + name);
}

void Router::publish(const OutputTopic& topic, const Payload& payload, Stamp now) {
  reports_[topic.id].count(now);
  sink_.publish(topic, payload, now);
  if (const auto* scan = std::get_if<const PlanarScan*>(&payload)) feed(first_topic_ + topic.id, **scan, now);
}

void Router::skip(const OutputTopic& topic, Stamp now) {
  reports_[topic.id].count(now);
  sink_.skip(topic, now);
}

void Router::feed(std::size_t source, const PlanarScan& scan, Stamp now) {
  fed_ = true;
  if (is_forwarded_[source] != 0) forward_(names_[source], scan, now);
  for (const Consumer& consumer : consumers_[source]) consumer.maker->add_scan(consumer.index, scan, now);
}

void Router::feed(std::size_t source, const Cloud& cloud, Stamp now) {
  fed_ = true;
  for (const Consumer& consumer : consumers_[source]) consumer.maker->add_cloud(consumer.index, cloud, now);
}

void Router::feed(const OutputTopic& topic, const std::vector<PlacedCloud>& clouds, Stamp instant,
                  Stamp now) {
  for (const Consumer& consumer : consumers_[first_topic_ + topic.id])
    consumer.maker->add_clouds(clouds, instant, now);
}

void Router::pass_by(std::size_t source, const Cloud& cloud, Stamp now) {
  fed_ = true;
  for (const Consumer& consumer : consumers_[source]) consumer.maker->pass_by(consumer.index, cloud, now);
}

bool Router::feeds(std::size_t source) const {
  const auto& consumers = consumers_.at(source);
  return is_forwarded_[source] != 0 ||
         std::any_of(consumers.begin(), consumers.end(),
                     [](const Consumer& consumer) { return consumer.maker->is_wanted(); });
}

}  // namespace lidard
