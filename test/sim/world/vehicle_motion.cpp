// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/world/vehicle_motion.h"

#include <cmath>

namespace lidard::sim {
namespace {

constexpr double step_s = 1e-4;

}  // namespace

SwingingVehicle::SwingingVehicle(std::uint64_t seed, double duration) {
  Rng rng(seed);
  speed_rate_ = 2 * pi_d / (1.25 * (1 + rng.uniform()));
  speed_phase_ = 2 * pi_d * rng.uniform();
  turn_rate_ = 2 * pi_d / (1.25 * (1 + rng.uniform()));
  turn_phase_ = 2 * pi_d * rng.uniform();
  places_.emplace_back(0, 0);
  for (double time = 0; time < duration; time += step_s)
    places_.push_back(places_.back() + way(static_cast<double>(places_.size() - 1) * step_s, step_s));
}

Eigen::Vector2d SwingingVehicle::way(double time, double step) const {
  const auto velocity = [this](double t) {
    return Eigen::Vector2d(speed(t) * Eigen::Vector2d(std::cos(yaw(t)), std::sin(yaw(t))));
  };
  return step / 6 * (velocity(time) + 4 * velocity(time + step / 2) + velocity(time + step));
}

Pose2 SwingingVehicle::at(double time) const {
  const auto before = static_cast<std::size_t>(time / step_s);
  const double begin = static_cast<double>(before) * step_s;
  const Eigen::Vector2d place = places_[before] + way(begin, time - begin);
  return {place.x(), place.y(), yaw(time)};
}

void SwingingVehicle::report(PoseTrack& track, Stamp start, double rate, double from, double to) const {
  for (double tick = std::ceil(from * rate); tick <= to * rate; ++tick)
    track.add(start + span_from_seconds(tick / rate), to_pose(at(tick / rate)));
}

}  // namespace lidard::sim
