// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

#include "daemon/config/config.h"
#include "daemon/health/pipeline_health.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/capture/pcap_source.h"
#include "test/daemon/pipeline/no_tf.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"
#include "test/sim/world/units.h"
#include "test/support/captures.h"
#include "test/support/recording_sink.h"

namespace lidard {
namespace {

/// What one sensor truly saw: exact points in its own frame, with the time of the first beam.
struct TrueFrame {
  Stamp begin;
  std::vector<Eigen::Vector3d> points;
};

struct DemoDrive {
  Config config = load_config(test::project_file("config/demo.yaml"));
  NoTf tf;
  test::RecordingSink sink;
  std::map<std::string, std::vector<TrueFrame>> truth;
  std::vector<SensorStatus> report;

  explicit DemoDrive(const std::function<void(Config&)>& change = {}) {
    if (change) change(config);
    play();
    simulate();
  }

  void play() {
    Pipeline pipeline(config, tf, sink);
    const HealthReporter reporter(pipeline, sink);
    PcapSource source(test::project_file("pcaps/demo.pcap"));
    Packet packet;
    Stamp last{};
    while (source.next(packet)) {
      pipeline.packet(packet);
      pipeline.tick(packet.arrival);
      last = packet.arrival;
    }
    pipeline.finish(last);
    report = pipeline.status(pipeline.now()).sensors;
    EXPECT_TRUE(pipeline.unclaimed_senders().empty());
  }

  void simulate() {
    const auto scene = sim::load_scene(test::project_file("pcaps/demo.scene.yaml"));
    std::map<std::string, double> last_azimuth;
    sim::simulate(scene, [&](const sim::SimPacket& packet) {
      if (packet.measurement == nullptr) return true;
      const std::string& name = scene.sensors[packet.sensor].name;
      auto& frames = truth[name];
      const bool planar = config.find_sensor(name)->model->kind == FrameKind::scan;
      if (planar || frames.empty()) frames.push_back({packet.measurement->begin, {}});
      for (const auto& slot : packet.measurement->slots) {
        // The device counts azimuth from 0 to 2 pi; firing sequences begin at laser 0.
        if (!planar && slot.laser == 0) {
          if (slot.azimuth < last_azimuth[name] - pi_d) frames.push_back({slot.time, {}});
          last_azimuth[name] = slot.azimuth;
        }
        if (std::isfinite(slot.wire) && std::isfinite(slot.exact)) frames.back().points.push_back(slot.xyz);
      }
      return true;
    });
  }

  /// The true frame of a sensor whose first beam is the nearest to `stamp`.
  const TrueFrame& nearest(const std::string& sensor, Stamp stamp) const {
    const auto& frames = truth.at(sensor);
    const TrueFrame* best = &frames.front();
    for (const auto& frame : frames) {
      if (std::abs((frame.begin - stamp).count()) < std::abs((best->begin - stamp).count())) best = &frame;
    }
    return *best;
  }
};

/// The flatten rule, written down a second time: nearest beam by angle, smallest range, heights within the
/// band.
class Reference {
 public:
  explicit Reference(const PlanarScan& scan, double low, double high)
      : scan_(scan), low_(low), high_(high), ranges_(scan.beams, INFINITY) {}

  /// What lies within the demo vehicle's outline and 5 cm around it is left out.
  void leave_out_vehicle() {
    own_begin_ = -4.05;
    own_end_ = 0.15;
  }
  void add(const TrueFrame& frame, const Pose& pose) {
    for (const auto& in_sensor : frame.points) {
      const Eigen::Vector3d p = pose * in_sensor;
      const double range = std::sqrt(p.x() * p.x() + p.y() * p.y());
      if (p.z() < low_ || p.z() > high_ || range < scan_.range_min || range > scan_.range_max) continue;
      if (own_begin_ < p.x() && p.x() < own_end_ && std::abs(p.y()) < 1.05) continue;
      const double steps = (std::atan2(p.y(), p.x()) - static_cast<double>(scan_.angle_min)) /
                           (2 * pi_d / static_cast<double>(scan_.beams));
      const auto beam = static_cast<std::size_t>(std::lround(steps)) % scan_.beams;
      ranges_[beam] = std::min(ranges_[beam], range);
    }
  }

