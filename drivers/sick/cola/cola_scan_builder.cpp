// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_scan_builder.h"

#include "core/frames/beam_window.h"
#include "drivers/model.h"

namespace lidard::sick {
ColaScanBuilder::ColaScanBuilder(const DriverConfig& config, const ColaRow& row)
    : config_(config), row_(row) {
  scan_.frame_id = config.frame_id;
  scan_.range_min = static_cast<float>(config.model->range_min);
  scan_.range_max = static_cast<float>(config.model->range_max);
}

bool ColaScanBuilder::choose(const ColaGeometry& geometry) {
  const double start = geometry.angle(row_, 0);
  const BeamWindow kept = beams_between(start, geometry.angle(row_, 1) - start, geometry.beams,
                                        config_.angle_min, config_.angle_max);
  first_beam_ = kept.first;
  const double first = geometry.angle(row_, static_cast<double>(first_beam_));
  const double next = geometry.angle(row_, static_cast<double>(first_beam_) + 1);
  echoes_ = config_.publish_multiecho ? geometry.echoes : 1;
  scan_.beams = kept.count;
  scan_.set_angles(static_cast<float>(first), static_cast<float>(next - first));
  scan_.scan_time = geometry.scan_hz > 0 ? static_cast<float>(1 / geometry.scan_hz) : 0;
  scan_.time_increment = static_cast<float>(geometry.beam_period);
  return kept.count > 0;
}

PlanarScan& ColaScanBuilder::fill(const ColaScan& telegram) {
  const ColaChannel* rssi = telegram.channel("RSSI1");
  scan_.reset(scan_.beams, echoes_, config_.publish_intensity && rssi != nullptr);
  for (std::size_t echo = 0; echo < echoes_; ++echo) fill_echo(telegram, echo);
  return scan_;
}

void ColaScanBuilder::fill_echo(const ColaScan& telegram, std::size_t echo) {
  const ColaChannel& distance = *telegram.channel(distance_names[echo]);
  const ColaChannel* rssi = scan_.intensities.empty() ? nullptr : telegram.channel(intensity_names[echo]);
  if (rssi != nullptr && rssi->values.size() != distance.values.size()) rssi = nullptr;
  constexpr double metres = 1e-3;
  for (std::size_t i = 0; i < scan_.beams; ++i) {
    const std::size_t from = first_beam_ + i;
    const std::size_t at = scan_.index(i, echo);
    if (rssi != nullptr) scan_.intensities[at] = static_cast<float>(rssi->value(from));
    const BeamStatus status = status_of_raw(distance.values[from]);
    if (status == BeamStatus::hit)
      scan_.set_measured(at, static_cast<float>(distance.value(from) * metres));
    else
      scan_.set_without_hit(at, status);
  }
}

}  // namespace lidard::sick
