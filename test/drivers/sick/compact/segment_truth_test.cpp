// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <map>

#include "drivers/registry/registry.h"
#include "test/drivers/sick/compact/segment_bench.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"
#include "test/sim/servers/test_scene.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;

struct Sensor {
  std::unique_ptr<Driver> driver;
  Collector out;
  std::vector<sim::Measurement> truth;
  std::vector<Stamp> imu_times;
};

/// Plays a scene's packets to a driver for each of its sensors.
std::map<std::size_t, Sensor> play(const sim::Scene& scene, DriverConfig config = {}) {
  std::map<std::size_t, Sensor> sensors;
  for (std::size_t i = 0; i < scene.sensors.size(); ++i) {
    config.model = find_model(scene.sensors[i].model);
    sensors[i].driver = config.model->make(config);
  }
  sim::simulate(scene, [&](const sim::SimPacket& sent) {
    Sensor& sensor = sensors[sent.sensor];
    Packet packet;
    packet.payload = sent.payload;
    packet.arrival = sent.time;
    packet.from = sent.from;
    packet.to = sent.to;
    EXPECT_EQ(sensor.driver->receive(packet, sensor.out).reject, Reject::none);
    if (sent.to.port == 7503) sensor.imu_times.push_back(sent.time);
    if (sent.measurement != nullptr) sensor.truth.push_back(*sent.measurement);
    return true;
  });
  return sensors;
}

sim::Scene shipped(const std::string& name) {
  return sim::load_scene(project_file("pcaps/" + name + ".scene.yaml"));
}

/// The truth of the scan, of which the first turn is left out.
const sim::Measurement& truth_of(const Sensor& sensor, std::size_t scan) { return sensor.truth.at(scan + 1); }

/// Slots of a single layer stand by beam and echo.
void expect_scan(const PlanarScan& scan, const sim::Measurement& truth, std::size_t echoes,
                 std::size_t first_beam) {
  for (std::size_t b = 0; b < scan.beams; ++b) {
    for (std::size_t e = 0; e < scan.echoes; ++e) {
      const sim::SlotTruth& slot = truth.slots.at((first_beam + b) * echoes + e);
      const float range = scan.ranges[scan.index(b, e)];
      if (std::isnan(slot.wire)) {
        ASSERT_EQ(scan.statuses[scan.index(b, e)], BeamStatus::invalid) << b;
      } else if (std::isinf(slot.wire)) {
        ASSERT_EQ(scan.statuses[scan.index(b, e)], BeamStatus::none) << b;
      } else {
        ASSERT_NEAR(static_cast<double>(range), slot.exact, 0.00051) << b;
      }
      ASSERT_NEAR(static_cast<double>(scan.angle(b)), slot.azimuth, 1e-5);
    }
  }
  const auto stamp_error = scan.stamp - truth.slots.at(first_beam * echoes).time;
  // The latency of the link (20 us) cannot be told from the device's clock, whose stamps are whole us.
  EXPECT_NEAR(seconds(stamp_error), 20e-6, 3e-6);
}

TEST(SegmentTruth, EachSingleLayerCaptureGivesTheSimulatorsTruth) {
  struct Case {
    const char* name;
    std::size_t beams, echoes, first_beam, scans;
  };
  for (const Case& c :
       {Case{"picoscan150", 600, 3, 0, 4}, Case{"picoscan120_v3", 300, 1, 0, 5},
        Case{"picoscan150_filter", 240, 1, 120, 4}, Case{"picoscan150_msgpack", 300, 1, 0, 3}}) {
    DriverConfig config;
    config.publish_multiecho = true;
    const auto sensors = play(shipped(c.name), config);
    const Sensor& sensor = sensors.at(0);
    ASSERT_GE(sensor.out.scans.size(), c.scans) << c.name;
    EXPECT_EQ(sensor.driver->counters().rejected_total(), 0U);
    EXPECT_EQ(sensor.driver->counters().lost_packets, 0U);
    for (std::size_t i = 0; i + 1 < sensor.out.scans.size() && i + 1 < sensor.truth.size(); ++i) {
      const PlanarScan& scan = sensor.out.scans[i];
      ASSERT_EQ(scan.beams, c.beams) << c.name;
      ASSERT_EQ(scan.echoes, c.echoes) << c.name;
      expect_scan(scan, truth_of(sensor, i), c.echoes, c.first_beam);
    }
  }
}

