// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/sim/servers/truth.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::sick {
namespace {

struct Sensor {
  std::unique_ptr<Driver> driver;
  test::Collector out;
};

const sim::SensorTruth& truth_of(const std::vector<sim::SensorTruth>& all, const std::string& name) {
  for (const auto& each : all) {
    if (each.name == name) return each;
  }
  throw std::runtime_error("the truth has no sensor " + name);
}

TEST(SafetyDriver, TwoScannersOnOnePortOfTheDemoCaptureGiveTheTruth) {
  std::map<std::string, Sensor> sensors;
  for (const char* address : {"192.168.0.21", "192.168.0.22"}) {
    DriverConfig config;
    config.model = find_model("sick_microscan3");
    sensors[address].driver = config.model->make(config);
  }
  PcapSource capture(test::project_file("pcaps/demo.pcap"));
  for (Packet packet; capture.next(packet);) {
    const auto found = sensors.find(packet.from.address.to_string());
    if (found != sensors.end()) found->second.driver->receive(packet, found->second.out);
  }
  const auto truth = sim::read_truth(test::project_file("pcaps/demo.truth"));
  for (const auto& [address, name] :
       {std::pair("192.168.0.21", "front_left"), {"192.168.0.22", "front_right"}}) {
    const Sensor& sensor = sensors[address];
    const auto& records = truth_of(truth, name).records;
    ASSERT_EQ(sensor.out.scans.size(), records.size());
    EXPECT_EQ(sensor.driver->counters().rejected_total(), 0U);
    EXPECT_EQ(sensor.driver->counters().lost_packets + sensor.driver->counters().incomplete, 0U);
    for (std::size_t i = 0; i < records.size(); ++i) {
      const PlanarScan& scan = sensor.out.scans[i];
      ASSERT_EQ(violation(scan), nullptr);
      ASSERT_EQ(scan.beams, records[i].ranges.size());
      EXPECT_NEAR(seconds(scan.stamp - records[i].begin), 0, 0.5e-3) << name << " scan " << i;
      for (std::size_t b = 0; b < scan.beams; ++b) {
        const float exact = records[i].ranges[b];
        if (std::isinf(exact)) {
          ASSERT_EQ(scan.ranges[b], exact) << i << " " << b;
        } else {
          ASSERT_NEAR(scan.ranges[b], exact, 0.00051) << i << " " << b;
        }
      }
    }
  }
}

}  // namespace
}  // namespace lidard::sick
