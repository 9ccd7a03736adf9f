// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// No driver stamps anything beyond the arrival of the packet that brought it, whatever the arrivals do.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include "drivers/capture/pcap_source.h"
#include "drivers/registry/registry.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

/// By how much a frame is stamped beyond the arrival of the packet at hand.
struct Watch final : FrameReceiver {
  void scan(PlanarScan& scan) override { judge(scan.stamp); }
  void cloud(Cloud& cloud) override { judge(cloud.stamp); }
  void judge(Stamp stamp) {
    ++frames;
    beyond = std::max(beyond, seconds(stamp - arrival));
  }
  Stamp arrival;
  int frames = 0;
  double beyond = -1;
};

TEST(EveryDriver, StampsNoFrameBeyondTheArrivalOfItsLastPacket) {
  const std::pair<const char*, const char*> captures[] = {{"sick_lms111", "sick_lms1xx"},
                                                          {"sick_tim571_text", "sick_tim5xx"},
                                                          {"sick_mrs1104", "sick_mrs1000"},
                                                          {"hokuyo_ust_10lx", "hokuyo_ust_10lx"},
                                                          {"hokuyo_utm_30lx_ew", "hokuyo_utm_30lx_ew"},
                                                          {"hokuyo_uam_05lp", "hokuyo_uam_05lp"},
                                                          {"picoscan150", "sick_picoscan150"},
                                                          {"multiscan136", "sick_multiscan136"},
                                                          {"vlp16_dual", "velodyne_vlp16"}};
  using Bend = std::function<Stamp(Stamp arrival, std::size_t packet)>;
  const Bend bends[] = {
      [](Stamp at, std::size_t) { return at; },
      // The host's clock is set to and fro; the network delays by up to 40 ms.
      [](Stamp at, std::size_t i) { return at + std::chrono::hours(i / 40 % 2); },
      [](Stamp at, std::size_t i) { return at + std::chrono::milliseconds(i * 7919 % 41); }};
  for (const auto& [capture, name] : captures) {
    for (const Bend& bend : bends) {
      DriverConfig config;
      config.model = find_model(name);
      ASSERT_NE(config.model, nullptr) << name;
      const auto driver = config.model->make(config);
      PcapSource source(project_file(std::string("pcaps/") + capture + ".pcap"));
      Watch watch;
      std::size_t count = 0;
      for (Packet packet; source.next(packet);) {
        if (!is_for(*config.model, packet)) continue;
        const Stamp arrival = bend(packet.arrival, count++);
        const bool overtakes = arrival < watch.arrival && watch.arrival - arrival < restart_limit;
        packet.arrival = watch.arrival = overtakes ? watch.arrival : arrival;
        driver->receive(packet, watch);
      }
      EXPECT_LE(watch.beyond, 0) << capture << " with bend " << &bend - bends;
      EXPECT_GT(watch.frames, 0) << capture;
    }
  }
}

}  // namespace
}  // namespace lidard::test