  void compare(std::size_t& right, std::size_t& all) const {
    for (std::size_t i = 0; i < scan_.beams; ++i) {
      const bool hit = scan_.statuses[i] == BeamStatus::hit;
      ++all;
      if (hit ? std::abs(static_cast<double>(scan_.ranges[i]) - ranges_[i]) <= 0.005 : std::isinf(ranges_[i]))
        ++right;
    }
  }

 private:
  const PlanarScan& scan_;
  double low_, high_;
  double own_begin_ = 0, own_end_ = 0;  // m, base_link
  std::vector<double> ranges_;
};

TEST(DemoDrive, LosesNothingAndPublishesEveryTopic) {
  const DemoDrive demo;
  for (const auto& sensor : demo.report) {
    EXPECT_EQ(sensor.counters.lost_packets, 0U) << sensor.name;
    EXPECT_EQ(sensor.counters.incomplete, 0U) << sensor.name;
    EXPECT_EQ(sensor.counters.rejected_total(), 0U) << sensor.name;
  }
  for (const auto& topic : output_topics(demo.config)) {
    const bool cloud = topic.kind == TopicKind::cloud;
    if (!cloud && topic.kind != TopicKind::scan) continue;  // the demo's sensors have no receiver
    EXPECT_GT(cloud ? demo.sink.clouds.count(topic.name) : demo.sink.scans.count(topic.name), 0U)
        << topic.name;
  }
  const Config& config = demo.config;
  EXPECT_EQ(demo.sink.newest.size(),
            config.sensors.size() + config.merged_scans.size() + config.virtual_scans.size());
  EXPECT_EQ(demo.sink.healths.size(), demo.sink.newest.size());
  for (const auto& [name, changes] : demo.sink.healths) {
    EXPECT_EQ(changes.size(), 1U) << name << " was not well all the time";
    EXPECT_EQ(changes.back().first, Health::ok) << name << ": " << demo.sink.item(name).message;
  }
}

TEST(DemoDrive, StampsIncreaseStrictlyAndAreThoseOfTheFirstBeam) {
  const DemoDrive demo;
  for (const auto& [topic, scans] : demo.sink.scans) {
    for (std::size_t i = 1; i < scans.size(); ++i) ASSERT_GT(scans[i].stamp, scans[i - 1].stamp) << topic;
  }
  for (const char* sensor : {"front_left", "front_right"}) {
    for (const auto& scan : demo.sink.scans.at(std::string(sensor) + "/scan")) {
      EXPECT_LT(std::abs(seconds(scan.stamp - demo.nearest(sensor, scan.stamp).begin)), 1e-3) << sensor;
    }
  }
  for (const auto& cloud : demo.sink.clouds.at("roof/points")) {
    EXPECT_LT(std::abs(seconds(cloud.stamp - demo.nearest("roof", cloud.stamp).begin)), 1e-3);
  }
}

TEST(DemoDrive, MergedScansAreTheTruthProjectedByTheFlattenRule) {
  const DemoDrive demo;
  std::size_t right = 0;
  std::size_t all = 0;
  for (const auto& scan : demo.sink.scans.at("scan_multi")) {
    // The stamp is that of the newest sweep: the right scanner's; the left one's began half a period earlier.
    const TrueFrame& newest = demo.nearest("front_right", scan.stamp);
    const TrueFrame& other = demo.nearest("front_left", newest.begin - std::chrono::milliseconds(15));
    Reference reference(scan, -INFINITY, INFINITY);
    reference.leave_out_vehicle();
    reference.add(newest, *demo.config.find_sensor("front_right")->pose);
    reference.add(other, *demo.config.find_sensor("front_left")->pose);
    reference.compare(right, all);
  }
  ASSERT_GT(all, 50 * 1440U);
  RecordProperty("percent_right",
                 std::to_string(100.0 * static_cast<double>(right) / static_cast<double>(all)));
  EXPECT_GE(static_cast<double>(right), 0.999 * static_cast<double>(all)) << right << " of " << all;
}

TEST(DemoDrive, VirtualScansAreTheTruthProjectedByTheFlattenRule) {
  const DemoDrive demo;
  const auto& group = demo.config.virtual_scans.at(0);
  for (const auto& frame : group.virtual_laser_scan) {
    std::size_t right = 0;
    std::size_t all = 0;
    const Pose pose = group.poses.at(frame).inverse() * *demo.config.find_sensor("roof")->pose;
    for (const auto& scan : demo.sink.scans.at(frame)) {
      Reference reference(scan, *group.output.min_height, *group.output.max_height);
      reference.add(demo.nearest("roof", scan.stamp), pose);
      reference.compare(right, all);
    }
    ASSERT_GT(all, 15 * 720U);
    RecordProperty("percent_right_" + frame,
                   std::to_string(100.0 * static_cast<double>(right) / static_cast<double>(all)));
    EXPECT_GE(static_cast<double>(right), 0.999 * static_cast<double>(all))
        << frame << ": " << right << " of " << all;
  }
}

/// Virtual beams of the drive against the world itself.
struct CutScore {
  std::size_t hits = 0, right = 0, falsely_free = 0, beams = 0;

