// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Merged clouds through the whole pipeline: when they come, of what, and what is reported.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/offline/no_transforms.h"
#include "drivers/capture/pcap_source.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"
#include "test/support/captures.h"
#include "test/support/pipeline_bench.h"

namespace lidard::test {
namespace {

using ::testing::HasSubstr;

/// Two lidars of other drivers and a merged cloud of both.
std::string two_lidars(const std::string& keys = "", const std::string& vehicle = "") {
  return "vehicle: {" + vehicle +
         "}\n"
         "sensors:\n"
         "  a: {topic: /a, pose: {xyz: [1, 0, 2]}}\n"
         "  b: {topic: /b, pose: {xyz: [-1, 0, 2], rpy_deg: [0, 0, 180]}}\n"
         "merged_clouds: {around: {sources: [a, b]" +
         keys + "}}\n";
}

/// A revolution of 90 ms that ends at `end`, with `points` returns 5 m ahead of the lidar.
void turn(PipelineBench& bench, const std::string& source, Span end, std::size_t points = 100) {
  Cloud cloud;
  cloud.frame_id = source;
  cloud.stamp = bench_begin + end - ms(90);
  cloud.end = bench_begin + end;
  cloud.rings = 1;
  cloud.points_bytes.resize(points * sizeof(CloudPoint));
  for (std::size_t i = 0; i < points; ++i)
    cloud.points()[i] = {5, 0, 0, 7, 0, static_cast<float>(0.09 * static_cast<double>(i) / 99)};
  bench.give(source, cloud, bench_begin + end);
}

std::size_t count_of(const MergedCloud& merged, std::uint16_t sensor) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < merged.size(); ++i) count += merged.points()[i].sensor == sensor ? 1 : 0;
  return count;
}

TEST(MergedCloud, ComesWhenBothHaveDeliveredWithTheReturnsOfEachInItsFrame) {
  PipelineBench bench(two_lidars());
  turn(bench, "a", ms(100));
  EXPECT_EQ(bench.sink.count("around"), 0U);
  turn(bench, "b", ms(130), 40);
  ASSERT_EQ(bench.sink.count("around"), 1U);
  const MergedCloud& merged = bench.sink.merged_clouds["around"][0];
  EXPECT_EQ(merged.frame_id, "base_link");
  ASSERT_EQ(merged.size(), 140U);
  EXPECT_EQ(count_of(merged, 0), 100U);
  EXPECT_EQ(count_of(merged, 1), 40U);
  const MergedPoint& first = merged.points()[0];
  EXPECT_FLOAT_EQ(first.point.x, 6);
  EXPECT_FLOAT_EQ(first.point.z, 2);
  EXPECT_FLOAT_EQ(first.point.intensity, 7);
  EXPECT_NEAR(merged.points()[139].point.x, -6, 1e-5);
  // The time at which a return was measured stays known.
  EXPECT_NEAR(seconds(merged.stamp - bench_begin) + static_cast<double>(first.point.time), 0.01, 1e-6);
}

TEST(MergedCloud, GoesOnWithoutALostSourceWhichIsAnError) {
  PipelineBench bench(two_lidars());
  for (int at = 100; at <= 1000; at += 100) turn(bench, "a", ms(at)), turn(bench, "b", ms(at + 30));
  EXPECT_EQ(bench.sink.count("around"), 10U);
  bench.pipeline.tick(bench_begin + ms(1050));
  EXPECT_EQ(bench.item("merged cloud around", bench_begin + ms(1050)).health, Health::ok);
  for (int at = 1100; at <= 3500; at += 100)
    turn(bench, "a", ms(at)), bench.pipeline.tick(bench_begin + ms(at + 50));
  EXPECT_GE(bench.sink.count("around"), 30U);
  EXPECT_EQ(count_of(bench.sink.merged_clouds["around"].back(), 1), 0U);
  const DiagnosticItem item = bench.item("merged cloud around", bench_begin + ms(3550));
  EXPECT_EQ(item.health, Health::error);
  EXPECT_THAT(item.message, HasSubstr("publishing without b"));
  EXPECT_THAT(value_of(item, "Source b"), HasSubstr("lost"));
  // It comes back.
  for (int at = 3600; at <= 6000; at += 100) turn(bench, "a", ms(at)), turn(bench, "b", ms(at + 30));
  EXPECT_EQ(count_of(bench.sink.merged_clouds["around"].back(), 1), 100U);
  bench.pipeline.tick(bench_begin + ms(6050));
  EXPECT_EQ(bench.item("merged cloud around", bench_begin + ms(6050)).health, Health::ok);
}

