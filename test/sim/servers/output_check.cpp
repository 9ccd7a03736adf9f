// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/output_check.h"

#include <cmath>

namespace lidard::sim {
namespace {

/// The largest frame of a device: a VLS-128 with two returns at 60 rpm has 4.6 million points, and frames by
/// time may last a second.
constexpr std::size_t most_points = 12'000'000;
constexpr std::size_t most_ranges = 1'000'000;

bool is_finite(const CloudPoint& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) && std::isfinite(p.intensity) &&
         std::isfinite(p.time);
}

bool are_in_order(const Cloud& cloud) {
  std::uint32_t last = 0;
  for (const CloudColumn& column : cloud.columns) {
    if (column.first_point < last || column.first_point > cloud.size() || !std::isfinite(column.azimuth))
      return false;
    last = column.first_point;
  }
  return true;
}

}  // namespace

void OutputCheck::check(const PlanarScan& scan) {
  const char* broken = lidard::violation(scan);
  expect(broken == nullptr, broken);
  expect(scan.ranges.size() <= most_ranges, "more beams than any device has");
  expect(std::isfinite(scan.time_increment) && std::isfinite(scan.scan_time), "a scan's time is not finite");
}

void OutputCheck::scan(PlanarScan& scan) {
  ++frames_;
  check(scan);
}

void OutputCheck::extra_scan(std::string_view, PlanarScan& scan) { check(scan); }

void OutputCheck::cloud(Cloud& cloud) {
  ++frames_;
  expect(cloud.size() <= most_points, "more points than any device has");
  expect(are_in_order(cloud), "columns are not in the order of their points");
  expect(cloud.origins.empty() || cloud.origins.size() == cloud.size(), "an origin per point");
  bool finite = true, known = true, late = true;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint point = cloud.points()[i];
    finite = finite && is_finite(point);
    known = known && point.ring < cloud.rings;
    late = late && point.time >= 0;
  }
  expect(finite, "a point is not finite");
  expect(known, "a ring beyond the last");
  expect(late, "a point is older than the stamp");
}

void OutputCheck::message(const DeviceMessage& message) {
  if (const auto* fix = std::get_if<GnssFix>(&message))
    expect(!(std::fabs(fix->latitude_deg) > 90) && !(std::fabs(fix->longitude_deg) > 180),
           "no place on earth");
  if (const auto* sample = std::get_if<ImuSample>(&message))
    expect(sample->angular_velocity.allFinite() && sample->linear_acceleration.allFinite(),
           "an inertial value is not finite");
}

}  // namespace lidard::sim
