// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "test/sim/world/geometry.h"
#include "test/sim/world/motion.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/sensor_model.h"

namespace lidard::sim {

/// The ground and how bright it is.
struct GroundCover {
  Ground plane;
  double reflectivity = 0.2;
};

/// Odometry of the vehicle and how wrong it is.
struct OdometrySettings {
  double rate = 50;                      ///< Hz
  double scale = 1, turn_scale = 1;      ///< of distances and of turns
  double way_noise = 0, turn_noise = 0;  ///< m and rad, standard deviations after 1 m of a random walk
};

/// Everything that is simulated. World frame: z up, the vehicle drives on z = 0.
struct Scene {
  Stamp start;
  Span duration{0};
  std::uint64_t seed = 1;
  std::optional<GroundCover> ground;
  std::vector<Object> objects;
  std::vector<Object> body;  ///< of the vehicle, in its own frame
  Trajectory trajectory;
  std::optional<OdometrySettings> odometry;
  std::vector<SensorEntry> sensors;

  /// Seconds since the start.
  double elapsed(Stamp time) const { return seconds(time - start); }
  /// The vehicle's frame in the world.
  Pose vehicle_at(Stamp time) const { return to_pose(trajectory.at(elapsed(time))); }
};

/// What a ray of a sensor (in its own frame) meets first at `time`.
Hit look(const Scene& scene, const SensorEntry& sensor, const Ray& ray, Stamp time);
/// Adds what a laser of the sensor measures of a hit in its range.
void add_echo(const SensorEntry& sensor, std::size_t laser, const Hit& hit, Rng& rng, Answer& answer);
/// What the odometry says from the start to the end, first at the origin.
struct OdometryReading {
  Stamp stamp;
  Pose2 place;
};
std::vector<OdometryReading> odometry_of(const Scene& scene);

}  // namespace lidard::sim
