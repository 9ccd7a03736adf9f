// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/unpacker.h"

#include <cmath>

#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {
namespace {

constexpr double rad_per_deg = 3.14159265358979323846 / 180;

std::uint16_t distance_count(const std::uint8_t* slot) {
  return static_cast<std::uint16_t>(slot[0] | slot[1] << 8U);
}

}  // namespace

Unpacker::Unpacker(const ModelRow& row, bool keep_origins) : row_(row), keep_origins_(keep_origins) {
  const auto rings = rings_by_elevation(row);
  for (std::size_t k = 0; k < row.lasers; ++k) {
    const Laser& laser = row.laser[k];
    LaserTable table{};
    table.cos_elevation =
        static_cast<float>(std::cos(laser.elevation_deg * rad_per_deg) * row.distance_step_m);
    table.sin_elevation =
        static_cast<float>(std::sin(laser.elevation_deg * rad_per_deg) * row.distance_step_m);
    table.z_offset = static_cast<float>(laser.z_offset_mm * 1e-3);
    table.firing = row.firing_time(k);
    table.time = static_cast<float>(seconds(table.firing));
    table.ring = rings[k];
    lasers_.push_back(table);
  }
  rate_ = -1;
  set_rate(0);
}

void Unpacker::set_rate(double deg_per_s) {
  if (deg_per_s == rate_) return;
  rate_ = deg_per_s;
  for (std::size_t k = 0; k < lasers_.size(); ++k) {
    LaserTable& table = lasers_[k];
    table.shift_deg = rate_ * seconds(table.firing) - row_.laser[k].rot_correction_deg;
    table.cos_shift = static_cast<float>(std::cos(table.shift_deg * rad_per_deg));
    table.sin_shift = static_cast<float>(std::sin(table.shift_deg * rad_per_deg));
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
  column.block = sequence.block;
  column.echo = sequence.echo;
  column.azimuth = static_cast<float>(sequence.azimuth_deg * rad_per_deg);
  column.stamp = sequence.stamp;
  cloud.columns.push_back(column);

  const double alpha = sequence.azimuth_deg * rad_per_deg;
  const auto cos_a = static_cast<float>(std::cos(alpha));
  const auto sin_a = static_cast<float>(std::sin(alpha));
  const auto begin = static_cast<float>(seconds(sequence.in_frame));
  const std::uint8_t* slot = sequence.slots;
  CloudPoint* out = cloud.points() + points;
  for (const LaserTable& laser : lasers_) {
    const std::uint16_t count = distance_count(slot);
    const float cos_alpha = cos_a * laser.cos_shift - sin_a * laser.sin_shift;
    const float sin_alpha = sin_a * laser.cos_shift + cos_a * laser.sin_shift;
    const auto distance = static_cast<float>(count);
    const float xy = distance * laser.cos_elevation;
    // Written also where there is no return, then overwritten: a branch per slot costs more.
    out->x = xy * cos_alpha;
    out->y = -xy * sin_alpha;
    out->z = distance * laser.sin_elevation + laser.z_offset;
    out->intensity = static_cast<float>(slot[2]);
    out->ring = laser.ring;
    out->time = begin + laser.time;
    out += count != 0 ? 1 : 0;
    slot += 3;
  }
  points = static_cast<std::size_t>(out - cloud.points());
  if (keep_origins_) append_origins(sequence, cloud);
}

void Unpacker::append_origins(const Sequence& sequence, Cloud& cloud) const {
  for (std::size_t k = 0; k < lasers_.size(); ++k) {
    const std::uint16_t count = distance_count(sequence.slots + 3 * k);
    if (count == 0) continue;
    const LaserTable& laser = lasers_[k];
    ReturnOrigin origin{};
    origin.column = static_cast<std::uint32_t>(cloud.columns.size() - 1);
    origin.laser = static_cast<std::uint16_t>(k);
    const double azimuth = std::fmod(sequence.azimuth_deg + laser.shift_deg, 360);
    origin.azimuth_deg = azimuth < 0 ? azimuth + 360 : azimuth;
    origin.distance_m = count * row_.distance_step_m;
    origin.offset_ns = (sequence.in_packet + laser.firing).count();
    origin.stamp = sequence.stamp + laser.firing;
    cloud.origins.push_back(origin);
  }
}

}  // namespace lidard::velodyne
