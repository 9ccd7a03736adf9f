// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_frames.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "drivers/driver_base.h"

namespace lidard::sick {
namespace {

/// Duration of a turn of the mirror from the measurement frequency, s; 0 unknown.
double turn_by_measurements(const ColaScan& scan, double step_deg) {
  return scan.measurement_hz > 0 && step_deg > 0 ? 360 / step_deg / scan.measurement_hz : 0;
}

/// Time between neighbouring beams. The scan frequency is the exact one; the number of scans per turn is that
/// of the row, unless the measurement frequency contradicts it.
double beam_period(const ColaScan& scan, const ColaRow& row, double step_deg) {
  if (!(scan.scan_hz > 0)) return 0;
  constexpr double tolerance = 0.02;
  const double period = 1 / scan.scan_hz;
  const double measured = turn_by_measurements(scan, step_deg);
  double turn = row.turn * period;
  for (int scans = 1; scans <= 4; ++scans) {
    if (measured > 0 && std::abs(measured - scans * period) <= tolerance * measured) turn = scans * period;
  }
  return turn * step_deg / 360;
}

}  // namespace

double exact_step_deg(double sent) {
  constexpr double half_unit = 0.5e-4;
  for (int parts = 1; parts <= 3 && sent > 0; ++parts) {
    const double exact = parts / std::round(parts / sent);
    if (std::abs(exact - sent) <= half_unit) return exact;
  }
  return sent;
}

double ColaGeometry::angle(const ColaRow& row, double beam) const {
  const double deg = start_deg + step_deg * beam + row.shift_deg;
  return (row.mirrored ? -deg : deg) * rad_per_deg;
}

Span ColaGeometry::sweep() const {
  return span_from_seconds(beam_period * static_cast<double>(beams == 0 ? 0 : beams - 1));
}

bool ColaGeometry::is_interlaced_with(const ColaGeometry& other) const {
  ColaGeometry same = other;
  same.start_deg = start_deg;
  return same == *this && std::abs(start_deg - other.start_deg) < step_deg;
}

bool operator==(const ColaGeometry& a, const ColaGeometry& b) {
  return a.beams == b.beams && a.echoes == b.echoes && a.start_deg == b.start_deg &&
         a.step_deg == b.step_deg && a.scan_hz == b.scan_hz && a.beam_period == b.beam_period;
}

bool read_geometry(const ColaScan& scan, const ColaRow& row, ColaGeometry& geometry) {
  const ColaChannel* const first = scan.echo_count() > 0 ? &scan.distance(0) : nullptr;
  if (first == nullptr || first->values.empty() || !(first->step_deg > 0)) return false;
  geometry.beams = first->values.size();
  geometry.echoes = scan.echo_count();
  geometry.start_deg = first->start_deg;
  geometry.step_deg = exact_step_deg(first->step_deg);
  geometry.scan_hz = scan.scan_hz;
  geometry.beam_period = beam_period(scan, row, geometry.step_deg);
  constexpr double full_turn = 360.5;
  if (geometry.step_deg * static_cast<double>(geometry.beams - 1) > full_turn) return false;
  for (std::size_t i = 1; i < geometry.echoes; ++i) {
    const ColaChannel& other = scan.distance(i);
    if (other.values.size() != geometry.beams || other.start_deg != first->start_deg ||
        other.step_deg != first->step_deg)
      return false;
  }
  return true;
}

std::string describe(const ColaGeometry& g) {
  return printed("%zu beams from %.4f deg in steps of %.5f deg, %.2f Hz", g.beams, g.start_deg, g.step_deg,
                 g.scan_hz);
}

BeamStatus status_of_raw(std::uint16_t raw, const ColaRow& row) {
  if (raw >= first_distance) return BeamStatus::hit;
  return raw == 0 && !row.zero_is_unknown ? BeamStatus::none : BeamStatus::invalid;
}

ColaScanBuilder::ColaScanBuilder(const DriverConfig& config, const ColaRow& row)
    : config_(config), row_(row) {
  prepare_scan(config, scan_);
}

/// Converts the formulas of AngleCompensation to angles r of the ROS frame. With the shift s,
/// a = r - s of a device that counts like ROS (`subtracted`), and a = -r - s of one that counts clockwise
/// (`added`); with e = r - O both are e +- A sin(e + O +- s + P).
void ColaScanBuilder::compensate(const ColaAngleCompensation& compensation) {
  const double sign = row_.mirrored ? 1 : -1;
  offset_ = compensation.offset_deg * rad_per_deg;
  scan_.wave.amplitude = sign * compensation.amplitude_deg * rad_per_deg;
  scan_.wave.phase = offset_ + (sign * row_.shift_deg + compensation.phase_deg) * rad_per_deg;
}

bool ColaScanBuilder::choose(const ColaGeometry& geometry) {
  const double start = geometry.angle(row_, 0) - offset_;
  window_ = beams_inside(config_.sector(), start, geometry.angle(row_, 1) - offset_ - start, geometry.beams);
  const double first = geometry.angle(row_, static_cast<double>(window_.first)) - offset_;
  const double next = geometry.angle(row_, static_cast<double>(window_.first) + 1) - offset_;
  echoes_ = config_.publish_multiecho ? geometry.echoes : 1;
  scan_.beams = window_.count;
  scan_.set_angles(static_cast<float>(first), static_cast<float>(next - first));
  scan_.scan_time = geometry.scan_hz > 0 ? static_cast<float>(1 / geometry.scan_hz) : 0;
  scan_.time_increment = static_cast<float>(geometry.beam_period);
  return window_.count > 0;
}

PlanarScan& ColaScanBuilder::fill(const ColaScan& telegram) {
  const ColaChannel* rssi = telegram.intensity(0);
  scan_.reset(scan_.beams, echoes_, config_.publish_intensity && rssi != nullptr);
  // The way to a later echo leads through the first one, wherever that is.
  if (telegram.echo(0) != 0) scan_.free_from.assign(scan_.beams, scan_.range_max);
  for (std::size_t echo = 0; echo < echoes_; ++echo) fill_echo(telegram, echo);
  scan_.hide_gap(window_);
  return scan_;
}

void ColaScanBuilder::fill_echo(const ColaScan& telegram, std::size_t echo) {
  const ColaChannel& distance = telegram.distance(echo);
  const bool without_first = telegram.echo(0) != 0;
  const ColaChannel* rssi = scan_.intensities.empty() ? nullptr : telegram.intensity(echo);
  if (rssi != nullptr && rssi->values.size() != distance.values.size()) rssi = nullptr;
  constexpr double metres = 1e-3;
  for (std::size_t i = 0; i < scan_.beams; ++i) {
    const std::size_t from = window_.first + i;
    const std::size_t at = scan_.index(i, echo);
    if (rssi != nullptr) scan_.intensities[at] = static_cast<float>(rssi->value(from));
    const BeamStatus status = status_of_raw(distance.values[from], row_);
    if (status == BeamStatus::hit)
      scan_.set_measured(at, static_cast<float>(distance.value(from) * metres));
    else
      scan_.set_without_hit(at, without_first ? BeamStatus::invalid : status);
  }
}

namespace {

/// Planes of an MRS1000 from the lowest to the highest, as the telegram has them: 1/100 deg, positive
/// downwards. SICK 8020494 p. 24 prints FF06, FA, FE0C hex without a sign; the sign follows from clouds of an
/// MRS1104 that sick_scan_xd published: the planes lie at -2.5, 0, 2.5 and 5 deg.
constexpr std::array<std::int16_t, 4> planes = {250, 0, -250, -500};
constexpr std::size_t no_ring = planes.size();
/// Elevation of a plane, rad, positive upwards.
double elevation_of(std::size_t ring) { return -planes[ring] / 100.0 * rad_per_deg; }
/// The telegrams of the planes come in the order 250, -500, 0, -250. A cloud begins with the first of them,
/// so that its telegrams do not depend on the start of the connection.
constexpr std::size_t first_ring = 0;
constexpr std::uint32_t all_rings = (1U << planes.size()) - 1;
/// ANGL1: correction of the evenly spaced angle, in 1/10000 deg.
constexpr double correction_deg = 1e-4;

std::size_t ring_of(std::int16_t layer) {
  return static_cast<std::size_t>(std::find(planes.begin(), planes.end(), layer) - planes.begin());
}

}  // namespace

bool is_plane_of_mrs1000(std::int16_t layer) { return ring_of(layer) != no_ring; }

ColaCloudBuilder::ColaCloudBuilder(const DriverConfig& config, const ColaRow& row, Counters& counters)
    : config_(config),
      row_(row),
      counters_(counters),
      range_min_(std::max(config.min_range, config.model->range_min)),
      range_max_(config.max_range > 0 ? std::min(config.max_range, config.model->range_max)
                                      : config.model->range_max) {
  cloud_.frame_id = config.frame_id;
  cloud_.max_range = config.max_range;
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
                           const ColaClock& clock, FrameReceiver& out) {
  const std::size_t ring = ring_of(telegram.layer);
  if (ring == no_ring) return false;
  choose(geometry);
  const std::uint32_t bit = 1U << ring;
  const bool same_turn = first >= begun_ && seconds(first - begun_) < config_.model->frame_period;
  if (ring == first_ring || (seen_ & bit) != 0 || !same_turn) finish(out);
  if (seen_ == 0) {
    begin(clock.to_host(first) + config_.time_offset);
    begun_ = first;
  }
  append(telegram, ring, first, clock);
  seen_ |= bit;
  ++packet_;
  if (seen_ == all_rings) finish(out);
  return true;
}

void ColaCloudBuilder::finish(FrameReceiver& out) {
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
  std::array<std::pair<const ColaChannel*, const ColaChannel*>, distance_names.size()> echoes{};
  for (std::size_t echo = 0; echo < geometry_.echoes; ++echo)
    echoes.at(echo) = {&telegram.distance(echo), telegram.intensity(echo)};
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
      append_return(*echoes[echo].first, echoes[echo].second, beam, azimuth_deg,
                    static_cast<std::uint16_t>(ring), fired);
      // Second and third echoes are rare: drop their columns without a point.
      if (echo > 0 && cloud_.columns.back().first_point == cloud_.size()) cloud_.columns.pop_back();
    }
    cloud_.end = std::max(cloud_.end, fired);
  }
  corrected_ = correction != nullptr;
}

void ColaCloudBuilder::append_return(const ColaChannel& distance, const ColaChannel* rssi, std::size_t beam,
                                     double azimuth_deg, std::uint16_t ring, Stamp fired) {
  if (distance.values[beam] < first_distance) return;
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
  // A clock that was set within a frame may put a plane before the first one.
  point.time = std::max(0.0F, static_cast<float>(seconds(fired - cloud_.stamp)));
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&point);
  cloud_.points_bytes.insert(cloud_.points_bytes.end(), bytes, bytes + sizeof point);
  if (!config_.keep_origins) return;
  cloud_.origins.push_back({static_cast<std::uint32_t>(cloud_.columns.size() - 1), ring, 0, azimuth_deg,
                            range, offset_ns_, fired});
}

}  // namespace lidard::sick
