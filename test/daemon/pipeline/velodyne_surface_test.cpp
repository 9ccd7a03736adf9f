// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <tuple>

#include "daemon/health/pipeline_health.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/messages/convert.h"
#include "test/sim/servers/velodyne_stream.h"
#include "test/support/recording_sink.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using sim::SimulatedPacket;
using sim::VelodyneSetup;
using ::testing::HasSubstr;

/// Keeps what a pipeline publishes.
/// A cloud of the sensor as its message.
sensor_msgs::PointCloud2 message_of(const test::RecordingSink& sink, std::size_t i) {
  return test::message_of(sink.clouds.at("roof/points").at(i));
}

const Endpoint sensor{IpAddress::v4(192, 168, 1, 201), 2368};

test::RecordingSink play(const std::string& keys, const std::vector<SimulatedPacket>& packets,
                         const std::string& model) {
  const Config config = parse_config("sensors: {roof: {model: " + model + ", " + keys + "}}", "f");
  NoTransforms poses;
  test::RecordingSink sink;
  Pipeline pipeline(config, poses, sink);
  for (const auto& packet : packets)
    pipeline.packet({packet.view(), packet.arrival, sensor, {{}, packet.port}});
  pipeline.finish(packets.back().arrival);
  return sink;
}

std::vector<SimulatedPacket> packets_of(const char* model, const char* mode, int ms) {
  VelodyneSetup setup;
  setup.model = model;
  setup.mode = mode;
  setup.divergence_mrad = 3;
  setup.duration = std::chrono::milliseconds(ms);
  return simulate_velodyne(setup);
}

CloudPoint point_at(const Cloud& cloud, std::size_t slot) {
  CloudPoint point;
  std::memcpy(&point, cloud.points_bytes.data() + slot * sizeof point, sizeof point);
  return point;
}

using Place = std::tuple<float, float, float, float, int>;

std::multiset<Place> finite_points(const Cloud& cloud) {
  std::multiset<Place> places;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint p = point_at(cloud, i);
    if (std::isfinite(p.x)) places.insert({p.x, p.y, p.z, p.intensity, p.ring});
  }
  return places;
}

TEST(VelodyneSurface, AnOrganisedCloudHoldsEveryReturnInItsRow) {
  for (const char* mode : {"strongest", "dual"}) {
    const auto packets = packets_of("velodyne_vlp16", mode, 350);
    const test::RecordingSink plain = play("clock: arrival", packets, "velodyne_vlp16");
    const test::RecordingSink rows = play("clock: arrival, organize_cloud: true", packets, "velodyne_vlp16");
    const test::RecordingSink lines =
        play("clock: arrival, organize_cloud: firings", packets, "velodyne_vlp16");
    const auto& list = plain.clouds.at("roof/points");
    ASSERT_GE(list.size(), 2U);
    ASSERT_EQ(rows.clouds.at("roof/points").size(), list.size());
    for (std::size_t f = 0; f < list.size(); ++f) {
      const Cloud& made = rows.clouds.at("roof/points")[f];
      ASSERT_EQ(finite_points(made), finite_points(list[f]));
      ASSERT_EQ(finite_points(lines.clouds.at("roof/points")[f]), finite_points(list[f]));
      const auto message = message_of(rows, f);
      EXPECT_EQ(message.height, 16U);
      EXPECT_EQ(message.width, list[f].columns.size());
      EXPECT_EQ(message.row_step, message.width * 22);
      EXPECT_EQ(message.data.size(), message.row_step * message.height);
      EXPECT_FALSE(message.is_dense);
      const auto across = message_of(lines, f);
      EXPECT_EQ(across.width, 16U);
      EXPECT_EQ(across.height, message.width);
      for (std::size_t i = 0; i < made.size(); ++i) ASSERT_EQ(point_at(made, i).ring, i / message.width);
    }
    EXPECT_EQ(message_of(plain, 0).height, 1U);
    EXPECT_TRUE(message_of(plain, 0).is_dense);
  }
}

TEST(VelodyneSurface, FrameStampLastMovesTheStampAndNoPoint) {
  const auto packets = packets_of("velodyne_vlp16", "strongest", 350);
  const test::RecordingSink first = play("clock: arrival", packets, "velodyne_vlp16");
  const test::RecordingSink last = play("clock: arrival, frame_stamp: last", packets, "velodyne_vlp16");
  const auto& a = first.clouds.at("roof/points");
  const auto& b = last.clouds.at("roof/points");
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t f = 0; f < a.size(); ++f) {
    ASSERT_EQ(a[f].size(), b[f].size());
    EXPECT_NEAR(seconds(b[f].stamp - a[f].stamp), 0.1, 0.001);
    EXPECT_LE(seconds(b[f].stamp - a[f].end), 60e-6) << "no later than the last firing";
    for (std::size_t i = 0; i < a[f].size(); ++i) {
      const double since_a = seconds(a[f].stamp - Stamp{}) + static_cast<double>(point_at(a[f], i).time);
      const double since_b = seconds(b[f].stamp - Stamp{}) + static_cast<double>(point_at(b[f], i).time);
      ASSERT_NEAR(since_a, since_b, 1e-6);
      ASSERT_LE(point_at(b[f], i).time, 0);
    }
  }
}

