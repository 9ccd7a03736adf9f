// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/python/replay_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "daemon/files/json_text.h"
#include "daemon/health/pipeline_health.h"
#include "daemon/offline/remarks.h"
#include "daemon/offline/survey_json.h"

namespace lidard::python {

ReplayReader::Run::Run(const Config& config, const std::vector<std::string>& captures,
                       const std::string& motion_file, FrameSink& sink)
    : motion(motion_file, config.vehicle),
      capture(captures),
      pipeline(config, motion, sink),
      player(options, capture, pipeline) {
  options.rate = 0;
  player.rest = [](auto) {};
  player.on_time = [this](Stamp now) { motion.feed(pipeline, now); };
}

ReplayReader::ReplayReader(Config config, const std::vector<std::string>& captures, const std::string& motion,
                           std::set<std::string> topics)
    : config_(std::move(config)), topics_(std::move(topics)) {
  std::set<std::string> known;
  for (const OutputTopic& topic : output_topics(config_)) known.insert(topic.name);
  for (const std::string& topic : topics_) {
    if (known.count(topic) > 0) continue;
    throw std::runtime_error(
        fmt::format("no topic {} in the configuration; expected one of {}", topic, fmt::join(known, ", ")));
  }
  for (const SensorConfig& sensor : config_.sensors) {
    for (const OutputTopic& topic : sensor_topics(sensor)) sensor_of_[topic.name] = sensor.name;
  }
  warnings_ = remarks_on(config_);
  run_ = std::make_unique<Run>(config_, captures, motion, *this);
}

bool ReplayReader::advance() {
  if (run_->player.step([] { return false; })) return true;
  run_->player.finish();
  const auto errors = run_->capture.errors();
  warnings_.insert(warnings_.end(), errors.begin(), errors.end());
  error_ = what_is_missing();
  last_sensors_ = sensors_json();
  free();
  return false;
}

std::string ReplayReader::what_is_missing() const {
  std::string all;
  for (const TopicTotals& output : topic_totals(run_->pipeline)) {
    if (output.messages > 0 || !output.promised) continue;
    all += (all.empty() ? "" : "\n") + output.name + ": " +
           (output.remark.empty() ? "nothing of its kind came" : output.remark);
  }
  return all;
}

std::string ReplayReader::sensors_json() const {
  if (run_ == nullptr) return last_sensors_;
  nlohmann::ordered_json all = nlohmann::ordered_json::object();
  for (const SensorStatus& sensor : run_->pipeline.status(run_->pipeline.now()).sensors)
    all[sensor.name] = json_of(sensor.model, sensor.counters, sensor.info);
  return json_text(all);
}

bool ReplayReader::wants(const OutputTopic& topic) const {
  return topics_.empty() || topics_.count(topic.name) > 0;
}

void ReplayReader::publish(const OutputTopic& topic, const lidard::Frame& frame, Stamp /*released*/) {
  if (!wants(topic)) return;
  const auto known = sensor_of_.find(topic.name);
  const std::string& sensor = known == sensor_of_.end() ? std::string() : known->second;
  if (const PlanarScan* const scan = frame.scan()) {
    add(sensor, *scan, topic.name);
  } else if (Cloud* const cloud = frame.cloud()) {
    std::vector<CloudColumn> columns = cloud->columns;
    add(sensor, *cloud, columns, topic.name);
  } else if (MergedCloud* const merged = frame.merged_cloud()) {
    add(*merged, topic.name);
  }
}

}  // namespace lidard::python
