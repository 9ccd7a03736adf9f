// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/unpacker.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {
namespace {

/// The table that SequenceKernels need.
struct WholeDegreesTable {
  WholeDegrees whole;
  WholeDegreesTable() {
    for (int i = -whole_turn_deg; i <= whole_turn_deg; ++i)
      whole[i + whole_turn_deg] = {std::cos(i * rad_per_deg), std::sin(i * rad_per_deg)};
  }
};
const WholeDegreesTable table;

static_assert(sizeof(CloudPoint) == point_step && offsetof(CloudPoint, intensity) == 12 &&
                  offsetof(CloudPoint, ring) == 16 && offsetof(CloudPoint, time) == 18,
              "the kernels write these bytes");

std::int32_t distance_count(const std::uint8_t* slot) { return slot[0] | slot[1] << 8; }

std::unique_ptr<CalibrationArrays> arrays_of(const CalibratedGeometry& geometry) {
  auto arrays = std::make_unique<CalibrationArrays>();
  arrays->step = static_cast<float>(geometry.step_m());
  arrays->two_point_below = static_cast<float>(geometry.two_point_below_m());
  arrays->far_target = static_cast<float>(CalibratedGeometry::far_target_m);
  for (std::size_t k = 0; k < geometry.lasers(); ++k) {
    const CalibratedGeometry::Terms& t = geometry.terms(k);
    arrays->dist_correction[k] = static_cast<float>(t.dist_correction);
    arrays->cos_vert[k] = static_cast<float>(t.cos_vert);
    arrays->sin_vert[k] = static_cast<float>(t.sin_vert);
    arrays->r_offset[k] = static_cast<float>(t.r_offset);
    arrays->z_offset[k] = static_cast<float>(t.z_offset);
    arrays->horiz_offset[k] = static_cast<float>(t.horiz_offset);
    arrays->near_x[k] = static_cast<float>(t.two_point ? t.near_x : 0);
    arrays->near_y[k] = static_cast<float>(t.two_point ? t.near_y : 0);
    arrays->focal[k] = static_cast<float>(t.focal);
    arrays->focal_slope[k] = static_cast<float>(t.focal_slope);
    arrays->min_intensity[k] = static_cast<float>(t.min_intensity);
    arrays->max_intensity[k] = static_cast<float>(t.max_intensity);
  }
  return arrays;
}

bool is_straight(const CalibratedGeometry& geometry) {
  for (std::size_t k = 0; k < geometry.lasers(); ++k) {
    if (!geometry.terms(k).is_straight()) return false;
  }
  return true;
}

}  // namespace

Unpacker::Unpacker(const ModelRow& row, bool keep_origins, double min_range, double max_range,
                   const Calibration* calibration, const SequenceKernels& kernels)
    : row_(row),
      keep_origins_(keep_origins),
      min_range_(min_range),
      max_range_(max_range),
      kernels_(kernels),
      origins_(row.lasers) {
  lasers_.size = row.lasers;
  lasers_.banks = row.banks;
  set_geometry(calibration != nullptr ? *calibration : table_of(row));
  set_timing(row.timings.front());
}

void Unpacker::set_calibration(const Calibration& calibration) {
  set_geometry(calibration);
  turn_anew();
}

void Unpacker::set_geometry(const Calibration& calibration) {
  geometry_.emplace(calibration);
  calibration_ = is_straight(*geometry_) ? nullptr : arrays_of(*geometry_);
  const double step = geometry_->step_m();
  const auto rings = rings_by_elevation(calibration);
  for (std::size_t k = 0; k < row_.lasers; ++k) {
    const CalibratedGeometry::Terms& t = geometry_->terms(k);
    lasers_.cos_rot[k] = t.cos_rot;
    lasers_.sin_rot[k] = t.sin_rot;
    lasers_.ground_step[k] = static_cast<float>(t.cos_vert * step);
    lasers_.ground_begin[k] = static_cast<float>(t.dist_correction * t.cos_vert - t.r_offset);
    lasers_.up_step[k] = static_cast<float>(t.sin_vert * step);
    lasers_.up_begin[k] = static_cast<float>(t.dist_correction * t.sin_vert + t.z_offset);
    lasers_.ring[k] = rings[k];
    origins_[k].rot_deg = t.rot_correction / rad_per_deg;
  }
  set_limits();
}

void Unpacker::set_limits() {
  constexpr double most = 65535;
  const double step = geometry_->step_m();
  for (std::size_t k = 0; k < row_.lasers; ++k) {
    const double added = geometry_->terms(k).dist_correction;
    const double nearest = min_range_ > 0 ? std::ceil((min_range_ - added) / step - 1e-9) : 1;
    const double farthest = max_range_ > 0 ? std::floor((max_range_ - added) / step + 1e-9) : most;
    // A count of 0 means "no return" on the wire.
    lasers_.nearest[k] = static_cast<std::int32_t>(std::clamp(nearest, 1.0, most));
    lasers_.farthest[k] = static_cast<std::int32_t>(std::clamp(farthest, 0.0, most));
  }
}