TEST(MergedCloud, WaitsForALateSourceAsLongAsTheDeadlineSays) {
  PipelineBench bench(two_lidars(", deadline: 0.02"));
  for (int at = 100; at <= 500; at += 100) turn(bench, "a", ms(at)), turn(bench, "b", ms(at + 10));
  ASSERT_EQ(bench.sink.count("around"), 5U);
  turn(bench, "a", ms(600));
  bench.pipeline.advance(bench_begin + ms(625));
  EXPECT_EQ(bench.sink.count("around"), 5U);
  bench.pipeline.advance(bench_begin + ms(640));
  EXPECT_GT(bench.sink.count("around"), 5U) << "the deadline is over";
  EXPECT_EQ(count_of(bench.sink.merged_clouds["around"].back(), 1), 0U);
  EXPECT_EQ(bench.sink.released["around"].back(), bench_begin + ms(630) + Span(1));
  turn(bench, "b", ms(650));
  turn(bench, "a", ms(700));
  EXPECT_EQ(count_of(bench.sink.merged_clouds["around"].back(), 1), 100U);
  EXPECT_EQ(bench.value("merged cloud around", "Sources waited for in vain", bench_begin + ms(700)), "1");
}

TEST(MergedCloud, OfAVehicleWithoutPosesIsStaticWaitedForOrLeftOut) {
  for (const char* choice : {"static", "wait", "drop"}) {
    PipelineBench bench(two_lidars(", on_missing_motion: " + std::string(choice), "odometry_topic: /odom"));
    for (int at = 100; at <= 1500; at += 100) {
      turn(bench, "a", ms(at)), turn(bench, "b", ms(at + 10));
      bench.pipeline.tick(bench_begin + ms(at + 60));
    }
    const DiagnosticItem item = bench.item("merged cloud around", bench_begin + ms(1560));
    if (std::string(choice) == "drop") {
      EXPECT_EQ(bench.sink.count("around"), 0U);
      EXPECT_THAT(why_missing(bench.pipeline, "around"), HasSubstr("on_missing_motion: drop"));
      continue;
    }
    EXPECT_GE(bench.sink.count("around"), 14U) << choice;
    EXPECT_EQ(item.health, Health::warn) << choice;
    EXPECT_THAT(item.message, HasSubstr("as if the vehicle stood still"));
    EXPECT_FLOAT_EQ(bench.sink.merged_clouds["around"].back().points()[0].point.x, 6);
  }
}

TEST(MergedCloud, OfASourceWithoutPoseSaysSo) {
  PipelineBench bench(
      "sensors: {a: {topic: /a, pose: {xyz: [1, 0, 2]}}, b: {topic: /b}}\n"
      "merged_clouds: {around: {sources: [a, b]}}\n");
  for (int at = 100; at <= 2000; at += 100) turn(bench, "a", ms(at)), turn(bench, "b", ms(at + 10));
  EXPECT_GT(bench.sink.count("around"), 10U);
  EXPECT_EQ(why_missing(bench.pipeline, "around"), "publishing without b: no tf from b to base_link");
  bench.tf.set("base_link", "b", make_pose({0, 0, 1}, {0, 0, 0}));
  for (int at = 2100; at <= 2200; at += 100) turn(bench, "a", ms(at)), turn(bench, "b", ms(at + 10));
  EXPECT_EQ(count_of(bench.sink.merged_clouds["around"].back(), 1), 100U);
}

TEST(MergedCloud, IsKeptOrMadeAnewByAChangedConfiguration) {
  PipelineBench bench(two_lidars());
  turn(bench, "a", ms(100));
  bench.pipeline.configure(parse_config(two_lidars(), "again"));
  turn(bench, "b", ms(110));
  EXPECT_EQ(bench.sink.count("around"), 1U) << "what came before the change counts";
  bench.pipeline.configure(
      parse_config(two_lidars(", organize_cloud: true, destination_topic: other"), "other"));
  turn(bench, "a", ms(200)), turn(bench, "b", ms(210));
  EXPECT_EQ(bench.sink.count("around"), 1U);
  EXPECT_EQ(bench.sink.count("other"), 1U);
}

/// Nobody subscribes unless `there`.
class Subscribers final : public FrameSink {
 public:
  bool wants(const OutputTopic&) const override { return there; }
  void publish(const OutputTopic& topic, const Frame& frame, Stamp) override {
    if (topic.name == "around") sizes.push_back(frame.merged_cloud()->size());
  }
  void skip(const OutputTopic& topic, Stamp) override { skipped += topic.name == "around" ? 1 : 0; }
  bool there = false;
  std::vector<std::size_t> sizes;
  std::size_t skipped = 0;
};

