// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Virtual scans beside their beams: frames, stamps, poses that are missing, and what /diagnostics says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "test/support/pipeline_bench.h"

namespace lidard {
namespace {

using test::bench_begin;
using test::PipelineBench;
using testing::HasSubstr;

/// Points on posts around the lidar, in its frame, measured one after the other over 100 ms; the cloud of
/// another driver, without columns.
Cloud posts(Stamp begin, const std::vector<Eigen::Vector3d>& places) {
  Cloud cloud;
  cloud.frame_id = "roof";
  cloud.rings = 1;
  cloud.stamp = begin;
  cloud.end = begin + ms(100);
  cloud.points_bytes.resize(places.size() * sizeof(CloudPoint));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const float time = 0.1F * static_cast<float>(i) / static_cast<float>(places.size() - 1);
    cloud.points()[i] = {static_cast<float>(places[i].x()),
                         static_cast<float>(places[i].y()),
                         static_cast<float>(places[i].z()),
                         1,
                         0,
                         time};
  }
  return cloud;
}

std::vector<Eigen::Vector3d> ring_of_posts(double distance, double height, int count = 12) {
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count + 0.1;
    places.emplace_back(distance * std::cos(angle), distance * std::sin(angle), height);
  }
  return places;
}

/// A virtual scan `v` of frames of which `low` and `high` have a pose.
std::string levels(const std::string& frames, const std::string& keys = "", const std::string& vehicle = "") {
  std::string poses;
  if (frames.find("low") != std::string::npos) poses = "low: {xyz: [0, 0, 0.5]}, ";
  if (frames.find("high") != std::string::npos) poses += "high: {xyz: [0, 0, 1.5]}";
  return "vehicle: {" + vehicle +
         "}\n"
         "sensors: {roof: {topic: /roof, pose: {xyz: [0.5, 0, 2], rpy_deg: [0, 0, 90]}}}\n"
         "virtual_scans: {v: {cloud_topic: roof, base_frame: base_link, range_max: 30, beams: 720, "
         "virtual_laser_scan: [" +
         frames + "], poses: {" + poses + "}" + keys + "}}\n";
}

int hits(const PlanarScan& scan) {
  return static_cast<int>(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::hit));
}

TEST(VirtualScanMaker, FramesThatShareATopicComeInOrderWithStampsThatIncrease) {
  PipelineBench bench(levels("high, low", ", output_laser_topic: cut"));
  for (const double at : {0.0, 100.0, 100.0, 50.0})
    bench.give("roof", posts(bench_begin + ms(at), ring_of_posts(5, 0)), bench_begin + ms(200));
  const auto& scans = bench.sink.scans["cut"];
  ASSERT_EQ(scans.size(), 4U) << "the cloud that came twice, and an older one, are not cut again";
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_EQ(scans[i].frame_id, i % 2 == 0 ? "high" : "low") << i;
    if (i > 0) {
      EXPECT_GT(scans[i].stamp, scans[i - 1].stamp) << i;
    }
  }
  EXPECT_EQ(scans[0].stamp, bench_begin);
  EXPECT_EQ(scans[1].stamp, bench_begin + Span(1));
  EXPECT_EQ(scans[2].stamp, bench_begin + ms(100));
  EXPECT_EQ(bench.value("virtual v", "Published", bench_begin + ms(200)), "4");
  EXPECT_EQ(bench.value("virtual v", "Held back without a newer instant", bench_begin + ms(200)), "2");
}

TEST(VirtualScanMaker, FramesWithTopicsOfTheirOwnHaveTheCloudsStamp) {
  PipelineBench bench(levels("high, low", ", also: {flat: flatten}"));
  for (const double at : {0.0, 100.0})
    bench.give("roof", posts(bench_begin + ms(at), ring_of_posts(5, 0)), bench_begin + ms(at + 100));
  for (const char* topic : {"high", "low", "high/flat", "low/flat"}) {
    ASSERT_EQ(bench.sink.count(topic), 2U) << topic;
    EXPECT_EQ(bench.sink.scans[topic][1].stamp, bench_begin + ms(100)) << topic;
    EXPECT_EQ(bench.sink.released[topic][1], bench_begin + ms(200)) << topic;
    EXPECT_EQ(bench.sink.scans[topic][1].frame_id,
              std::string(topic).substr(0, std::string(topic).find('/')));
  }
}

