// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/router.h"

#include <algorithm>
#include <stdexcept>

namespace lidard {

void Route::deliver(const Frame& frame, Stamp now) {
  ++router_.delivered_;
  if (topic_) {
    report_.count(now);
    frame.has_points ? router_.sink_.publish(*topic_, frame, now) : router_.sink_.skip(*topic_, now);
  }
  if (is_forwarded_ && frame.scan() != nullptr) router_.forward_(name_, *frame.scan(), now);
  for (const Use& use : uses_) use.user->add(use.source, frame, now);
}

bool Route::is_wanted() const {
  return is_forwarded_ || (topic_ && router_.sink_.wants(*topic_)) ||
         std::any_of(uses_.begin(), uses_.end(), [](const Use& use) { return use.user->is_wanted(); });
}

void Router::configure(const Config& config) {
  auto before = std::exchange(routes_, {});
  const auto add = [&](const std::string& name, const OutputTopic* topic) {
    const auto known = std::find_if(before.begin(), before.end(), [&](const auto& one) {
      return one && one->name_ == name && one->topic_.has_value() == (topic != nullptr);
    });
    const bool is_new = known == before.end();
    routes_.push_back(is_new ? std::make_unique<Route>(*this, name) : std::move(*known));
    Route& route = *routes_.back();
    route.uses_.clear();
    route.is_forwarded_ = config.elsewhere.merged.count(name) > 0;
    if (topic == nullptr) return;
    route.topic_ = *topic;
    route.report_.name = name;
    route.report_.promised = topic->promised;
  };
  for (const SensorConfig& sensor : config.sensors) add(sensor.name, nullptr);
  for (const OutputTopic& topic : output_topics(config)) add(topic.name, &topic);
  for (const MergedScanConfig& merged : config.merged_scans) {
    for (const std::string& source : merged.laserscan_topics)
      if (find_source(source) == nullptr) add(source, nullptr);
  }
}

void Router::connect(FrameUser& user, const std::vector<std::string>& sources) {
  std::size_t index = 0;
  for (const std::string& name : sources) source(name).uses_.push_back({&user, index++});
}

Route* Router::find_source(const std::string& name) const {
  for (const auto& route : routes_) {
    if (route->name_ == name) return route.get();
  }
  return nullptr;
}

Route& Router::source(const std::string& name) const {
  if (Route* const found = find_source(name)) return *found;
  throw std::logic_error("no source " + name);
}

Route& Router::topic(const std::string& name) const {
  for (const auto& route : routes_) {
    if (route->topic_ && route->name_ == name) return *route;
  }
  throw std::logic_error("no topic " + name);
}

std::vector<TopicTotals> Router::reports() const {
  std::vector<TopicTotals> reports;
  for (const auto& route : routes_) {
    if (route->topic_) reports.push_back(route->report_);
  }
  return reports;
}

}  // namespace lidard
