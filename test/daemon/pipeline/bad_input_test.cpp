// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Whatever another driver publishes: what the merged scan says of it, and where it is counted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "core/motion/frame_tree.h"
#include "daemon/health/pipeline_health.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/messages/convert.h"
#include "test/sim/world/units.h"
#include "test/support/recording_sink.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t ahead = 180;  // beam of the output, one per degree
constexpr std::size_t behind = 0;
constexpr std::size_t left = 270;

/// Knows no pose until it is told.
struct LatePoses : TransformSource {
  bool lookup(const std::string& parent, const std::string& child, Stamp, Pose& pose,
              std::string& why_not) override {
    pose = Pose::Identity();
    if (!known) why_not = "tf does not know " + child + " in " + parent;
    return known;
  }
  bool known = false;
};

std::string config_text(const std::string& front_pose) {
  return "sensors:\n"
         "  front: {topic: /front, frame_id: front_laser" +
         front_pose +
         "}\n"
         "  rear: {topic: /rear, frame_id: rear_laser, pose: {xyz: [0, 0, 0], rpy_deg: [0, 0, 180]}}\n"
         "merged_scans:\n"
         "  around: {laserscan_topics: [front, rear], destination_frame: base_link, beams: 360, range_max: "
         "20,\n"
         "           profile: strict, also: {careful: safety}}\n";
}

/// Two scanners of 181 beams over a half circle each, back to back, in a round room of 5 m.
struct Room {
  explicit Room(const std::string& front_pose = ", pose: {xyz: [0, 0, 0]}")
      : config(parse_config(config_text(front_pose), "f")), pipeline(config, poses, sink) {}

  sensor_msgs::LaserScan message(const std::string& frame) const {
    sensor_msgs::LaserScan m;
    m.header.frame_id = frame;
    m.header.stamp = to_ros(HostStamp{now.ns});
    m.angle_min = static_cast<float>(-M_PI / 2);
    m.angle_max = static_cast<float>(M_PI / 2);
    m.angle_increment = static_cast<float>(M_PI / 180);
    m.range_min = 0.1F;
    m.range_max = 30;
    m.scan_time = 0.04F;
    m.ranges.assign(181, 5.0F);
    m.intensities.assign(181, 7.0F);
    return m;
  }
  const char* send(const std::string& sensor, const sensor_msgs::LaserScan& m) {
    PlanarScan scan;
    const char* wrong = from_ros(m, scan);
    if (wrong == nullptr) pipeline.scan_message(sensor, scan, now);
    return wrong;
  }
  /// One sweep of each; `change` spoils that of the front scanner. Gives what from_ros() finds wrong.
  template <typename Change>
  std::string sweep(Change change) {
    now = now + std::chrono::milliseconds(40);
    auto front = message("front_laser");
    change(front);
    const char* wrong = send("front", front);
    send("rear", message("rear_laser"));
    pipeline.tick(now + std::chrono::milliseconds(39));
    return wrong == nullptr ? "" : wrong;
  }
  void good(int n = 1) {
    for (int i = 0; i < n; ++i) sweep([](auto&) {});
  }
  const PlanarScan& strict() { return sink.scans.at("around").back(); }
  const PlanarScan& safety() { return sink.scans.at("careful").back(); }
  void expect_valid() {
    for (const auto& [topic, scans] : sink.scans) EXPECT_EQ(violation(scans.back()), nullptr) << topic;
  }
  const DiagnosticItem& item(const std::string& name) { return sink.item(name); }

  test::RecordingSink sink;
  LatePoses poses;
  Config config;
  Pipeline pipeline;
  HealthReporter reporter{pipeline, sink};
  Stamp now{1'767'225'600'000'000'000};
};

TEST(BadInput, EmptySweepCountsAsDeliveredAndLeavesItsSectorUnobserved) {
  Room room;
  room.good(3);
  const std::size_t before = room.sink.topics.size();
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(room.sweep([](auto& m) { m.ranges.clear(), m.intensities.clear(); }), "");
  EXPECT_EQ(room.sink.topics.size(), before + 10);  // both scans, each time, without waiting
  EXPECT_TRUE(std::isnan(room.strict().ranges.at(ahead)));
  EXPECT_TRUE(std::isnan(room.safety().ranges.at(ahead)));
  EXPECT_NEAR(room.strict().ranges.at(behind), 5, 0.01);
  EXPECT_EQ(room.pipeline.status(room.pipeline.now()).sensors.at(0).counters.frames, 8U);
  EXPECT_EQ(room.pipeline.status(room.pipeline.now()).sensors.at(0).counters.rejected_total(), 0U);
  room.expect_valid();
}

TEST(BadInput, EmptySweepsFromTheBeginningDoNotHoldUpTheOthers) {
  Room room;
  for (int i = 0; i < 3; ++i) room.sweep([](auto& m) { m.ranges.clear(), m.intensities.clear(); });
  EXPECT_GE(room.sink.topics.size(), 4U);
  EXPECT_NEAR(room.strict().ranges.at(behind), 5, 0.01);
  EXPECT_TRUE(std::isnan(room.strict().ranges.at(ahead)));
}