TEST(VirtualScanMaker, StampsDoNotGoBackOverAChange) {
  PipelineBench bench(levels("low"));
  bench.give("roof", posts(bench_begin + ms(100), ring_of_posts(5, 0)), bench_begin + ms(200));
  OutputScanConfig wanted = bench.config.virtual_scans[0].output;
  wanted.grid.beams = 360;
  ASSERT_EQ(bench.pipeline.set_scan({MakerId::Kind::virtual_group, "v"}, wanted), "");
  bench.give("roof", posts(bench_begin + ms(90), ring_of_posts(5, 0)), bench_begin + ms(210));
  EXPECT_EQ(bench.sink.count("low"), 1U);
  bench.give("roof", posts(bench_begin + ms(200), ring_of_posts(5, 0)), bench_begin + ms(310));
  ASSERT_EQ(bench.sink.count("low"), 2U);
  EXPECT_EQ(bench.sink.scans["low"][1].beams, 360U);
  EXPECT_EQ(bench.sink.scans["low"][1].stamp, bench_begin + ms(200));
  EXPECT_EQ(bench.value("virtual v", "Published", bench_begin + ms(210)), "2");
}

/// The posts as they were seen from a lidar whose vehicle turned on the spot at 1 rad/s; `flatten` with
/// motion has to bring them back to where they stand, as seen at the end of the cloud.
TEST(VirtualScanMaker, PointsAloneAreBroughtToOneInstantTooFromTheirLidarsPlaceOnTheVehicle) {
  PipelineBench bench(levels("low", ", max_height: 3", "odometry_topic: /odom"));
  const Pose mount = make_pose({0.5, 0, 2}, {0, 0, M_PI / 2});
  const double rate = 1;
  for (int at = -50; at <= 150; at += 10)
    bench.pipeline.pose_message(bench_begin + ms(at), make_pose({0, 0, 0}, {0, 0, rate * at / 1000}), "",
                                bench_begin + ms(150));
  std::vector<Eigen::Vector3d> in_world, seen;
  for (int i = 0; i < 12; ++i) {
    const double angle = 2 * M_PI * i / 12 + 0.1;
    in_world.emplace_back(6 * std::cos(angle), 6 * std::sin(angle), 1);
    const Pose vehicle = make_pose({0, 0, 0}, {0, 0, rate * 0.1 * i / 11});
    seen.push_back((vehicle * mount).inverse() * in_world.back());
  }
  bench.give("roof", posts(bench_begin, seen), bench_begin + ms(150));
  ASSERT_EQ(bench.sink.count("low"), 1U);
  const PlanarScan& scan = bench.sink.scans["low"][0];
  EXPECT_EQ(scan.stamp, bench_begin + ms(100));
  EXPECT_EQ(hits(scan), 12);
  const double yaw = rate * 0.1;
  for (const Eigen::Vector3d& place : in_world) {
    const double angle = std::remainder(std::atan2(place.y(), place.x()) - yaw, 2 * M_PI);
    double nearest = 10;
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      if (scan.statuses[beam] != BeamStatus::hit) continue;
      EXPECT_NEAR(scan.ranges[beam], 6, 1e-3);
      nearest = std::min(nearest,
                         std::abs(std::remainder(static_cast<double>(scan.angle(beam)) - angle, 2 * M_PI)));
    }
    EXPECT_LE(nearest, 2 * M_PI / 720) << "a post at " << angle;
  }
  EXPECT_EQ(bench.value("virtual v", "Not deskewed", bench_begin + ms(150)), "0");
}

TEST(VirtualScanMaker, NeedsTheLidarsPlaceOnTheVehicleOnlyForWhatIsKnownOfTheVehicle) {
  const auto published = [](const std::string& keys, const std::string& vehicle) {
    PipelineBench bench(
        "vehicle: {" + vehicle +
        "}\nsensors: {roof: {topic: /roof}}\n"
        "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [roof], output_laser_topic: cut, " +
        keys + "}}\n");
    bench.give("roof", posts(bench_begin, ring_of_posts(5, 0)), bench_begin);
    return bench.sink.count("cut");
  };
  EXPECT_EQ(published("profile: flatten", ""), 1U) << "a cut in the lidar's own frame";
  EXPECT_EQ(published("profile: flatten", "footprint: [[-1, -1], [1, -1], [0, 1]]"), 0U);
  EXPECT_EQ(published("profile: flatten", "odometry_topic: /odom"), 0U);
  EXPECT_EQ(published("profile: safety, ground: none", ""), 0U);
}

