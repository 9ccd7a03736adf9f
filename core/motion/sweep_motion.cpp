// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/sweep_motion.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

constexpr double stretch_s = 1e-3;
constexpr double longest_sweep_s = 10;

std::size_t beams_per_stretch(const SweepTimes& times) {
  if (times.between <= 0) return std::max<std::size_t>(times.beams, 1);
  const double beams = std::floor(stretch_s / times.between);
  return static_cast<std::size_t>(std::clamp(beams, 1.0, static_cast<double>(times.beams)));
}

}  // namespace

SweepTimes times_of(const PlanarScan& scan) {
  return {scan.stamp, static_cast<double>(scan.time_increment), scan.beams};
}

bool has_usable_times(const PlanarScan& scan) {
  const auto between = static_cast<double>(scan.time_increment);
  return between >= 0 && between * static_cast<double>(scan.beams) <= longest_sweep_s;
}

PoseOrigin SweepMotion::follow(const MergeMoment& moment, const SweepTimes& times) {
  stand();
  Pose end;
  if (moment.track == nullptr) return PoseOrigin::missing;
  PoseOrigin worst = moment.track->at(moment.at, end);
  if (worst == PoseOrigin::missing || times.beams == 0) return worst;
  const Pose output_from_odom = moment.output_from_base * end.inverse();
  const Pose base_from_output = moment.output_from_base.inverse();
  step_ = beams_per_stretch(times);
  bool moves = false;
  for (std::size_t beam = 0; beam < times.beams;) {
    Pose pose;
    worst = std::max(worst, moment.track->at(times.at(beam), pose));
    if (worst == PoseOrigin::missing) break;
    Stretch here{beam, beam + 1, Matrix::Identity(), Matrix::Zero()};
    // A vehicle that stands must leave every point where it is to the last bit.
    if (pose.matrix() != end.matrix()) {
      here.from = (output_from_odom * pose * base_from_output).matrix().topRows<3>();
      moves = true;
    }
    if (!stretches_.empty()) stretches_.back().lead_to(here);
    stretches_.push_back(here);
    // The last beam is a border too.
    beam = beam + 1 == times.beams ? times.beams : std::min(beam + step_, times.beams - 1);
  }
  if (!moves || worst == PoseOrigin::missing) stand();
  return worst;
}

void SweepMotion::Stretch::lead_to(const Stretch& next) {
  end = next.begin;
  change = (next.from - from) / static_cast<double>(end - begin);
}

}  // namespace lidard
