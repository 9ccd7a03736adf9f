// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/safety_device.h"

#include <gtest/gtest.h>

#include <set>

#include "test/sim/servers/simulate.h"
#include "test/sim/servers/test_scene.h"

namespace lidard::sim {
namespace {

const Endpoint loopback{IpAddress::v4(127, 0, 0, 1), 0};

Scene scanner() { return room("sick_microscan3", "options: {serial: 4711}"); }

/// Ports that the scene's datagrams go to, and the scans (by the number of their data set) that go there.
struct Flow {
  std::set<std::uint16_t> ports;
  std::set<std::uint32_t> scans, all;
};

Flow flow_with(const SafetySettings& settings) {
  LiveSafetyScanner live(loopback, settings);
  Flow flow;
  simulate(scanner(), [&](const SimPacket& packet) {
    const std::uint32_t number = packet.payload.le32(12);  // SICK 8022708 p. 14
    flow.all.insert(number);
    if (const auto to = live.destination(packet.payload)) {
      flow.ports.insert(to->port);
      flow.scans.insert(number);
    }
    return true;
  });
  return flow;
}

TEST(LiveSafetyScanner, SendsToWhereTheSceneSaysUntilItIsToldOtherwise) {
  const Scene scene = scanner();
  ASSERT_TRUE(scene.sensors.at(0).settings);
  SafetySettings settings = *scene.sensors[0].settings;
  EXPECT_EQ(settings.serial, "4711");
  const Flow as_configured = flow_with(settings);
  EXPECT_EQ(as_configured.ports, std::set<std::uint16_t>{scene.sensors[0].to.port});
  EXPECT_EQ(as_configured.scans, as_configured.all);
  settings.current.port = 7070;
  settings.current.every = 2;
  const Flow changed = flow_with(settings);
  EXPECT_EQ(changed.ports, std::set<std::uint16_t>{7070});
  EXPECT_EQ(changed.scans.size(), (changed.all.size() + 1) / 2);
  settings.current.enabled = false;
  EXPECT_TRUE(flow_with(settings).scans.empty());
}

}  // namespace
}  // namespace lidard::sim
