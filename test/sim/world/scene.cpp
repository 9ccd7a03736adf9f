// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/world/scene.h"

#include <algorithm>

namespace lidard::sim {

Hit look(const Scene& scene, const SensorEntry& sensor, const Ray& ray, Stamp time) {
  const double now = scene.elapsed(time);
  const Ray on_vehicle = transform(now < sensor.knocked_at ? sensor.mount : sensor.knocked, ray);
  const Ray in_world = transform(scene.vehicle_at(time), on_vehicle);
  Hit nearest;
  if (scene.ground) {
    const double way = distance(scene.ground->plane, in_world);
    if (way < nearest.distance) nearest = {way, scene.ground->reflectivity};
  }
  for (const Object& object : scene.objects) cast(object, in_world, now, nearest);
  for (const Object& object : scene.body) cast(object, on_vehicle, now, nearest);
  return nearest;
}

void add_echo(const SensorEntry& sensor, std::size_t laser, const Hit& hit, Rng& rng, Answer& answer) {
  if (!(hit.distance >= sensor.range_min && hit.distance <= sensor.range_max)) return;
  const double error = (sensor.noise > 0 ? sensor.noise * rng.gaussian() : 0) + sensor.range_offset(laser);
  answer.echoes[answer.count++] = {std::max(0.0, hit.distance + error), hit.distance, hit.reflectivity};
}

std::vector<OdometryReading> odometry_of(const Scene& scene) {
  const OdometrySettings settings = scene.odometry.value_or(OdometrySettings());
  std::vector<OdometryReading> readings;
  Rng rng(scene.seed + 0x0d0);
  Pose2 place;
  const double period = 1 / settings.rate;
  for (double time = 0; time <= seconds(scene.duration); time += period) {
    readings.push_back({scene.start + span_from_seconds(time), place});
    const Pose2 from = scene.trajectory.at(time), to = scene.trajectory.at(time + period);
    const Eigen::Rotation2Dd back(-from.yaw), ahead(place.yaw);
    Eigen::Vector2d step = settings.scale * (back * Eigen::Vector2d(to.x - from.x, to.y - from.y));
    const double walk = std::sqrt(step.norm());
    step += settings.way_noise * walk * Eigen::Vector2d(rng.gaussian(), rng.gaussian());
    const Eigen::Vector2d moved = ahead * step;
    place = {
        place.x + moved.x(), place.y + moved.y(),
        place.yaw + settings.turn_scale * (to.yaw - from.yaw) + settings.turn_noise * walk * rng.gaussian()};
  }
  return readings;
}

}  // namespace lidard::sim
