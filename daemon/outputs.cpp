// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/outputs.h"

#include <limits>
#include <stdexcept>

namespace lidard {
namespace {

ScanGrid grid_of(const ScanGridSpec& spec) {
  std::string error;
  const auto grid = make_grid(spec, error);
  if (!grid) throw std::logic_error("configuration accepted a grid that is wrong: " + error);
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

DiagnosticItem health_of(const std::string& name, const OutputCounters& counters, Stamp now) {
  DiagnosticItem item;
  item.name = name;
  const double age = seconds(now - counters.last_published);
  if (counters.published == 0) {
    item.health = Health::error;
    item.message =
        counters.no_pose > 0 ? "no output: " + counters.why_no_pose : "no output: no input has come in yet";
  } else if (age > 3) {
    item.health = Health::error;
    item.message = counters.no_pose > 0 ? "no output any more: " + counters.why_no_pose
                                        : "no output for more than 3 s: see the state of its sensors";
  } else {
    item.message = "publishing";
  }
  item.values.emplace_back("Published", std::to_string(counters.published));
  item.values.emplace_back("Inputs without pose", std::to_string(counters.no_pose));
  return item;
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

VirtualOutput::VirtualOutput(const VirtualScanConfig& config, const VehicleConfig& vehicle,
                             const PoseBook& poses)
    : config_(config),
      base_frame_(vehicle.base_frame),
      footprint_(Footprint(vehicle.footprint).padded(Footprint::margin_m)),
      poses_(poses),
      virtualizer_(grid_of(config.output.grid), band_of(config.output)) {
  scan_.none_as = value_of(config.output.empty, config.output);
  scan_.invalid_as = value_of(config.output.unobserved, config.output);
}

const std::string& VirtualOutput::topic_of(const std::string& frame) const {
  return config_.output_laser_topic.empty() ? frame : config_.output_laser_topic;
}

void VirtualOutput::add(const Cloud& cloud, Stamp now, FrameSink& sink) {
  for (const auto& frame : config_.virtual_laser_scan) {
    Pose pose;
    if (!poses_.find(frame, cloud.frame_id, cloud.stamp, pose, counters_.why_no_pose)) {
      ++counters_.no_pose;
      continue;
    }
    if (!footprint_.empty()) {
      Pose base;
      if (!poses_.find(frame, base_frame_, cloud.stamp, base, counters_.why_no_pose)) {
        ++counters_.no_pose;
        continue;
      }
      virtualizer_.set_footprint(footprint_.transformed(base));
    }
    scan_.frame_id = frame;
    virtualizer_.project(cloud, pose, scan_);
    // Several frames on one topic share the cloud's stamp; consumers want stamps that increase.
    Stamp& last = last_stamps_[topic_of(frame)];
    constexpr Span restart_limit = std::chrono::seconds(1);
    if (scan_.stamp <= last && last - scan_.stamp < restart_limit) scan_.stamp = last + Span(1);
    last = scan_.stamp;
    ++counters_.published;
    counters_.last_published = now;
    sink.scan(topic_of(frame), scan_, now);
  }
}

DiagnosticItem VirtualOutput::diagnostics(Stamp now) const {
  return health_of("virtual " + config_.name, counters_, now);
}

}  // namespace lidard
