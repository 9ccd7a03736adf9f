// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/merged_output.h"

namespace lidard {
namespace {

MergeSettings settings_of(const MergedScanConfig& config) {
  MergeSettings settings;
  settings.points = config.output.profile == Profile::flatten || !config.cloud_destination_topic.empty();
  settings.sight = config.output.profile != Profile::flatten;
  for (const AlsoScanConfig& also : config.also) {
    settings.points |= also.profile == Profile::flatten;
    settings.sight |= also.profile != Profile::flatten;
  }
  settings.how.noise = settings.source.noise = config.range_noise;
  settings.how.mean = config.mean;
  settings.how.free_required = config.free_required;
  settings.source.echoes = config.echoes;
  settings.source.veil_filter = config.veil_filter;
  return settings;
}

}  // namespace

MergedOutput::MergedOutput(const MergedScanConfig& config, const VehicleConfig& vehicle,
                           const PoseBook& poses)
    : config_(config),
      base_frame_(vehicle.base_frame),
      footprint_(vehicle.footprint),
      poses_(poses),
      merger_(grid_of(config.output.grid), band_of(config.output), config.laserscan_topics.size(),
              config.lost_after, settings_of(config)),
      scans_(1 + config.also.size()) {
  cloud_.frame_id = config.destination_frame;
  merged_.push_back({config.output.profile, &scans_[0]});
  scans_[0].none_as = value_of(config.output.empty, config.output);
  scans_[0].invalid_as = value_of(config.output.unobserved, config.output);
  for (std::size_t i = 0; i < config.also.size(); ++i) {
    merged_.push_back({config.also[i].profile, &scans_[i + 1]});
    scans_[i + 1].none_as = value_of(config.also[i].empty, config.output);
    scans_[i + 1].invalid_as = value_of(config.also[i].unobserved, config.output);
  }
  for (PlanarScan& scan : scans_) scan.frame_id = config.destination_frame;
}

bool MergedOutput::place_footprint(Stamp stamp) {
  if (footprint_.empty()) return true;
  Pose pose;
  if (!poses_.find(config_.destination_frame, base_frame_, stamp, pose, counters_.why_no_pose)) return false;
  if (footprint_placed_ && footprint_placed_->matrix() == pose.matrix()) return true;
  footprint_placed_ = pose;
  merger_.set_footprint(footprint_.transformed(pose));
  return true;
}

int MergedOutput::source_index(const std::string& sensor) const {
  for (std::size_t i = 0; i < config_.laserscan_topics.size(); ++i) {
    if (config_.laserscan_topics[i] == sensor) return static_cast<int>(i);
  }
  return -1;
}

void MergedOutput::add(std::size_t source, const PlanarScan& scan, Stamp now, FrameSink& sink) {
  Pose pose;
  if (!place_footprint(scan.stamp) ||
      !poses_.find(config_.destination_frame, scan.frame_id, scan.stamp, pose, counters_.why_no_pose)) {
    ++counters_.no_pose;
    return;
  }
  if (!merger_.add(source, scan, pose)) return;
  const bool with_cloud = !config_.cloud_destination_topic.empty();
  merger_.merge(merged_, with_cloud ? &cloud_ : nullptr);
  ++counters_.published;
  counters_.last_published = now;
  sink.scan(config_.scan_destination_topic, scans_[0], now);
  for (std::size_t i = 0; i < config_.also.size(); ++i) sink.scan(config_.also[i].topic, scans_[i + 1], now);
  if (with_cloud) sink.cloud(config_.cloud_destination_topic, cloud_, now);
}

DiagnosticItem MergedOutput::diagnostics(Stamp now) const {
  DiagnosticItem item = health_of("merged " + config_.name, counters_, now);
  std::string lost;
  for (std::size_t i = 0; i < config_.laserscan_topics.size(); ++i) {
    if (!merger_.alive(i)) lost += (lost.empty() ? "" : ", ") + config_.laserscan_topics[i];
  }
  if (item.health == Health::ok && !lost.empty()) {
    item.health = Health::error;
    item.message = "publishing without " + lost;
  }
  item.values.emplace_back("Sources lost", lost);
  item.values.emplace_back("Sweeps replaced before use", std::to_string(merger_.superseded()));
  item.values.emplace_back("Sweeps out of order", std::to_string(merger_.out_of_order()));
  return item;
}

}  // namespace lidard