TEST(VirtualScanMaker, CountsCloudsAndFramesWithoutAPlaceAndNamesThem) {
  PipelineBench bench(levels("low, nowhere"));
  const Stamp now = bench_begin + ms(100);
  EXPECT_THAT(
      why_missing(bench.pipeline, "low"),
      ::testing::StartsWith("no output: no input has come in yet; see the state of its sensors; roof: "));
  bench.give("roof", posts(bench_begin, ring_of_posts(5, 0)), now);
  EXPECT_EQ(bench.value("virtual v", "Inputs without pose", now), "1");
  EXPECT_EQ(bench.value("virtual v", "Published", now), "1");
  EXPECT_EQ(bench.item("virtual v", now).health, Health::warn);
  EXPECT_EQ(bench.item("virtual v", now).message,
            "publishing without nowhere: no tf from nowhere to base_link");
  bench.tf.set("base_link", "nowhere", Pose::Identity());
  bench.give("roof", posts(bench_begin + ms(100), ring_of_posts(5, 0)), now + ms(100));
  EXPECT_EQ(bench.item("virtual v", now + ms(100)).health, Health::ok);
  EXPECT_EQ(bench.item("virtual v", now + ms(100)).message, "publishing");
}

TEST(VirtualScanMaker, OfACloudWhoseOwnPlaceIsNotKnownNothingComesAndEveryFrameSaysWhy) {
  PipelineBench bench(
      "vehicle: {footprint: [[-1, -1], [1, -1], [0, 1]]}\nsensors: {roof: {topic: /roof}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [low, high], poses: {low: {xyz: [0, 0, "
      "1]}, "
      "high: {xyz: [0, 0, 2]}}}}\n");
  const Stamp now = bench_begin + ms(100);
  bench.give("roof", posts(bench_begin, ring_of_posts(5, 0)), now);
  EXPECT_EQ(bench.sink.count("low") + bench.sink.count("high"), 0U);
  for (const char* frame : {"low", "high"})
    EXPECT_EQ(why_missing(bench.pipeline, frame), "no output: no tf from roof to base_link");
  bench.pipeline.tick(now);
  bench.pipeline.tick(now + ms(1000));
  EXPECT_EQ(bench.item("virtual v", now + ms(1000)).health, Health::error);
  EXPECT_EQ(bench.item("virtual v", now + ms(1000)).message, "no output: no tf from roof to base_link");
  EXPECT_EQ(bench.value("virtual v", "Inputs without pose", now), "1");
}

TEST(VirtualScanMaker, ACloudWithoutRingsIsToldForProfilesThatNeedThem) {
  PipelineBench bench(levels("low", ", profile: safety, ground: none"));
  const Stamp now = bench_begin + ms(100);
  bench.give("roof", posts(bench_begin, ring_of_posts(5, 0)), now);
  const DiagnosticItem item = bench.item("virtual v", now);
  EXPECT_EQ(item.health, Health::warn);
  EXPECT_THAT(item.message, HasSubstr("points alone, nothing is known to be free: of the cloud "));
  EXPECT_EQ(test::value_of(item, "Clouds without rings"), "1");
  EXPECT_EQ(test::value_of(item, "Returns on the vehicle"), "0");
}

TEST(VirtualScanMaker, SaysNothingMoreWhenItsCloudsStopAndAnErrorAfterThreeSeconds) {
  PipelineBench bench(levels("low"));
  for (double at = 0; at <= 2000; at += 100) {
    bench.give("roof", posts(bench_begin + ms(at), ring_of_posts(5, 0)), bench_begin + ms(at));
    bench.pipeline.tick(bench_begin + ms(at));
  }
  const auto later = [&](double at) { return bench.item("virtual v", bench_begin + ms(at)); };
  EXPECT_EQ(later(5000).health, Health::ok);
  EXPECT_EQ(later(5001).health, Health::error);
  EXPECT_EQ(later(5001).message, "no output for more than 3 s; see the state of its sensors");
}

}  // namespace
}  // namespace lidard