TEST(VelodyneSurface, RangesAndViewKeepOnlyWhatIsAskedFor) {
  const auto packets = packets_of("velodyne_vlp16", "strongest", 350);
  const test::RecordingSink kept = play(
      "min_range: 3, max_range: 6, view_direction_deg: 90, view_width_deg: 60", packets, "velodyne_vlp16");
  const test::RecordingSink all = play("clock: smooth", packets, "velodyne_vlp16");
  const Cloud& cloud = kept.clouds.at("roof/points").at(0);
  ASSERT_GT(cloud.size(), 100U);
  EXPECT_LT(cloud.size(), all.clouds.at("roof/points").at(0).size() / 4);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint p = point_at(cloud, i);
    const float range = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    ASSERT_TRUE(range > 2.98F && range < 6.02F) << range;
    ASSERT_NEAR(std::atan2(p.y, p.x), M_PI / 2, (30 + 0.5) * M_PI / 180);
  }
}

TEST(VelodyneSurface, ARingIsAPlanarScanThatAgreesWithItsCloud) {
  for (const char* model : {"velodyne_vlp16", "velodyne_vlp32c", "velodyne_hdl32e", "velodyne_vls128"}) {
    SCOPED_TRACE(model);
    const test::RecordingSink sink =
        play("scan_ring: auto, scan_topic: scan, clock: arrival", packets_of(model, "strongest", 350), model);
    const auto& scans = sink.scans.at("scan");
    const auto& clouds = sink.clouds.at("roof/points");
    ASSERT_GE(scans.size(), 2U);
    ASSERT_EQ(scans.size(), clouds.size());
    const std::uint16_t ring =
        parse_config("sensors: {a: {model: " + std::string(model) + ", scan_ring: auto}}", "f")
            .sensors[0]
            .ring_scan->ring;
    for (std::size_t f = 0; f < scans.size(); ++f) {
      const PlanarScan& scan = scans[f];
      ASSERT_EQ(violation(scan), nullptr);
      EXPECT_EQ(scan.beams, 1800U);
      EXPECT_NEAR(scan.scan_time, 0.1, 5e-3) << "the simulator turns so that azimuths are exact";
      EXPECT_NEAR(scan.time_increment, scan.scan_time / 1800, 1e-9);
      if (f > 0) {
        EXPECT_NEAR(seconds(scan.stamp - scans[f - 1].stamp), static_cast<double>(scan.scan_time), 1e-3);
      }
      // Each return of the ring shows in the beam it points along, at its time.
      std::size_t agreeing = 0;
      std::size_t all = 0;
      for (std::size_t i = 0; i < clouds[f].size(); ++i) {
        const CloudPoint p = point_at(clouds[f], i);
        if (p.ring != ring) continue;
        const double along = std::atan2(p.y, p.x) - static_cast<double>(scan.angle_min);
        double turned = std::fmod(-along, 2 * M_PI);
        if (turned < 0) turned += 2 * M_PI;
        const auto beam = static_cast<std::size_t>(std::lround(turned / (2 * M_PI / 1800))) % 1800;
        const float range = std::hypot(static_cast<float>(p.x), static_cast<float>(p.y));
        ++all;
        agreeing += std::fabs(scan.ranges[beam] - range) < 0.02F * range ? 1U : 0U;
        const double fired = seconds(clouds[f].stamp - scan.stamp) + static_cast<double>(p.time);
        if (beam > 5 && beam < 1795) {
          ASSERT_NEAR(fired, static_cast<double>(scan.time_increment) * turned / (2 * M_PI / 1800), 1e-4);
        }
      }
      EXPECT_GT(all, 1000U);
      EXPECT_GT(static_cast<double>(agreeing), 0.97 * static_cast<double>(all));
    }
  }
}

TEST(VelodyneSurface, ASensorThatOnlySendsTelemetryIsNotReceiving) {
  VelodyneSetup setup;
  setup.model = "velodyne_vlp16";
  setup.duration = std::chrono::milliseconds(300);
  const auto packets = simulate_velodyne(setup);
  const Config config = parse_config("sensors: {roof: {model: velodyne_vlp16}}", "f");
  NoTransforms poses;
  test::RecordingSink sink;
  Pipeline pipeline(config, poses, sink);
  for (const auto& packet : packets)
    pipeline.packet({packet.view(), packet.arrival, sensor, {{}, packet.port}});
  const Stamp alive = packets.back().arrival;
  EXPECT_EQ(items_of(pipeline, alive).at(0).health, Health::ok) << items_of(pipeline, alive).at(0).message;
  const std::vector<std::uint8_t> position(512);
  Stamp now = alive;
  for (int i = 0; i < 40; ++i) {
    now = now + std::chrono::milliseconds(100);
    pipeline.packet({{position.data(), position.size()}, now, sensor, {{}, 8308}});
  }
  const DiagnosticItem item = items_of(pipeline, now).at(0);
  EXPECT_EQ(item.health, Health::error);
  EXPECT_THAT(item.message, HasSubstr("no data, only telemetry on port 8308"));
  EXPECT_EQ(pipeline.status(pipeline.now()).sensors.at(0).last_arrival, alive);
}

TEST(VelodyneSurface, TelemetryMayComeToAnotherPort) {
  const Config config = parse_config("sensors: {roof: {model: velodyne_vlp16, telemetry_port: 8309}}", "f");
  NoTransforms poses;
  test::RecordingSink sink;
  Pipeline pipeline(config, poses, sink);
  const std::vector<std::uint8_t> position(512);
  pipeline.packet({{position.data(), position.size()}, Stamp{1}, sensor, {{}, 8309}});
  EXPECT_EQ(pipeline.status(pipeline.now()).sensors.at(0).counters.other_packets, 1U);
  pipeline.packet({{position.data(), position.size()}, Stamp{2}, sensor, {{}, 8308}});
  EXPECT_EQ(pipeline.status(pipeline.now()).sensors.at(0).counters.other_packets, 1U);
  EXPECT_EQ(pipeline.unclaimed_senders().size(), 1U);
}

}  // namespace
}  // namespace lidard
