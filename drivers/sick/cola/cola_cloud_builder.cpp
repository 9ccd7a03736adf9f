// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_cloud_builder.h"

#include <algorithm>
#include <cmath>

#include "drivers/model.h"

namespace lidard::sick {
namespace {

/// Planes of an MRS1000 from the lowest to the highest, as the telegram has them: 1/100 deg, positive
/// downwards. SICK 8020494 p. 24 prints FF06, FA, FE0C hex and no sign; the sign is that of the clouds which
/// SICK's own driver (sick_scan_xd) published of an MRS1104: the planes lie at -2.5, 0, 2.5 and 5 deg.
constexpr std::array<std::int16_t, 4> planes = {250, 0, -250, -500};
constexpr std::size_t no_ring = planes.size();
/// Elevation of a plane, rad, positive upwards.
double elevation_of(std::size_t ring) { return -planes[ring] / 100.0 * rad_per_deg; }
/// The telegrams of the planes follow each other as 250, -500, 0, -250: a cloud begins with the first of
/// them, so that its telegrams do not depend on when one starts to listen.
constexpr std::size_t first_ring = 0;
constexpr std::uint32_t all_rings = (1U << planes.size()) - 1;
/// ANGL1: what to add to the evenly spaced angle, in 1/10000 deg.
constexpr double correction_deg = 1e-4;

std::size_t ring_of(std::int16_t layer) {
  return static_cast<std::size_t>(std::find(planes.begin(), planes.end(), layer) - planes.begin());
}

}  // namespace

ColaCloudBuilder::ColaCloudBuilder(const DriverConfig& config, const ColaRow& row, Counters& counters)
    : config_(config),
      row_(row),
      counters_(counters),
      range_min_(std::max(config.min_range, config.model->range_min)),
      range_max_(config.max_range > 0 ? std::min(config.max_range, config.model->range_max)
                                      : config.model->range_max) {
  cloud_.frame_id = config.frame_id;
  cloud_.rings = planes.size();
}

void ColaCloudBuilder::clear() {
  seen_ = 0;
  cloud_.clear();
}

void ColaCloudBuilder::begin(Stamp stamp) {
  cloud_.clear();
  cloud_.stamp = stamp;
  cloud_.end = stamp;
  seen_ = 0;
}

void ColaCloudBuilder::choose(const ColaGeometry& geometry) {
  if (geometry == geometry_ && !corrected_) return;
  corrected_ = false;
  geometry_ = geometry;
  directions_.resize(geometry.beams);
  for (std::size_t i = 0; i < geometry.beams; ++i) {
    const double angle = geometry.angle(row_, static_cast<double>(i));
    directions_[i] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
  }
}

bool ColaCloudBuilder::add(const ColaScan& telegram, const ColaGeometry& geometry, Span first,
                           const ColaClock& clock, DriverOutput& out) {
  const std::size_t ring = ring_of(telegram.layer);
  if (ring == no_ring) return false;
  choose(geometry);
  const std::uint32_t bit = 1U << ring;
  if (ring == first_ring || (seen_ & bit) != 0) finish(out);
  if (seen_ == 0) begin(clock.to_host(first) + config_.time_offset);
  append(telegram, ring, first, clock);
  seen_ |= bit;
  ++packet_;
  if (seen_ == all_rings) finish(out);
  return true;
}

void ColaCloudBuilder::finish(DriverOutput& out) {
  if (seen_ == 0) return;
  cloud_.complete = seen_ == all_rings;
  seen_ = 0;
  if (!cloud_.complete) ++counters_.partial_frames;
  if (!cloud_.complete && !config_.keep_partial) return;
  cloud_.expected_columns = geometry_.beams * planes.size();
  ++counters_.frames;
  out.cloud(cloud_);
}

void ColaCloudBuilder::append(const ColaScan& telegram, std::size_t ring, Span first,
                              const ColaClock& clock) {
  const ColaChannel* correction = telegram.channel("ANGL1");
  if (correction != nullptr && correction->values.size() != geometry_.beams) correction = nullptr;
  const Stamp begin_stamp = clock.to_host(first) + config_.time_offset;
  for (std::size_t beam = 0; beam < geometry_.beams; ++beam) {
    const Span after = span_from_seconds(geometry_.beam_period * static_cast<double>(beam));
    const Stamp fired = begin_stamp + after;
    offset_ns_ = after.count();
    double azimuth_deg = geometry_.start_deg + geometry_.step_deg * static_cast<double>(beam);
    if (correction != nullptr) {
      azimuth_deg += correction_deg * correction->value(beam);
      const double angle = geometry_.angle(row_, (azimuth_deg - geometry_.start_deg) / geometry_.step_deg);
      directions_[beam] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
    }
    for (std::size_t echo = 0; echo < geometry_.echoes; ++echo) {
      cloud_.columns.push_back({static_cast<std::uint32_t>(cloud_.size()), packet_, 0,
                                static_cast<std::uint8_t>(echo),
                                static_cast<float>(azimuth_deg * rad_per_deg), fired});
      append_return(*telegram.channel(distance_names[echo]), telegram.channel(intensity_names[echo]), beam,
                    azimuth_deg, static_cast<std::uint16_t>(ring), fired);
      // Second and third echoes are rare: no column of theirs without a point.
      if (echo > 0 && cloud_.columns.back().first_point == cloud_.size()) cloud_.columns.pop_back();
    }
    cloud_.end = std::max(cloud_.end, fired);
  }
  corrected_ = correction != nullptr;
}

void ColaCloudBuilder::append_return(const ColaChannel& distance, const ColaChannel* rssi, std::size_t beam,
                                     double azimuth_deg, std::uint16_t ring, Stamp fired) {
  if (status_of_raw(distance.values[beam]) != BeamStatus::hit) return;
  const double range = distance.value(beam) * 1e-3;
  if (range < range_min_ || range > range_max_) return;
  const auto [cosine, sine] = directions_[beam];
  if (config_.view_width < two_pi && !config_.in_view(std::atan2(sine, cosine))) return;
  const double elevation = elevation_of(ring);
  const auto flat = static_cast<float>(range * std::cos(elevation));
  CloudPoint point{};
  point.x = flat * cosine;
  point.y = flat * sine;
  point.z = static_cast<float>(range * std::sin(elevation));
  const bool has_rssi = rssi != nullptr && rssi->values.size() > beam;
  point.intensity = has_rssi ? static_cast<float>(rssi->value(beam)) : 0;
  point.ring = ring;
  // Clocks that were set within a frame may put a plane before the first one.
  point.time = std::max(0.0F, static_cast<float>(seconds(fired - cloud_.stamp)));
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&point);
  cloud_.points_bytes.insert(cloud_.points_bytes.end(), bytes, bytes + sizeof point);
  if (!config_.keep_origins) return;
  cloud_.origins.push_back({static_cast<std::uint32_t>(cloud_.columns.size() - 1), ring, 0, azimuth_deg,
                            range, offset_ns_, fired});
}

}  // namespace lidard::sick
