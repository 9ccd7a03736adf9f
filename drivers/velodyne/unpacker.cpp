// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/unpacker.h"

#include <algorithm>
#include <cmath>

#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {
namespace {

constexpr double rad_per_deg = 3.14159265358979323846 / 180;

std::uint16_t distance_count(const std::uint8_t* slot) {
  return static_cast<std::uint16_t>(slot[0] | slot[1] << 8U);
}

}  // namespace

Unpacker::Unpacker(const ModelRow& row, bool keep_origins, double min_range, double max_range,
                   const Calibration* calibration)
    : row_(row), keep_origins_(keep_origins) {
  // A count of 0 is the wire's "no return", so it is never inside.
  if (calibration != nullptr) geometry_.emplace(*calibration);
  const double step = calibration != nullptr ? calibration->distance_step_m : row.distance_step_m;
  nearest_ = static_cast<std::uint16_t>(std::clamp(std::ceil(min_range / step - 1e-9), 1.0, 65535.0));
  const double farthest = max_range > 0 ? std::floor(max_range / step + 1e-9) : 65535.0;
  span_ = static_cast<std::uint16_t>(std::clamp(farthest, static_cast<double>(nearest_), 65535.0) - nearest_);
  const auto rings = calibration != nullptr ? rings_by_elevation(*calibration) : rings_by_elevation(row);
  for (std::size_t k = 0; k < row.lasers; ++k) {
    const Laser& laser = row.laser[k];
    LaserTable table{};
    table.cos_elevation = static_cast<float>(std::cos(laser.elevation_deg * rad_per_deg) * step);
    table.sin_elevation = static_cast<float>(std::sin(laser.elevation_deg * rad_per_deg) * step);
    table.z_offset = static_cast<float>(laser.z_offset_mm * 1e-3);
    table.cos_rot = static_cast<float>(std::cos(laser.rot_correction_deg * rad_per_deg));
    table.sin_rot = static_cast<float>(-std::sin(laser.rot_correction_deg * rad_per_deg));
    table.ring = rings[k];
    lasers_.push_back(table);
  }
  origins_.resize(row.lasers);
  for (std::size_t k = 0; k < row.lasers; ++k) {
    origins_[k].rot_deg =
        geometry_ ? geometry_->rot_correction(k) / rad_per_deg : row.laser[k].rot_correction_deg;
  }
  set_limits(min_range, max_range, step);
  set_timing(row.timings.front());
}

/// The limits are those of the true distance: each laser's correction decides which counts lie within.
void Unpacker::set_limits(double min_range, double max_range, double step) {
  constexpr double most = 65535;
  for (std::size_t k = 0; k < origins_.size(); ++k) {
    const double at_zero = geometry_ ? geometry_->distance(k, 0) : 0;
    // A count of 0 is the wire's "no return", so it is never inside.
    const double nearest = std::clamp(std::ceil((min_range - at_zero) / step - 1e-9), 1.0, most);
    const double farthest = max_range > 0 ? std::floor((max_range - at_zero) / step + 1e-9) : most;
    origins_[k].nearest = static_cast<std::uint16_t>(nearest);
    origins_[k].farthest = static_cast<std::uint16_t>(std::clamp(farthest, 0.0, most));
  }
}

void Unpacker::set_timing(const Timing& timing) {
  for (std::size_t k = 0; k < lasers_.size(); ++k) {
    origins_[k].firing = row_.firing_time(timing, k);
    lasers_[k].time = static_cast<float>(seconds(origins_[k].firing));
    // The block's azimuth is that of its first firing, wherever the stamp stands.
    origins_[k].turning_s = seconds(origins_[k].firing + timing.before);
    lasers_[k].turning = static_cast<float>(origins_[k].turning_s);
  }
  const double rate = rate_;
  rate_ = -1;
  set_rate(rate);
}

void Unpacker::set_rate(double deg_per_s) {
  if (deg_per_s == rate_) return;
  rate_ = deg_per_s;
  const auto rate = static_cast<float>(deg_per_s * rad_per_deg);
  for (LaserTable& table : lasers_) {
    // The turn within a sequence stays below 2 deg at 1200 rpm: the series are exact to 1e-7.
    const float turn = rate * table.turning;
    const float square = turn * turn;
    const float cos_turn = 1 - square * (0.5F - square / 24);
    const float sin_turn = turn * (1 - square / 6);
    table.cos_shift = table.cos_rot * cos_turn - table.sin_rot * sin_turn;
    table.sin_shift = table.sin_rot * cos_turn + table.cos_rot * sin_turn;
  }
  if (!keep_origins_ && !geometry_) return;
  for (std::size_t k = 0; k < origins_.size(); ++k) {
    const double turn_deg = rate_ * origins_[k].turning_s;
    origins_[k].shift_deg = turn_deg - origins_[k].rot_deg;
    origins_[k].cos_turn = std::cos(turn_deg * rad_per_deg);
    origins_[k].sin_turn = std::sin(turn_deg * rad_per_deg);
  }
}