TEST(SegmentTruth, ALastSegmentThatEndsBeyondTheViewShortensNoTime) {
  struct Case {
    const char* options;
    std::size_t beams;  // those of all segments
    double turn_s, step_deg;
  };
  // 10, 5 and 4 segments; the last has 13, 145 and 1 measured beams.
  for (const Case& c :
       {Case{"{}", 600, 0.05, 0.5},
        Case{"{turn_ms: 25, segment_deg: 60, resolution_deg: 0.25}", 1200, 0.025, 0.25},
        Case{"{turn_ms: 20, segment_deg: 60, resolution_deg: 0.5, start_deg: -90, end_deg: 90}", 480, 0.02,
             0.5}}) {
    const auto sensors = play(sim::room("sick_picoscan150", std::string("options: ") + c.options, "", "0.3"));
    const Sensor& sensor = sensors.at(0);
    ASSERT_GE(sensor.out.scans.size(), 4U) << c.options;
    for (const PlanarScan& scan : sensor.out.scans) {
      ASSERT_EQ(scan.beams, c.beams);
      EXPECT_NEAR(static_cast<double>(scan.time_increment), c.turn_s * c.step_deg / 360, 1e-8) << c.options;
      EXPECT_NEAR(static_cast<double>(scan.scan_time), c.turn_s, 2e-5) << c.options;
    }
  }
}

TEST(SegmentTruth, TwoDevicesOnOnePortAreToldApartByTheirSender) {
  const auto sensors = play(shipped("two_picoscans"));
  for (const auto& [index, sensor] : sensors) {
    ASSERT_GE(sensor.out.scans.size(), 4U);
    EXPECT_EQ(sensor.driver->info().serial, index == 0 ? "31" : "32");
    for (std::size_t i = 0; i + 2 < sensor.out.scans.size(); ++i)
      expect_scan(sensor.out.scans[i], truth_of(sensor, i), 1, 0);
    EXPECT_TRUE(sensor.driver->info().warnings.empty());
  }
}

TEST(SegmentTruth, EachLayerOfAMultiScanGivesTheSimulatorsTruth) {
  for (const std::string name : {"compact4", "compact3", "msgpack"}) {
    const std::string options = "options: {format: " + name + "}";
    const auto sensors = play(name == "compact4" ? shipped("multiscan136")
                                                 : sim::room("sick_multiscan136", options, "", "0.17"));
    const Sensor& sensor = sensors.at(0);
    ASSERT_GE(sensor.out.clouds.size(), 1U) << name;
    const Cloud& cloud = sensor.out.clouds[0];
    EXPECT_TRUE(cloud.complete);
    EXPECT_EQ(cloud.rings, 16U);
    const sim::Measurement& truth = truth_of(sensor, 0);
    // Both have their order; a place and a time belong to one return only.
    std::map<std::tuple<int, int, int>, std::vector<const sim::SlotTruth*>> by_place;
    const auto key = [](double x, double y, double z) {
      return std::tuple(static_cast<int>(std::floor(x * 20)), static_cast<int>(std::floor(y * 20)),
                        static_cast<int>(std::floor(z * 20)));
    };
    std::size_t hits = 0;
    for (const sim::SlotTruth& slot : truth.slots) {
      if (std::isinf(slot.wire)) continue;
      ++hits;
      for (const double dx : {-0.01, 0.01}) {
        for (const double dy : {-0.01, 0.01}) {
          for (const double dz : {-0.01, 0.01})
            by_place[key(slot.xyz.x() + dx, slot.xyz.y() + dy, slot.xyz.z() + dz)].push_back(&slot);
        }
      }
    }
    EXPECT_EQ(cloud.size(), hits) << name;
    std::size_t unmatched = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint p = cloud.points()[i];
      const Eigen::Vector3d at(static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z));
      bool matched = false;
      for (const sim::SlotTruth* slot : by_place[key(at.x(), at.y(), at.z())]) {
        const double after = seconds(slot->time - truth.begin);
        // 1 mm of distance, and the azimuth's rounding of 0.011 deg across.
        const double tolerance = 0.0006 + slot->exact * 1.1e-4;
        const float time = p.time;
        matched = matched ||
                  ((slot->xyz - at).norm() < tolerance && std::abs(after - static_cast<double>(time)) < 2e-6);
      }
      unmatched += matched ? 0U : 1U;
    }
    EXPECT_EQ(unmatched, 0U) << name;
    EXPECT_NEAR(seconds(cloud.stamp - truth.begin), 20e-6, 2e-6);
  }
}

TEST(SegmentTruth, InertialSamplesHaveTheTimeTheyWereTaken) {
  const auto sensors = play(shipped("multiscan136"));
  const Sensor& sensor = sensors.at(0);
  ASSERT_GE(sensor.out.imus.size(), 10U);
  for (std::size_t i = 2; i < sensor.out.imus.size(); ++i) {
    EXPECT_NEAR(seconds(sensor.out.imus[i].stamp - sensor.imu_times[i]), 0, 30e-6);
    EXPECT_NEAR(sensor.out.imus[i].linear_acceleration.z(), 9.81, 1e-5);
  }
}

}  // namespace
}  // namespace lidard::sick