/// The demo's capture with a merged cloud of its lidar and its scanners.
struct Demo {
  explicit Demo(FrameSink& sink, const std::string& of_roof = "", const std::string& more = "")
      : config(parse_config(
            "sensors:\n"
            "  front_left: {model: sick_microscan3, ip_address: 192.168.0.21, pose: {xyz: [0, 1, 0.35], "
            "rpy_deg: [0, 0, 45]}}\n"
            "  front_right: {model: sick_microscan3, ip_address: 192.168.0.22, pose: {xyz: [0, -1, 0.35], "
            "rpy_deg: [0, 0, -45]}}\n"
            "  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, pose: {xyz: [0, 0, 2]}" +
                of_roof +
                "}\n"
                "merged_clouds: {around: {sources: [roof, front_left, front_right], policy: trigger, "
                "trigger: "
                "roof}}\n" +
                more,
            "demo")),
        pipeline(config, tf, sink) {}
  template <class Each>
  void play(Each each) {
    PcapSource source(project_file("pcaps/demo.pcap"));
    Packet packet;
    while (source.next(packet)) {
      each(packet);
      pipeline.packet(packet);
      last = packet.arrival;
    }
    pipeline.finish(last);
  }
  NoTransforms tf;
  Config config;
  Pipeline pipeline;
  Stamp last{};
};

TEST(MergedCloud, OfALidarAndScannersHasEachReturnOfTheNewestFramesOnce) {
  RecordingSink sink;
  Demo demo(sink, ", scan_ring: auto, scan_topic: roof/scan");  // its ring as a scan is no source
  std::size_t checked = 0;
  demo.play([&](const Packet&) {
    auto& merged = sink.merged_clouds["around"];
    if (merged.size() == checked) return;
    ++checked;
    EXPECT_EQ(count_of(merged.back(), 0), sink.clouds["roof/points"].back().size());
    std::size_t sensor = 1;
    for (const char* topic : {"front_left/scan", "front_right/scan"}) {
      const PlanarScan& scan = sink.scans[topic].back();
      const auto hits = std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::hit);
      EXPECT_EQ(count_of(merged.back(), static_cast<std::uint16_t>(sensor++)),
                static_cast<std::size_t>(hits));
    }
  });
  EXPECT_GE(checked, 17U);
}

TEST(MergedCloud, IsNotBuiltWhileNobodyWantsItAndIsWholeFromTheFirstSubscriberOn) {
  Subscribers sink;
  Demo demo(sink);
  std::string said;
  demo.play([&](const Packet& packet) {
    if (sink.skipped < 9) return;
    if (!sink.there) {
      EXPECT_TRUE(sink.sizes.empty());
      for (const DiagnosticItem& item : items_of(demo.pipeline, packet.arrival))
        if (item.name == "merged cloud around") said = item.message;
    }
    sink.there = true;
  });
  EXPECT_THAT(said, HasSubstr("not built: nobody subscribes to around"));
  EXPECT_GE(sink.sizes.size(), 8U);
  for (const std::size_t size : sink.sizes) EXPECT_GT(size, 10'000U);
}

TEST(MergedCloud, IsBuiltForTheVirtualScansThatAreMadeOfIt) {
  struct Scans final : FrameSink {
    bool wants(const OutputTopic&) const override { return false; }
    void publish(const OutputTopic& topic, const Frame& frame, Stamp) override {
      if (topic.name == "chest") stamps.push_back(frame.scan()->stamp);
    }
    std::vector<Stamp> stamps;
  } sink;
  Demo demo(sink, "",
            "virtual_scans: {levels: {cloud_topic: around, virtual_laser_scan: [chest], profile: safety, "
            "poses: {chest: {xyz: [0, 0, 1.2]}}}}\n");
  EXPECT_EQ(demo.config.virtual_scans[0].cloud_topic, "around");
  demo.play([](const Packet&) {});
  EXPECT_GE(sink.stamps.size(), 17U);
  EXPECT_TRUE(std::is_sorted(sink.stamps.begin(), sink.stamps.end()));
}

/// A truck with two VLP-16 that drives a curve of 5 m/s and 1 rad/s through a yard.
constexpr const char* scene_text = R"(
start: 2026-01-01T00:17:23.456Z
duration: 1.0
ground: {z: 0}
vehicle:
  start: {xy: [0, -5], yaw_deg: 0}
  path: [{duration: 1.2, speed: 5, yaw_rate_deg: 57.29577951308232}]
sensors:
  roof: {model: velodyne_vlp16, pose: {xyz: [0.9, 0.9, 2.1]}, from: 192.168.1.201:2368, to: 255.255.255.255:2368}
  roof_rear: {model: velodyne_vlp16, pose: {xyz: [-3, -0.9, 2.2], rpy_deg: [0, 3, 170]}, from: 192.168.1.202:2368, to: 255.255.255.255:2368, phase_ms: 31, options: {start_azimuth_deg: 100}}
objects:
  - wall: {from: [-20, -15], to: [20, -15], z: [0, 3]}
  - wall: {from: [20, -15], to: [20, 15], z: [0, 3]}
  - wall: {from: [20, 15], to: [-20, 15], z: [0, 3]}
  - wall: {from: [-20, 15], to: [-20, -15], z: [0, 3]}
  - box: {center: [9, -7, 0.5], size: [1.5, 1, 1]}
)";
constexpr const char* truck_text = R"(
vehicle: {odometry_topic: /odom}
sensors:
  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, pose: {xyz: [0.9, 0.9, 2.1]}}
  roof_rear: {model: velodyne_vlp16, ip_address: 192.168.1.202, pose: {xyz: [-3, -0.9, 2.2], rpy_deg: [0, 3, 170]}}
