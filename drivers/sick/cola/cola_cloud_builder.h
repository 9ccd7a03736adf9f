// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/frames/cloud.h"
#include "drivers/driver.h"
#include "drivers/sick/cola/cola_clock.h"
#include "drivers/sick/cola/cola_geometry.h"

namespace lidard::sick {

/// Makes clouds of a device whose planes come in telegrams of their own (MRS1000): one cloud holds one
/// telegram of every plane, ring 0 being the lowest. Each echo of a beam has a column. The returns stand in
/// the order of the telegrams; the sweeps of neighbouring planes overlap in time, so `time` rises within a
/// plane only.
class ColaCloudBuilder {
 public:
  ColaCloudBuilder(const DriverConfig& config, const ColaRow& row, Counters& counters);

  /// Takes a telegram whose first beam was measured at `first` of the device's clock. Hands on the cloud
  /// that it completes. False: no plane of the device has that angle.
  bool add(const ColaScan& telegram, const ColaGeometry& geometry, Span first, const ColaClock& clock,
           DriverOutput& out);
  /// Hands on, or drops, what is begun.
  void finish(DriverOutput& out);
  void clear();

 private:
  void begin(Stamp stamp);
  void choose(const ColaGeometry& geometry);
  void append(const ColaScan& telegram, std::size_t ring, Span first, const ColaClock& clock);
  void append_return(const ColaChannel& distance, const ColaChannel* rssi, std::size_t beam,
                     double azimuth_deg, std::uint16_t ring, Stamp fired);

  const DriverConfig& config_;
  const ColaRow& row_;
  Counters& counters_;
  double range_min_, range_max_;  // m
  std::uint32_t packet_ = 0;
  std::uint32_t seen_ = 0;      // bit by ring
  bool corrected_ = false;      // the directions are those of one telegram
  std::int64_t offset_ns_ = 0;  // of the return being written, after its telegram's own time
  ColaGeometry geometry_;
  std::vector<std::array<float, 2>> directions_;  // cosine and sine of every beam's angle
  Cloud cloud_;
};

}  // namespace lidard::sick
