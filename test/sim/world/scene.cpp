// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/world/scene.h"

#include <algorithm>

namespace lidard::sim {

Hit look(const Scene& scene, const SensorEntry& sensor, const Ray& ray, Stamp time) {
  const double now = scene.elapsed(time);
  const Ray on_vehicle = transform(sensor.mount, ray);
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

void add_echo(const SensorEntry& sensor, const Hit& hit, Rng& rng, Answer& answer) {
  if (!(hit.distance >= sensor.range_min && hit.distance <= sensor.range_max)) return;
  const double error = sensor.noise > 0 ? sensor.noise * rng.gaussian() : 0;
  answer.echoes[answer.count++] = {std::max(0.0, hit.distance + error), hit.distance, hit.reflectivity};
}

}  // namespace lidard::sim