  /// The vehicle moves while the lidar turns, so a beam may show any moment of the revolution.
  void add(const sim::Scene& scene, const sim::SensorEntry& frame, const PlanarScan& scan) {
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      ++beams;
      if (scan.statuses[beam] == BeamStatus::invalid) continue;
      double best = INFINITY;
      double farthest = 0;
      for (int ms = 0; ms <= 100; ms += 20) {
        for (const double side : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
          const double angle =
              static_cast<double>(scan.angle(beam)) + side * static_cast<double>(scan.angle_increment);
          const sim::Ray ray{{0, 0, 0}, {std::cos(angle), std::sin(angle), 0}};
          const double truth =
              sim::look(scene, frame, ray, scan.stamp + std::chrono::milliseconds(ms)).distance;
          best = std::min(best, std::abs(truth - static_cast<double>(scan.ranges[beam])));
          farthest = std::max(farthest, truth);
        }
      }
      if (scan.statuses[beam] == BeamStatus::none) {
        falsely_free += farthest < static_cast<double>(scan.range_max) ? 1 : 0;
        continue;
      }
      ++hits;
      right += best < 0.1 ? 1 : 0;
    }
  }
};

TEST(DemoDrive, StrictVirtualScansMeetWhatIsThere) {
  const DemoDrive demo([](Config& config) {
    VirtualScanConfig& scan = config.virtual_scans.at(0);
    scan.also = {{"strict", Profile::strict}};
    scan.ground.model = GroundModel::plane;
    scan.no_return_free_range = 100;
  });
  auto scene = sim::load_scene(test::project_file("pcaps/demo.scene.yaml"));
  scene.body.clear();
  for (const auto& [frame, pose] : demo.config.virtual_scans.at(0).poses) {
    CutScore score;
    sim::SensorEntry entry = scene.sensors.at(0);
    entry.mount = pose;
    for (const auto& scan : demo.sink.scans.at(frame + "/strict")) score.add(scene, entry, scan);
    ASSERT_GT(score.beams, 15 * 720U) << frame;
    EXPECT_GT(score.hits, score.beams / 5) << frame;
    EXPECT_EQ(score.falsely_free, 0U) << frame;
    EXPECT_GE(static_cast<double>(score.right), 0.97 * static_cast<double>(score.hits))
        << frame << ": " << score.right << " of " << score.hits << " in " << score.beams;
  }
}

}  // namespace
}  // namespace lidard
