// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/mounts/drive_fit.h"
#include "core/mounts/ground.h"
#include "core/mounts/mount_solver.h"
#include "daemon/commands/commands.h"
#include "daemon/files/text_table.h"

namespace lidard {

/// The vehicle's motion while the captures were recorded.
struct Drive {
  Stamp begin;
  std::vector<OdometryPose> odometry;
  DriveTrack track;
  DriveSolution solution;

  explicit Drive(const std::vector<OdometryPose>& poses, Stamp first)
      : begin(first), odometry(poses), track(poses) {}
  double time(Stamp stamp) const { return seconds(stamp - begin); }
  /// What would show more, as a request to the driver.
  std::string advice() const;
};
/// Reads `--motion`. Throws std::runtime_error.
Drive read_drive(const std::string& path, const VehicleConfig& vehicle);

/// A sensor of the configuration, what it saw and what that says.
struct CalibratedSensor {
  const SensorConfig* config;
  Pose before;
  StillScans scans;                // while the vehicle stood
  std::size_t left_out = 0;        // scans of the stop whose grid is not that of the first one
  std::vector<DriveSweep> sweeps;  // while it drove
  Pose after;
  Eigen::Matrix3d tilt;
  std::optional<GroundPlane> ground;
  MountEstimate estimate;
  DriveEstimate drive;
  bool is_cloud = false;
  bool is_held = false;  // by the reference, since the stop shows its pose against it

  CalibratedSensor(const SensorConfig& sensor, const Pose& pose)
      : config(&sensor), before(pose), after(pose), tilt(tilt_of(pose.linear())) {}
  PlanarPose configured() const {
    return {before.translation().x(), before.translation().y(), yaw_of(before.linear())};
  }
  bool is_found() const { return estimate.verdict == MountVerdict::found; }
  /// Standard deviation of x, y (m), yaw (rad) or time offset (s); nothing: not determined.
  std::optional<double> sigma(std::size_t i) const;
  bool is_changed() const { return ground || sigma(0) || sigma(1) || sigma(2) || sigma(3); }
  double time_offset_before() const { return seconds(config->driver.time_offset); }
  double time_offset_after() const { return time_offset_before() + drive.time_offset; }
};

/// Plays the captures; the frames of the vehicle's first stop are averaged, sweeps of the drive are kept.
/// `drive`: nullptr: it stands all the time, and sweeps are kept that show it.
std::vector<CalibratedSensor> play_calibrated(const CalibrateOptions& options, const Config& config,
                                              const Drive* drive);

/// The results, for scripts as they are and for people as a table with remarks.
using CalibrationReport = nlohmann::ordered_json;
CalibrationReport calibration_report(const std::vector<CalibratedSensor>& sensors,
                                     const MountSolution& solution, const Drive* drive);
TextTable calibration_table(const CalibrationReport& report);
/// Draws what the sensors saw, before and after, side by side.
void draw_calibration(const std::string& path, const std::vector<CalibratedSensor>& sensors,
                      const Config& config, const Drive* drive);

}  // namespace lidard
