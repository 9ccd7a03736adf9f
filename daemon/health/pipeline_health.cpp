// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/pipeline_health.h"

#include <algorithm>
#include <utility>

#include "daemon/health/output_health.h"
#include "daemon/health/sensor_health.h"

namespace lidard {
namespace {

template <class List, class Value>
bool has(const List& list, const Value& value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

/// Why an output lacks something: its own sentence, and those of the sensors that have never delivered.
std::string why_missing(const MakerStatus& output, const PipelineStatus& all) {
  const DiagnosticItem item = output_health(output, all.now);
  std::string why = item.health == Health::ok ? "" : item.message;
  for (const SensorStatus& sensor : all.sensors) {
    if (item.awaited && sensor.counters.frames == 0 && has(output.sources, sensor.name))
      why += "; " + sensor.name + ": " + sensor_health(sensor, *all.unknown_senders, all.now).message;
  }
  return why;
}

std::string why_missing(const SensorStatus& sensor, const PipelineStatus& all) {
  if (sensor.counters.frames == 0) return sensor_health(sensor, *all.unknown_senders, all.now).message;
  return sensor.gate && sensor.gate->left_out_count() > 0
             ? pose_trouble(*sensor.gate, sensor.config->points_frame)
             : "";
}

std::string why_missing(const PipelineStatus& all, const std::string& topic) {
  for (const MakerStatus& maker : all.makers) {
    if (has(maker.topics, topic)) return why_missing(maker, all);
  }
  for (const SensorStatus& sensor : all.sensors) {
    for (const OutputTopic& own : sensor_topics(*sensor.config))
      if (own.name == topic) return why_missing(sensor, all);
  }
  return {};
}

/// What is silent by now is reported, also just after a start.
PipelineStatus final_status(const Pipeline& pipeline) {
  PipelineStatus status = pipeline.status(pipeline.now());
  for (SensorStatus& sensor : status.sensors) sensor.starting = false;
  for (MakerStatus& maker : status.makers) maker.starting = false;
  return status;
}

}  // namespace

std::vector<DiagnosticItem> items_of(const Pipeline& pipeline, Stamp now) {
  const PipelineStatus status = pipeline.status(now);
  std::vector<DiagnosticItem> items;
  for (const SensorStatus& sensor : status.sensors)
    items.push_back(sensor_health(sensor, *status.unknown_senders, now));
  if (status.motion) items.push_back(motion_health(*status.motion));
  for (const MakerStatus& maker : status.makers) items.push_back(output_health(maker, now));
  if (const auto names = status.unknown_senders->names(now - UnknownSenders::expires_after); !names.empty())
    items.push_back(unknown_senders_item(names));
  return items;
}

std::string why_missing(const Pipeline& pipeline, const std::string& topic) {
  return why_missing(final_status(pipeline), topic);
}

std::vector<TopicTotals> topic_totals(const Pipeline& pipeline) {
  const PipelineStatus status = final_status(pipeline);
  std::vector<TopicTotals> reports = pipeline.topic_totals();
  for (TopicTotals& report : reports) report.remark = why_missing(status, report.name);
  return reports;
}

HealthReporter::HealthReporter(Pipeline& pipeline, DiagnosticSink& sink,
                               std::function<void(std::vector<DiagnosticItem>&)> add_items)
    : pipeline_(pipeline) {
  pipeline.set_reporter([&pipeline, &sink, add_items = std::move(add_items)](Stamp now) {
    std::vector<DiagnosticItem> items = items_of(pipeline, now);
    if (add_items) add_items(items);
    sink.diagnostics(items, now);
  });
}

}  // namespace lidard