void Unpacker::set_timing(const Timing& timing) {
  for (std::size_t k = 0; k < row_.lasers; ++k) {
    origins_[k].firing = row_.firing_time(timing, k) + timing.before;
    lasers_.time[k] = static_cast<float>(seconds(origins_[k].firing));
    // A block's azimuth is that of its first firing, but for an HDL-64E S1 it holds for the full block, as in
    // the viewer of its db.xml.
    lasers_.turning[k] = row_.bank_by_bank ? 0 : seconds(origins_[k].firing);
  }
  longest_turning_ = *std::max_element(lasers_.turning, lasers_.turning + row_.lasers);
  turn_anew();
}

void Unpacker::turn_anew() {
  const double rate = rate_;
  rate_ = std::numeric_limits<double>::infinity();
  set_rate(rate);
}

void Unpacker::set_rate(double deg_per_s) {
  // A smaller turn moves a beam by less than 0.01 mm at any range.
  constexpr double negligible_deg = 2e-6;
  if (std::abs(deg_per_s - rate_) * longest_turning_ < negligible_deg) return;
  rate_ = deg_per_s;
  kernels_.turn_lasers(lasers_, deg_per_s * rad_per_deg);
  if (!keep_origins_) return;
  for (std::size_t k = 0; k < row_.lasers; ++k)
    origins_[k].shift_deg = rate_ * lasers_.turning[k] - origins_[k].rot_deg;
}

void Unpacker::reserve_packet(Cloud& cloud) const {
  // The kernels write a little beyond the last point.
  const std::size_t needed = (cloud.columns.empty() ? 0 : cloud.columns.back().first_point + row_.lasers) +
                             blocks_per_packet * slots_per_block + overshoot / point_step;
  // Grows in large steps: a VLP-16 sends 76 packets per revolution at 600 rpm.
  constexpr std::size_t step = 8 * blocks_per_packet * slots_per_block;
  if (cloud.size() < needed) cloud.points_bytes.resize((needed + step) * sizeof(CloudPoint));
}

void Unpacker::append(const Sequence& sequence, Cloud& cloud) {
  CloudColumn& column = cloud.columns.emplace_back();
  column.packet = sequence.packet;
  column.block = sequence.blocks[0];
  column.echo = sequence.echo;
  column.azimuth = static_cast<float>(sequence.azimuth_deg * rad_per_deg);
  column.stamp = sequence.stamp;
  const std::size_t n = waiting_.size++;
  std::copy(sequence.slots.begin(), sequence.slots.end(), waiting_.slots[n]);
  waiting_.azimuth_deg[n] = sequence.azimuth_deg;
  waiting_.begin[n] = static_cast<float>(seconds(sequence.in_frame));
  append_extras(sequence, cloud);
}

void Unpacker::transform(Cloud& cloud, std::size_t& points) {
  if (waiting_.size == 0) return;
  kernels_.find_directions(table.whole, waiting_);
  std::uint8_t* const bytes = cloud.points_bytes.data();
  std::uint8_t* const out = bytes + points * point_step;
  if (calibration_)
    kernels_.transform_calibrated(lasers_, *calibration_, waiting_, out);
  else
    kernels_.transform(lasers_, waiting_, out);
  CloudColumn* column = cloud.columns.data() + cloud.columns.size() - waiting_.size;
  for (std::size_t n = 0; n < waiting_.size; ++n, ++column) {
    column->first_point = static_cast<std::uint32_t>(points);
    points = static_cast<std::size_t>(waiting_.end[n] - bytes) / point_step;
  }
  waiting_.size = 0;
}

void Unpacker::append_extras(const Sequence& sequence, Cloud& cloud) const {
  if (keep_origins_) append_origins(sequence, cloud);
  if (keep_too_near_) append_too_near(sequence, cloud);
}

void Unpacker::append_too_near(const Sequence& sequence, Cloud& cloud) const {
  const std::size_t per_bank = row_.lasers / row_.banks;
  for (std::size_t k = 0; k < row_.lasers; ++k) {
    const std::int32_t count = distance_count(sequence.slots[k / per_bank] + 3 * (k % per_bank));
    if (count == 0 || count >= lasers_.nearest[k]) continue;
    cloud.too_near.push_back(
        {static_cast<std::uint32_t>(cloud.columns.size() - 1), static_cast<std::uint16_t>(lasers_.ring[k])});
  }
}

void Unpacker::append_origins(const Sequence& sequence, Cloud& cloud) const {
  const std::size_t per_bank = row_.lasers / row_.banks;
  for (std::size_t k = 0; k < row_.lasers; ++k) {
    const std::int32_t count = distance_count(sequence.slots[k / per_bank] + 3 * (k % per_bank));
    if (count < lasers_.nearest[k] || count > lasers_.farthest[k]) continue;
    ReturnOrigin origin{};
    origin.column = static_cast<std::uint32_t>(cloud.columns.size() - 1);
    origin.laser = static_cast<std::uint16_t>(k);
    origin.block = sequence.blocks[k / per_bank];
    const double azimuth = std::fmod(sequence.azimuth_deg + origins_[k].shift_deg, 360);
    origin.azimuth_deg = azimuth < 0 ? azimuth + 360 : azimuth;
    origin.distance_m = geometry_->distance(k, static_cast<std::uint16_t>(count));
    origin.offset_ns = (sequence.in_packet + origins_[k].firing).count();
    origin.stamp = sequence.stamp + origins_[k].firing;
    cloud.origins.push_back(origin);
  }
}

}  // namespace lidard::velodyne
