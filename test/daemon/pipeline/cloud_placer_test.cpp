// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// points_frame and deskew: the clouds of the demo's roof lidar against the way that its vehicle truly drove.
#include "daemon/pipeline/cloud_placer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "daemon/health/output_health.h"
#include "daemon/health/pipeline_health.h"
#include "daemon/health/report.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/capture/pcap_source.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/world/units.h"
#include "test/support/allocations.h"
#include "test/support/captures.h"
#include "test/support/recording_sink.h"
#include "test/support/says.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;

const Pose mount = make_pose({0, 0, 2}, {0, 0, 0});

/// tf of the demo's vehicle: its true way, known so long after the time at hand.
class TrueWay final : public TransformSource {
 public:
  explicit TrueWay(Span late) : late_(late) {}
  Pose at(Stamp stamp) const { return scene_.vehicle_at(stamp); }
  bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
              std::string& why_not) override {
    ++lookups;
    const bool is_known = stamp <= now - late_;
    why_not = is_known ? "tf does not know " + child : child + " at that time is not known yet";
    if (!is_known || parent != "base_link" || child != "odom") return false;
    pose = at(stamp).inverse();
    return true;
  }
  void history(const std::string&, const std::string&, Stamp after, Stamp until,
               std::vector<StampedPose>& poses) override {
    const Stamp newest = std::min(until, now - late_);
    for (Stamp one = std::max(after, scene_.start) + ms(10); one <= newest; one = one + ms(10))
      poses.push_back({one, at(one)});
  }

  Stamp now{};
  std::size_t lookups = 0;

 private:
  sim::Scene scene_ = sim::load_scene(test::project_file("pcaps/demo.scene.yaml"));
  Span late_;
};

struct Demo {
  explicit Demo(const std::string& keys, Span late = ms(20)) : way(late) {
    const Config config = parse_config(
        "vehicle: {odometry_frame: odom}\n"
        "sensors: {roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, frame_id: velodyne, "
        "pose: {xyz: [0, 0, 2]}" +
            keys +
            "}}\nvirtual_scans: {low: {cloud_topic: roof, base_frame: base_link, virtual_laser_scan: [v], "
            "poses: {v: {xyz: [0, 0, 0.5]}}}}",
        "f");
    Pipeline pipeline(config, way, sink);
    const HealthReporter reporter(pipeline, sink);
    PcapSource source(test::project_file("pcaps/demo.pcap"));
    Packet packet;
    while (source.next(packet)) {
      way.now = packet.arrival;
      pipeline.packet(packet);
      pipeline.tick(packet.arrival);
    }
    pipeline.finish(way.now);
    remark = why_missing(pipeline, "roof/points");
    print_verdicts(pipeline.status(pipeline.now()).sensors, verdicts);
  }
  const std::vector<Cloud>& clouds() { return sink.clouds["roof/points"]; }
  const DiagnosticItem& item() { return sink.item("sensor roof"); }

  TrueWay way;
  test::RecordingSink sink;
  std::ostringstream verdicts;
  std::string remark;  // in the table of outputs
};

Eigen::Vector3d place_of(const CloudPoint& p) { return Eigen::Vector3f(p.x, p.y, p.z).cast<double>(); }

/// The greatest distance, m, of a return from where it truly was: where `raw` has it, taken along the way to
/// the frame that `frame_from_odom` gives for the stamp of a message.
template <class FrameFromOdom>
double worst_error(Demo& placed, Demo& raw, FrameFromOdom frame_from_odom) {
  double worst = 0;
  for (std::size_t c = 0; c < placed.clouds().size(); ++c) {
    const Cloud& one = placed.clouds()[c];
    const Cloud& measured = raw.clouds().at(c);
    EXPECT_EQ(one.size(), measured.size());
    const Pose to_frame = frame_from_odom(one.stamp);
    for (std::size_t i = 0; i < one.size(); ++i) {
      const CloudPoint p = one.points()[i], m = measured.points()[i];
      EXPECT_EQ(p.ring, m.ring);
      EXPECT_EQ(p.intensity, m.intensity);
      EXPECT_EQ(p.time, m.time);
      const Stamp fired = measured.stamp + span_from_seconds(static_cast<double>(m.time));
      worst = std::max(worst, (to_frame * raw.way.at(fired) * mount * place_of(m) - place_of(p)).norm());
    }
  }
  return worst;
}

TEST(CloudPlacer, ADeskewedCloudShowsTheInstantOfItsStamp) {
  for (const char* stamp : {"", ", frame_stamp: last"}) {
    Demo raw(stamp);
    Demo deskewed(stamp + std::string(", deskew: true"));
    ASSERT_GE(deskewed.clouds().size(), 15U);
    ASSERT_EQ(deskewed.clouds().size(), raw.clouds().size());
    EXPECT_EQ(deskewed.clouds()[3].frame_id, "velodyne");
    EXPECT_EQ(deskewed.clouds()[3].stamp, raw.clouds()[3].stamp);
    const auto lidar_from_odom = [&](Stamp at) { return (raw.way.at(at) * mount).inverse(); };
    EXPECT_LT(worst_error(deskewed, raw, lidar_from_odom), 0.005) << stamp;
    EXPECT_GT(worst_error(raw, raw, lidar_from_odom), 0.2) << "what is not deskewed is seen to be wrong";
    EXPECT_EQ(deskewed.item().health, Health::ok) << deskewed.item().message;
    EXPECT_EQ(test::value_of(deskewed.item(), "Not deskewed"), "0");
    // Virtual scans are brought to one instant by themselves.
    ASSERT_EQ(deskewed.sink.scans["v"].size(), raw.sink.scans["v"].size());
    for (std::size_t i = 0; i < raw.sink.scans["v"].size(); ++i)
      EXPECT_EQ(deskewed.sink.scans["v"][i].statuses, raw.sink.scans["v"][i].statuses);
  }
}

