// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/virtual_output.h"

namespace lidard {

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