TEST(BadInput, ASweepOfNanIsUnobservedAndNeverFree) {
  Room room;
  room.good();
  room.sweep([](auto& m) { m.ranges.assign(181, nan); });
  for (std::size_t beam = ahead - 80; beam <= ahead + 80; ++beam) {
    EXPECT_TRUE(std::isnan(room.strict().ranges.at(beam))) << beam;
    EXPECT_TRUE(std::isnan(room.safety().ranges.at(beam))) << beam;
  }
}

TEST(BadInput, AScannerUpsideDownGivesTheSameScan) {
  Room upright;
  const auto wedge = [](auto& m) {
    for (std::size_t i = 120; i < 150; ++i) m.ranges[i] = 3;
  };
  upright.sweep(wedge);
  Room reversed;
  reversed.sweep([&](auto& m) {
    wedge(m);
    std::reverse(m.ranges.begin(), m.ranges.end());
    std::swap(m.angle_min, m.angle_max);
    m.angle_increment = -m.angle_increment;
  });
  for (std::size_t i = 0; i < 360; ++i) {
    EXPECT_EQ(upright.strict().statuses[i], reversed.strict().statuses[i]) << i;
    if (upright.strict().statuses[i] == BeamStatus::hit) {
      EXPECT_NEAR(upright.strict().ranges[i], reversed.strict().ranges[i], 1e-4) << i;
    }
  }
}

TEST(BadInput, AMissingPoseIsAnErrorWithTheFramesNameUntilItComes) {
  Room room("");  // the front scanner's pose would come from tf
  room.good(60);
  const DiagnosticItem& item = room.item("merged around");
  EXPECT_EQ(item.health, Health::error);
  EXPECT_THAT(item.message, HasSubstr("front_laser"));
  EXPECT_THAT(item.message, HasSubstr("base_link"));
  EXPECT_TRUE(std::isnan(room.strict().ranges.at(ahead)));
  EXPECT_NEAR(room.strict().ranges.at(behind), 5, 0.01);
  room.poses.known = true;
  room.good(60);
  EXPECT_EQ(room.item("merged around").health, Health::ok) << room.item("merged around").message;
  EXPECT_NEAR(room.strict().ranges.at(ahead), 5, 0.01);
}

TEST(BadInput, ASourceMayChangeItsNumberOfBeamsAndTheOutputKeepsItsOwn) {
  Room room;
  room.good(2);
  const auto half = [](auto& m) {
    m.ranges.assign(91, 4.0F);
    m.intensities.assign(91, 1.0F);
    m.angle_increment = static_cast<float>(M_PI / 90);
  };
  for (int i = 0; i < 3; ++i) EXPECT_EQ(room.sweep(half), "");
  EXPECT_EQ(room.strict().beams, 360U);
  EXPECT_NEAR(room.strict().ranges.at(ahead), 4, 0.01);
  room.good();
  EXPECT_EQ(room.strict().beams, 360U);
  EXPECT_NEAR(room.strict().ranges.at(ahead), 5, 0.01);
  room.expect_valid();
}

TEST(BadInput, ReturnsBeyondTheOutputsRangeAreNoHitsButShowThatTheWayIsFree) {
  Room room;
  room.sweep([](auto& m) { m.ranges.assign(181, 25.0F); });
  for (std::size_t beam = ahead - 80; beam <= ahead + 80; ++beam) {
    EXPECT_EQ(room.strict().statuses.at(beam), BeamStatus::none) << beam;
    EXPECT_EQ(room.safety().statuses.at(beam), BeamStatus::none) << beam;
  }
  room.expect_valid();
}

TEST(BadInput, StampsIncreaseAndBeamsStayTheSameWhileSourcesComeAndGo) {
  Room room;
  Stamp last{};
  int outputs = 0;
  for (int i = 0; i < 300; ++i) {
    room.now = room.now + std::chrono::milliseconds(20);
    // The rear scanner dies twice, and comes back once with a clock that is a little behind.
    room.send("front", room.message("front_laser"));
    auto rear = room.message("rear_laser");
    if (i > 240) rear.header.stamp -= ros::Duration(0.3);
    if (i < 80 || (i > 140 && i < 180) || i > 240) room.send("rear", rear);
    room.pipeline.tick(room.now + std::chrono::milliseconds(15));
    if (room.sink.scans.count("around") == 0 || room.strict().stamp == last) continue;
    ++outputs;
    EXPECT_GT(room.strict().stamp, last) << i;
    EXPECT_EQ(room.safety().stamp, room.strict().stamp);
    EXPECT_EQ(room.strict().beams, 360U);
    room.expect_valid();
    last = room.strict().stamp;
  }
  EXPECT_GT(outputs, 200);
}

}  // namespace
}  // namespace lidard
