// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What of a sensor changes while it runs: from the next revolution on, and not one is lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "test/sim/servers/velodyne_stream.h"
#include "test/support/recording_sink.h"

namespace lidard {
namespace {

const Endpoint sender{IpAddress::v4(192, 168, 1, 201), 2368};

/// The clouds and ring scans of 0.75 s, in whose middle the sensor is given what `keys` say.
test::RecordingSink play(const std::string& keys) {
  sim::VelodyneSetup setup;
  setup.model = "velodyne_vlp16";
  setup.mode = "strongest";
  setup.duration = std::chrono::milliseconds(750);
  const auto packets = simulate_velodyne(setup);
  const auto config_with = [](const std::string& more) {
    return parse_config(
        "sensors: {roof: {model: velodyne_vlp16, clock: arrival, scan_ring: auto, raw_topic: raw" + more +
            "}}",
        "f");
  };
  const Config config = config_with("");
  NoTransforms poses;
  test::RecordingSink sink;
  Pipeline pipeline(config, poses, sink);
  for (std::size_t i = 0; i < packets.size(); ++i) {
    if (i == packets.size() / 2 && !keys.empty()) {
      EXPECT_EQ(pipeline.set_sensor(config_with(keys).sensors[0]), "");
    }
    pipeline.packet({packets[i].view(), packets[i].arrival, sender, {{}, packets[i].port}});
  }
  pipeline.finish(packets.back().arrival);
  return sink;
}

double farthest(const Cloud& cloud) {
  double most = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint p = cloud.points()[i];
    if (std::isfinite(p.x)) most = std::max(most, static_cast<double>(std::hypot(p.x, p.y, p.z)));
  }
  return most;
}

TEST(SensorChange, ComesIntoForceWithTheNextRevolution) {
  const auto before = play("").clouds.at("roof/points");
  const double limit = 0.8 * farthest(before.at(0));
  const auto sink = play(", max_range: " + std::to_string(limit) + ", time_offset: 0.5");
  const auto& after = sink.clouds.at("roof/points");
  ASSERT_EQ(after.size(), before.size()) << "not a revolution is lost";
  std::size_t changed = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    const bool is_new = after[i].stamp != before[i].stamp;
    changed += is_new;
    ASSERT_TRUE(is_new || changed == 0) << "what changed stays so";
    EXPECT_EQ(after[i].columns.size(), before[i].columns.size());
    if (!is_new) {
      EXPECT_EQ(after[i].points_bytes, before[i].points_bytes) << "a revolution has one limit";
      continue;
    }
    EXPECT_EQ(after[i].stamp - before[i].stamp, std::chrono::milliseconds(500));
    EXPECT_LE(farthest(after[i]), limit + 0.001);
    EXPECT_GT(after[i].size(), 1000U);
  }
  EXPECT_GE(changed, 2U);
  EXPECT_LT(changed, after.size());
  EXPECT_NEAR(sink.scans.at("roof/scan").back().range_max, limit, 1e-4);
  const auto raw = sink.of<RawPackets>("raw");
  ASSERT_GE(raw.size(), 2U);
  EXPECT_GT(raw.back().stamp - raw.front().stamp, std::chrono::milliseconds(500 + 300))
      << "packets have the offset too: the stream lasts 0.75 s";
}

TEST(SensorChange, LeavesOutWhatIsNoMoreInView) {
  const auto sink = play(", view_direction: 1.5707963, view_width: 1");
  const Cloud& cloud = sink.clouds.at("roof/points").back();
  ASSERT_GT(cloud.size(), 1000U);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint p = cloud.points()[i];
    ASSERT_NEAR(std::atan2(p.y, p.x), M_PI / 2, 0.52);
  }
}

TEST(SensorChange, ArrangesCloudsOtherwise) {
  const auto clouds = play(", organize_cloud: firings").clouds.at("roof/points");
  EXPECT_EQ(clouds.front().height, 0U);
  EXPECT_GT(clouds.back().height, 1000U);
}

TEST(SensorChange, RefusesASensorThatIsNotThere) {
  const Config config = parse_config("sensors: {roof: {model: velodyne_vlp16}}", "f");
  NoTransforms poses;
  test::RecordingSink sink;
  Pipeline pipeline(config, poses, sink);
  SensorConfig other = config.sensors[0];
  other.name = "mast";
  EXPECT_EQ(pipeline.set_sensor(other), "there is no sensor named mast");
}

}  // namespace
}  // namespace lidard