TEST(CloudPlacer, InAFrameThatStandsStillEveryReturnIsWhereItWas) {
  Demo raw(", frame_stamp: last");
  Demo placed(", frame_stamp: last, points_frame: odom, deskew: true", ms(45));
  ASSERT_EQ(placed.clouds().size() + 1, raw.clouds().size()) << "all but the last one's pose come in time";
  EXPECT_EQ(test::value_of(placed.item(), "Left out without poses"), "0");
  EXPECT_THAT(placed.verdicts.str(), HasSubstr("WARN roof: 1 cloud not published"));
  EXPECT_EQ(placed.clouds()[3].frame_id, "odom");
  EXPECT_LT(worst_error(placed, raw, [](Stamp) { return Pose::Identity(); }), 0.005);
  for (std::size_t i = 1; i + 1 < placed.clouds().size(); ++i) {
    const double waited = seconds(placed.sink.released["roof/points"][i] - placed.clouds()[i].stamp);
    EXPECT_GE(waited, 0.045);
    EXPECT_LT(waited, 0.06) << "no longer than it takes";
  }
  EXPECT_LT(placed.way.lookups, 13 * raw.clouds().size()) << "not at each packet";
}

TEST(CloudPlacer, AFrameOfTheVehicleNeedsNoMotion) {
  Demo raw("");
  Demo placed(", points_frame: base_link", ms(5000));
  ASSERT_EQ(placed.clouds().size(), raw.clouds().size());
  EXPECT_EQ(placed.clouds()[0].frame_id, "base_link");
  for (std::size_t c = 0; c < raw.clouds().size(); ++c) {
    for (std::size_t i = 0; i < raw.clouds()[c].size(); ++i) {
      const auto moved = place_of(placed.clouds()[c].points()[i]);
      ASSERT_LT((mount * place_of(raw.clouds()[c].points()[i]) - moved).norm(), 1e-5);
    }
  }
}

TEST(CloudPlacer, PosesThatDoNotComeAreToldAndCounted) {
  Demo raw("");
  Demo standing(", deskew: true", ms(5000));
  ASSERT_EQ(standing.clouds().size(), raw.clouds().size()) << "clouds go on";
  EXPECT_EQ(standing.clouds()[5].points_bytes, raw.clouds()[5].points_bytes);
  EXPECT_EQ(standing.item().health, Health::warn);
  EXPECT_THAT(standing.item().message, test::Says(says::as_if_it_stood));
  EXPECT_THAT(standing.verdicts.str(),
              HasSubstr("WARN roof: " + std::to_string(raw.clouds().size()) + " clouds not deskewed"));
  Demo nowhere(", points_frame: odom", ms(5000));
  EXPECT_TRUE(nowhere.clouds().empty());
  EXPECT_EQ(nowhere.item().health, Health::warn);
  EXPECT_THAT(nowhere.item().message, HasSubstr("not published in odom: odom at that time is not known yet"));
  EXPECT_THAT(nowhere.remark, HasSubstr("not published in odom"));
  EXPECT_EQ(standing.remark, "");
  EXPECT_THAT(nowhere.verdicts.str(),
              HasSubstr("WARN roof: " + std::to_string(raw.clouds().size()) + " clouds not published"));
}

TEST(CloudPlacer, NothingIsAllocatedPerCloudAfterWarmUp) {
  Demo raw("");
  const Config config = parse_config(
      "vehicle: {odometry_frame: odom}\nsensors: {roof: {model: velodyne_vlp16, frame_id: velodyne, "
      "pose: {xyz: [0, 0, 2]}, points_frame: base_link, deskew: true}}",
      "f");
  TrueWay way(ms(0));
  FrameTree frames(config.vehicle.base_frame, fixed_poses(config), way);
  VehicleMotion motion(config.vehicle, way, frames);
  CloudArranger arranger{CloudLayout()};
  struct Counting final : FrameSink {
    void publish(const OutputTopic&, const Frame&, Stamp) override { ++published; }
    std::size_t published = 0;
  } sink;
  Router router(sink);
  router.configure(config);
  const PipelineContext context{config.vehicle, frames, motion, router};
  CloudPlacer placer(config.sensors[0], arranger, context, router.topic("roof/points"));
  // The same cloud at the time of another one, since poses come in but once.
  Cloud cloud = raw.clouds().at(3);
  std::uint64_t before = 0;
  for (std::size_t i = 3; i < 13; ++i) {
    if (i == 6) before = test::allocations();
    const Span later = raw.clouds()[i].stamp - cloud.stamp;
    cloud.stamp = cloud.stamp + later;
    cloud.end = cloud.end + later;
    for (CloudColumn& column : cloud.columns) column.stamp = column.stamp + later;
    way.now = cloud.end + ms(1);
    placer.add(cloud, way.now);
  }
  EXPECT_EQ(test::allocations() - before, 0U);
  EXPECT_EQ(sink.published, 10U);
  EXPECT_EQ(pose_losses(placer.gate(), ""), "");
}

}  // namespace
}  // namespace lidard
