// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/identifier.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {

/// What a driver makes of a TCP device's capture of the virtual vehicle, and the truth of every telegram.
class WatchedCapture : public DriverBench {
 public:
  WatchedCapture(const std::string& name, const std::string& model_name, DriverConfig config = {})
      : DriverBench(model_name, std::move(config)) {
    const std::string path = project_file("pcaps/" + name);
    sim::simulate(sim::load_scene(path + ".scene.yaml"), [&](const sim::SimPacket& packet) {
      if (packet.measurement != nullptr) truth.push_back(*packet.measurement);
      return true;
    });
    PcapSource source(path + ".pcap");
    for (Packet packet; source.next(packet);) {
      if (packet.from.port != model->port) continue;
      identifier.add(packet);
      driver->receive(packet, *this);
    }
    driver->finish(*this);
    EXPECT_EQ(source.error(), "");
    EXPECT_EQ(counters().rejected_total(), 0U);
    EXPECT_EQ(counters().lost_packets, 0U);
    EXPECT_EQ(counters().clock_steps, 0U) << "a counter may overflow on the way";
  }

  std::vector<sim::Measurement> truth;
  Identifier identifier;
};

/// `tolerance`: noise of the scene and rounding on the wire, m.
inline void expect_truth(const PlanarScan& scan, const sim::Measurement& truth, double tolerance) {
  ASSERT_EQ(scan.beams, truth.slots.size());
  std::size_t hits = 0;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const sim::SlotTruth& slot = truth.slots[i];
    ASSERT_NEAR(scan.angle(i), slot.azimuth, 2e-5) << i;
    if (!std::isfinite(slot.exact)) {
      ASSERT_EQ(scan.statuses[i], BeamStatus::none) << i;
      continue;
    }
    ++hits;
    ASSERT_EQ(scan.statuses[i], BeamStatus::hit) << i;
    ASSERT_NEAR(scan.ranges[i], slot.exact, tolerance) << i;
  }
  EXPECT_GT(hits, scan.beams / 2);
  EXPECT_LT(hits, scan.beams) << "a sector of the room is open";
}

}  // namespace lidard::test
