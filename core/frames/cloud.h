// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <new>
#include <string>
#include <vector>

#include "core/base/angle.h"
#include "core/base/time.h"

namespace lidard {

/// One return, in the very bytes of our PointCloud2: the layout of ros-drivers/velodyne
/// (velodyne_pointcloud/pointcloudXYZIRT.cc), point_step 22, `time` unaligned.
struct __attribute__((packed, may_alias)) CloudPoint {
  float x, y, z;       ///< m, sensor's ROS frame (REP 103)
  float intensity;     ///< device units
  std::uint16_t ring;  ///< 0 = lowest beam
  float time;          ///< s after the cloud's stamp
};
static_assert(sizeof(CloudPoint) == 22, "the PointCloud2 layout is a contract");

/// A return in a cloud of several sources, likewise; point_step 24.
struct __attribute__((packed, may_alias)) MergedPoint {
  CloudPoint point;      ///< in the frame of the merged cloud; `time` after its stamp, mostly negative
  std::uint16_t sensor;  ///< index of its source among those of the merged cloud
};
static_assert(sizeof(MergedPoint) == 24, "the PointCloud2 layout is a contract");

/// Allocates memory with room for the head of a message before it, so that a message is made around the
/// points where they stand.
template <class T>
struct PointAllocator {
  using value_type = T;
  static constexpr std::size_t room = 1024;  ///< bytes
  PointAllocator() = default;
  template <class U>
  PointAllocator(const PointAllocator<U>& /*other*/) noexcept {}
  T* allocate(std::size_t n) {
    return reinterpret_cast<T*>(static_cast<char*>(::operator new(room + n * sizeof(T))) + room);
  }
  void deallocate(T* p, std::size_t) noexcept { ::operator delete(reinterpret_cast<char*>(p) - room); }
  friend bool operator==(const PointAllocator&, const PointAllocator&) { return true; }
  friend bool operator!=(const PointAllocator&, const PointAllocator&) { return false; }
};
using PointBytes = std::vector<std::uint8_t, PointAllocator<std::uint8_t>>;
}  // namespace lidard

/// Compiled once, in core, with loops as copies of memory: in the daemon, which is compiled for a short
/// build, a vector that grew held up its thread for 0.1 s.
extern template class std::vector<std::uint8_t, lidard::PointAllocator<std::uint8_t>>;

namespace lidard {

/// A return nearer than DriverConfig::min_range, which has no point.
struct NearReturn {
  std::uint32_t column;  ///< index into columns
  std::uint16_t ring;
};

/// One firing sequence of a cloud: the returns measured at (nearly) one azimuth.
struct CloudColumn {
  std::uint32_t first_point;  ///< index of its first return; it ends where the next column begins
  std::uint32_t packet;       ///< data packets of this sensor, counted from 0
  std::uint8_t block;         ///< block of the packet
  std::uint8_t echo;          ///< 0, or the number of the return the column holds
  float azimuth;  ///< rad, at the sequence's first firing, as the sensor counts it (Velodyne: clockwise)
  Stamp stamp;    ///< its first firing
};

/// True for two returns of one firing sequence.
inline bool same_firing(const CloudColumn& a, const CloudColumn& b) {
  return a.echo != b.echo && a.stamp == b.stamp && a.azimuth == b.azimuth;
}

/// rad that the lidar turned from a to b, less than a turn; a small step back (the motor's jitter) is
/// negative.
inline double azimuth_step(const CloudColumn& a, const CloudColumn& b) {
  constexpr double backwards_limit = 0.02;
  double step = static_cast<double>(b.azimuth) - static_cast<double>(a.azimuth);
  if (!(step > -two_pi && step < two_pi)) step = std::fmod(step, two_pi);
  if (step < 0) step += two_pi;
  return step > two_pi - backwards_limit ? step - two_pi : step;
}

/// Where a return came from; kept only on request (`lidard decode`).
struct ReturnOrigin {
  std::uint32_t column;  ///< index into columns
  std::uint16_t laser;   ///< the device's own number of the laser
  std::uint8_t block;    ///< of the packet
  double azimuth_deg;    ///< after interpolation and correction, as the sensor counts it
  double distance_m;
  std::int64_t offset_ns;  ///< firing time after the packet's own stamp
  Stamp stamp;             ///< firing time on the host's time scale
};

/// Where the beams of a ring point.
struct RingDirection {
  double elevation;  ///< rad above the sensor's x-y plane
  double ahead;      ///< rad ahead of the azimuth of a column, as the sensor counts it
};

/// One frame (revolution) of a multi-plane lidar, in the sensor's ROS frame.
///
/// The points stand in firing order, so column c holds points [columns[c].first_point, columns[c +
/// 1].first_point). Buffers keep their memory from frame to frame; `points_bytes` may be swapped into a
/// message.
struct Cloud {
  std::string frame_id;
  Stamp stamp;  ///< the first firing sequence
  Stamp end;    ///< the last one
  std::uint16_t rings = 0;
  bool complete = false;             ///< false: the revolution was cut off by the begin or end of the data
  std::size_t expected_columns = 0;  ///< of a whole revolution at the measured rate; 0 unknown
  PointBytes points_bytes;
  std::vector<CloudColumn> columns;
  std::vector<ReturnOrigin> origins;  ///< empty, or one per point
  std::vector<NearReturn> too_near;   ///< in order of columns; only where asked for
  /// m, of DriverConfig::max_range: farther returns have no point, and no return proves no more; 0: no limit.
  double max_range = 0;
  bool bank_by_bank =
      false;  ///< a column holds the returns of a part of the rings; the others were not fired
  /// Rows of an organised cloud (CloudArranger), in which missing returns are NaN; 0: a list, as drivers make
  /// clouds.
  std::uint32_t height = 0;

  /// By ring, as the model's table or the calibration has them; empty: they are not known. A ring proves what
  /// its beams pass although it has not returned yet.
  std::vector<RingDirection> directions;

  std::size_t size() const { return points_bytes.size() / sizeof(CloudPoint); }
  const CloudPoint* points() const { return reinterpret_cast<const CloudPoint*>(points_bytes.data()); }
  /// The index behind the last return of a column.
  std::size_t points_end(std::size_t column) const {
    return column + 1 < columns.size() ? columns[column + 1].first_point : size();
  }
  CloudPoint* points() { return reinterpret_cast<CloudPoint*>(points_bytes.data()); }

  /// Empties the frame and keeps the memory.
  void clear() {
    points_bytes.clear();
    columns.clear();
    origins.clear();
    too_near.clear();
    complete = false;
    expected_columns = 0;
  }
};

/// The returns of several sources in one frame, as they stood at one instant. `points_bytes` may be swapped
/// into a message.
struct MergedCloud {
  std::string frame_id;
  Stamp stamp;               ///< the instant
  std::uint32_t height = 0;  ///< as Cloud::height
  PointBytes points_bytes;

  std::size_t size() const { return points_bytes.size() / sizeof(MergedPoint); }
  const MergedPoint* points() const { return reinterpret_cast<const MergedPoint*>(points_bytes.data()); }
  MergedPoint* points() { return reinterpret_cast<MergedPoint*>(points_bytes.data()); }
};

}  // namespace lidard
