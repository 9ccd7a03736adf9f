// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Virtual scans of a moving vehicle through the whole pipeline: what is told of missing poses.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "daemon/health/pipeline_health.h"
#include "daemon/pipeline/pipeline.h"
#include "test/daemon/pipeline/no_tf.h"
#include "test/sim/world/units.h"
#include "test/support/recording_sink.h"
#include "test/support/yard.h"

namespace lidard {
namespace {

constexpr Stamp begin{1'700'000'000'000'000'000};

/// A vehicle that turns on the spot, its lidar 8 m before a wall, as another driver's topic.
struct Vehicle {
  explicit Vehicle(const std::string& odometry)
      : config(
            parse_config("vehicle: {base_frame: base" + odometry +
                             "}\nsensors: {roof: {topic: /points, frame_id: roof, pose: {xyz: [0, 0, 2]}}}\n"
                             "virtual_scans: {level: {cloud_topic: roof, base_frame: base, profile: safety, "
                             "virtual_laser_scan: [low], poses: {low: {xyz: [0, 0, 0.5]}}, beams: 720, "
                             "range_max: 60}}\n",
                         "test")),
        pipeline(config, tf, sink) {}

  /// A revolution that begins at `at`.
  void cloud(Span at) {
    sim::Yard yard;
    sim::Object wall;
    wall.shape = sim::Wall{{8, -40}, {8, 40}, 0, 4};
    yard.objects = {wall};
    sim::YardLidar lidar;
    lidar.elevations = sim::even_rings(16, -15, 15);
    lidar.columns = 900;
    lidar.path = [at](Span after) { return turned(at + after) * make_pose({0, 0, 2}, {0, 0, 0}); };
    sim::Rng rng(1);
    Cloud cloud = sim::measure(yard, lidar, rng);
    cloud.columns.clear();
    cloud.frame_id = "roof";
    const Span length = cloud.end - cloud.stamp;
    cloud.stamp = begin + at;
    cloud.end = cloud.stamp + length;
    pipeline.cloud_message("roof", cloud, cloud.end);
    pipeline.tick(cloud.end);
  }
  void pose(Span at) { pipeline.pose_message(begin + at, turned(at), "", begin + at); }
  static Pose turned(Span at) { return make_pose({0, 0, 0}, {0, 0, 0.2 * std::sin(6 * seconds(at))}); }
  const DiagnosticItem& told() { return sink.item("virtual level"); }

  NoTf tf;
  test::RecordingSink sink;
  Config config;
  Pipeline pipeline;
  HealthReporter reporter{pipeline, sink};
};

TEST(VirtualMotion, ScansAreOfTheInstantOfTheirStampAndMissingPosesAreTold) {
  Vehicle vehicle(", odometry_topic: /odom");
  for (int at = 0; at < 2000; at += 100) {
    for (int knot = at - 20; knot <= at + 110; knot += 10) vehicle.pose(ms(knot));
    vehicle.cloud(ms(at));
  }
  ASSERT_EQ(vehicle.sink.count("low"), 20U);
  for (std::size_t i = 3; i < 20; ++i) {
    const PlanarScan& scan = vehicle.sink.scans["low"][i];
    const Span at = scan.stamp - begin;
    EXPECT_NEAR(seconds(at), 0.1 * static_cast<double>(i + 1), 0.001);
    const double yaw = 0.2 * std::sin(6 * seconds(at));
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      const double angle = static_cast<double>(scan.angle(beam)) + yaw;
      if (std::cos(angle) < 0.6 || scan.statuses[beam] != BeamStatus::hit) continue;
      EXPECT_NEAR(static_cast<double>(scan.ranges[beam]), 8 / std::cos(angle), 0.02) << i << ", " << beam;
    }
  }
  EXPECT_EQ(vehicle.told().health, Health::ok) << vehicle.told().message;
  // Odometry stops.
  for (int at = 2400; at < 4000; at += 100) vehicle.cloud(ms(at));
  EXPECT_EQ(vehicle.sink.count("low"), 36U) << "the scans go on";
  EXPECT_EQ(vehicle.told().health, Health::warn);
  EXPECT_NE(vehicle.told().message.find("as if the vehicle stood still"), std::string::npos);
  // And comes back.
  for (int at = 4000; at < 6000; at += 100) {
    for (int knot = at - 20; knot <= at + 110; knot += 10) vehicle.pose(ms(knot));
    vehicle.cloud(ms(at));
  }
  EXPECT_EQ(vehicle.told().health, Health::ok) << vehicle.told().message;
}

TEST(VirtualMotion, AVehicleWithoutOdometryIsNotWarnedOf) {
  Vehicle vehicle("");
  for (int at = 0; at < 2000; at += 100) vehicle.cloud(ms(at));
  EXPECT_EQ(vehicle.told().health, Health::ok) << vehicle.told().message;
}

}  // namespace
}  // namespace lidard