void Unpacker::reserve_packet(Cloud& cloud) const {
  const std::size_t needed = (cloud.columns.empty() ? 0 : cloud.columns.back().first_point + row_.lasers) +
                             blocks_per_packet * slots_per_block;
  // Grows in big steps: a revolution at the usual 600 rpm has 76 packets of a VLP-16.
  constexpr std::size_t step = 8 * blocks_per_packet * slots_per_block;
  if (cloud.size() < needed) cloud.points_bytes.resize((needed + step) * sizeof(CloudPoint));
}

void Unpacker::append(const Sequence& sequence, Cloud& cloud, std::size_t& points) const {
  CloudColumn column{};
  column.first_point = static_cast<std::uint32_t>(points);
  column.packet = sequence.packet;
  column.block = sequence.blocks[0];
  column.echo = sequence.echo;
  column.azimuth = static_cast<float>(sequence.azimuth_deg * rad_per_deg);
  column.stamp = sequence.stamp;
  cloud.columns.push_back(column);
  if (geometry_) {
    append_calibrated(sequence, cloud, points);
    if (keep_origins_) append_origins(sequence, cloud);
    return;
  }

  const double alpha = sequence.azimuth_deg * rad_per_deg;
  const auto cos_a = static_cast<float>(std::cos(alpha));
  const auto sin_a = static_cast<float>(std::sin(alpha));
  const auto begin = static_cast<float>(seconds(sequence.in_frame));
  const std::size_t per_bank = row_.lasers / row_.banks;
  CloudPoint* out = cloud.points() + points;
  const LaserTable* laser = lasers_.data();
  for (std::size_t bank = 0; bank < row_.banks; ++bank) {
    const std::uint8_t* slot = sequence.slots[bank];
    for (std::size_t k = 0; k < per_bank; ++k, ++laser, slot += 3) {
      const std::uint16_t count = distance_count(slot);
      const float cos_alpha = cos_a * laser->cos_shift - sin_a * laser->sin_shift;
      const float sin_alpha = sin_a * laser->cos_shift + cos_a * laser->sin_shift;
      const auto distance = static_cast<float>(count);
      const float xy = distance * laser->cos_elevation;
      // Written also where there is no return, then overwritten: a branch per slot costs more.
      out->x = xy * cos_alpha;
      out->y = -xy * sin_alpha;
      out->z = distance * laser->sin_elevation + laser->z_offset;
      out->intensity = static_cast<float>(slot[2]);
      out->ring = laser->ring;
      out->time = begin + laser->time;
      out += is_return(count) ? 1 : 0;
    }
  }
  points = static_cast<std::size_t>(out - cloud.points());
  if (keep_origins_) append_origins(sequence, cloud);
}

/// With a calibration of the very sensor: its equations for each return, in double.
void Unpacker::append_calibrated(const Sequence& sequence, Cloud& cloud, std::size_t& points) const {
  const double alpha = sequence.azimuth_deg * rad_per_deg;
  const double cos_a = std::cos(alpha);
  const double sin_a = std::sin(alpha);
  const auto begin = static_cast<float>(seconds(sequence.in_frame));
  const std::size_t per_bank = row_.lasers / row_.banks;
  for (std::size_t k = 0; k < lasers_.size(); ++k) {
    const std::uint8_t* slot = sequence.slots[k / per_bank] + 3 * (k % per_bank);
    const std::uint16_t count = distance_count(slot);
    const LaserOrigin& turn = origins_[k];
    if (!is_return(turn, count)) continue;
    const CalibratedPoint p =
        geometry_->place(k, count, slot[2], cos_a * turn.cos_turn - sin_a * turn.sin_turn,
                         sin_a * turn.cos_turn + cos_a * turn.sin_turn);
    cloud.points()[points++] = {p.x, p.y, p.z, p.intensity, lasers_[k].ring, begin + lasers_[k].time};
  }
}

void Unpacker::append_origins(const Sequence& sequence, Cloud& cloud) const {
  const std::size_t per_bank = row_.lasers / row_.banks;
  for (std::size_t k = 0; k < lasers_.size(); ++k) {
    const std::uint16_t count = distance_count(sequence.slots[k / per_bank] + 3 * (k % per_bank));
    if (geometry_ ? !is_return(origins_[k], count) : !is_return(count)) continue;
    ReturnOrigin origin{};
    origin.column = static_cast<std::uint32_t>(cloud.columns.size() - 1);
    origin.laser = static_cast<std::uint16_t>(k);
    origin.block = sequence.blocks[k / per_bank];
    const double azimuth = std::fmod(sequence.azimuth_deg + origins_[k].shift_deg, 360);
    origin.azimuth_deg = azimuth < 0 ? azimuth + 360 : azimuth;
    origin.distance_m = geometry_ ? geometry_->distance(k, count) : count * row_.distance_step_m;
    origin.offset_ns = (sequence.in_packet + origins_[k].firing).count();
    origin.stamp = sequence.stamp + origins_[k].firing;
    cloud.origins.push_back(origin);
  }
}

}  // namespace lidard::velodyne