merged_clouds: {around: {sources: [roof, roof_rear]}}
)";

TEST(MergedCloud, OfADrivingTruckHasEachReturnWhereItWasAtTheInstant) {
  const sim::Scene scene = sim::parse_scene(scene_text, "scene");
  RecordingSink sink;
  const Config config = parse_config(truck_text, "truck");
  NoTransforms tf;
  Pipeline pipeline(config, tf, sink);
  // Exact places on the vehicle's frame at the start, by source, ring and time.
  struct Truth {
    Stamp time;
    Eigen::Vector3d place;
  };
  std::map<std::pair<std::uint16_t, std::uint16_t>, std::vector<Truth>> truth;
  int knots = 0;
  sim::simulate(scene, [&](const sim::SimPacket& packet) {
    for (; scene.start + ms(20 * knots) <= packet.time; ++knots) {
      const Stamp at = scene.start + ms(20 * knots);
      pipeline.pose_message(at, sim::vehicle_motion(scene, at, scene.start), "", packet.time);
    }
    if (packet.measurement != nullptr) {
      for (const auto& slot : packet.measurement->slots) {
        if (!std::isfinite(slot.wire) || !std::isfinite(slot.exact)) continue;
        const auto ring =
            static_cast<std::uint16_t>(slot.laser % 2 == 0 ? slot.laser / 2 : 8 + slot.laser / 2);
        truth[{static_cast<std::uint16_t>(packet.sensor), ring}].push_back(
            {slot.time, sim::vehicle_motion(scene, slot.time, scene.start) *
                            scene.sensors[packet.sensor].mount * slot.xyz});
      }
    }
    pipeline.packet({packet.payload, packet.time, packet.from, packet.to});
    return true;
  });
  const auto& clouds = sink.merged_clouds["around"];
  ASSERT_GE(clouds.size(), 8U);
  std::size_t points = 0;
  double worst = 0;
  for (std::size_t k = 1; k < clouds.size(); ++k) {
    const MergedCloud& merged = clouds[k];
    const Pose start_from_base = sim::vehicle_motion(scene, merged.stamp, scene.start);
    EXPECT_EQ(count_of(merged, 0), sink.clouds["roof/points"][k].size());
    EXPECT_EQ(count_of(merged, 1), sink.clouds["roof_rear/points"][k].size());
    for (std::size_t i = 0; i < merged.size(); ++i) {
      const MergedPoint& p = merged.points()[i];
      const Stamp at = merged.stamp + span_from_seconds(static_cast<double>(p.point.time));
      const auto& all = truth.at({p.sensor, p.point.ring});
      auto found = std::lower_bound(all.begin(), all.end(), at,
                                    [](const Truth& one, Stamp stamp) { return one.time < stamp; });
      if (found == all.end() || (found != all.begin() && at - (found - 1)->time < found->time - at)) --found;
      ASSERT_LT(std::abs(seconds(found->time - at)), 2e-5);
      const Eigen::Vector3d place =
          start_from_base * Eigen::Vector3f(p.point.x, p.point.y, p.point.z).cast<double>();
      worst = std::max(worst, (place - found->place).norm());
      ++points;
    }
  }
  EXPECT_GT(points, 100'000U);
  // The wire's steps are 2 mm and 0.01 degrees, which are 4 mm at 23 m.
  EXPECT_LT(worst, 0.005) << points;
  RecordProperty("worst_mm", std::to_string(worst * 1000));
}

}  // namespace
}  // namespace lidard::test
