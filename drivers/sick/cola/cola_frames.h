// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/frames/cloud.h"
#include "core/frames/scan.h"
#include "drivers/driver.h"
#include "drivers/sick/cola/cola_row.h"
#include "drivers/sick/cola/cola_scan.h"

namespace lidard::sick {

/// Angles and times of a telegram's beams.
struct ColaGeometry {
  std::size_t beams = 0;
  std::size_t echoes = 0;
  double start_deg = 0, step_deg = 0;  ///< as the device counts
  double scan_hz = 0;
  double beam_period = 0;  ///< s

  /// rad in the device's ROS frame; fractions of a beam are allowed.
  double angle(const ColaRow& row, double beam) const;
  Span sweep() const;
  /// True if only the begin differs, by less than a step: LMS1000 and MRS1000 shift their scans so at fine
  /// resolutions (sick_scan_xd, README, interlaced modes).
  bool is_interlaced_with(const ColaGeometry& other) const;
  friend bool operator==(const ColaGeometry& a, const ColaGeometry& b);
};

/// False if the telegram has no distances, or its channels contradict each other.
bool read_geometry(const ColaScan& scan, const ColaRow& row, ColaGeometry& geometry);
/// "811 beams from -45.0000 deg in steps of 0.33333 deg, 15.00 Hz".
std::string describe(const ColaGeometry& geometry);

/// A step that the telegram holds in 1/10000 deg: 0.3333 stands for 1/3, 0.1667 for 1/6.
double exact_step_deg(double sent);

/// State of a beam from its raw distance. Values below 16 are codes (sick_scan_xd, README of the data
/// formats): 0 no echo, 1 dazzled, others unknown. Unverified: 0 means free space, but for
/// ColaRow::zero_is_unknown.
BeamStatus status_of_raw(std::uint16_t raw, const ColaRow& row);
constexpr std::uint16_t first_distance = 16;
/// True for the planes of an MRS1000, and for that of a single-plane device (0); 1/100 deg, positive
/// downwards.
bool is_plane_of_mrs1000(std::int16_t layer);

/// Makes planar scans from the telegrams of a single-plane device.
class ColaScanBuilder {
 public:
  ColaScanBuilder(const DriverConfig& config, const ColaRow& row);

  /// Sets how far the device's angles deviate, for the next choose().
  void compensate(const ColaAngleCompensation& compensation);
  /// Chooses the beams between the configured angles. False: none.
  bool choose(const ColaGeometry& geometry);
  /// The telegram's beam that is the first one of the scan.
  std::size_t first_beam() const { return window_.first; }
  /// The telegram's values in the chosen geometry; the stamp is the caller's.
  PlanarScan& fill(const ColaScan& telegram);

 private:
  void fill_echo(const ColaScan& telegram, std::size_t echo);

  const DriverConfig& config_;
  const ColaRow& row_;
  BeamWindow window_;
  std::size_t echoes_ = 1;
  double offset_ = 0;  // rad, of the device's compensation
  PlanarScan scan_;
};

/// Makes clouds from a device that sends one telegram per plane (MRS1000): a cloud holds one telegram of
/// every plane, ring 0 being the lowest. Each echo of a beam has a column. The returns are in the order of
/// the telegrams; the sweeps of neighbouring planes overlap in time, so `time` increases only within a plane.
class ColaCloudBuilder {
 public:
  ColaCloudBuilder(const DriverConfig& config, const ColaRow& row, Counters& counters);

  /// Adds a telegram whose first beam was measured at `first` of the device's clock, and publishes a
  /// completed cloud. False: no plane of the device has that angle.
  bool add(const ColaScan& telegram, const ColaGeometry& geometry, Span first, const ColaClock& clock,
           FrameReceiver& out);
  /// Publishes or drops the unfinished cloud.
  void finish(FrameReceiver& out);
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
  Span begun_{0};               // of the device's clock: the first beam of the first plane
  bool corrected_ = false;      // the directions are those of one telegram
  std::int64_t offset_ns_ = 0;  // of the return being written, after its telegram's own time
  ColaGeometry geometry_;
  std::vector<std::array<float, 2>> directions_;  // cosine and sine of every beam's angle
  Cloud cloud_;
};

}  // namespace lidard::sick
