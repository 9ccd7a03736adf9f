// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/health/pipeline_health.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "test/sim/servers/velodyne_stream.h"

namespace lidard {
namespace {

using sim::SimulatedPacket;

/// A sink whose topics have subscribers or not.
class Subscribers final : public FrameSink {
 public:
  bool wants(const OutputTopic&) const override { return there; }
  void publish(const OutputTopic& topic, const Frame& frame, Stamp) override {
    if (const Cloud* const cloud = frame.cloud()) clouds.push_back(*cloud);
    if (const PlanarScan* const scan = frame.scan()) scans[topic.name].push_back(*scan);
  }
  void skip(const OutputTopic& topic, Stamp released) override { skipped[topic.name].push_back(released); }

  bool there = true;
  std::vector<Cloud> clouds;
  std::map<std::string, std::vector<PlanarScan>> scans;
  std::map<std::string, std::vector<Stamp>> skipped;
};

struct OneLidar {
  explicit OneLidar(const std::string& outputs = "", const std::string& keys = "")
      : config(parse_config("sensors: {roof: {model: velodyne_vlp16" + keys + "}}" + outputs, "f")),
        pipeline(config, poses, sink) {}
  void receive(const SimulatedPacket& packet) {
    pipeline.packet({packet.view(), packet.arrival, {}, {{}, packet.port}});
  }
  SensorStatus report() const { return pipeline.status(pipeline.now()).sensors.front(); }

  Config config;
  NoTransforms poses;
  Subscribers sink;
  Pipeline pipeline;
};

std::vector<SimulatedPacket> packets_of(const char* mode) {
  sim::VelodyneSetup setup;
  setup.mode = mode;
  setup.divergence_mrad = 3;
  setup.duration = std::chrono::milliseconds(2500);
  return simulate_velodyne(setup);
}

TEST(UnwantedCloud, IsNotMadeButCountedAndJudgedAsOneThatIs) {
  for (const char* mode : {"strongest", "dual"}) {
    OneLidar heard, unheard;
    unheard.sink.there = false;
    std::size_t n = 0;
    const auto packets = packets_of(mode);
    for (const SimulatedPacket& packet : packets) {
      if (++n % 97 == 0) continue;  // lost
      heard.receive(packet);
      unheard.receive(packet);
    }
    EXPECT_GE(heard.sink.clouds.size(), 20U);
    EXPECT_TRUE(unheard.sink.clouds.empty());
    EXPECT_EQ(unheard.sink.skipped["roof/points"].size(), heard.sink.clouds.size());
    const SensorStatus with = heard.report(), without = unheard.report();
    EXPECT_EQ(without.counters.frames, with.counters.frames);
    EXPECT_EQ(without.counters.lost_packets, with.counters.lost_packets);
    EXPECT_GT(without.counters.lost_packets, 10U);
    EXPECT_EQ(without.recent.frames_looked, with.recent.frames_looked);
    EXPECT_NEAR(without.recent.expected, with.recent.expected, 0.01 * with.recent.expected);
    const auto share = [](const Reception& r) { return double(r.returns) / double(r.beams); };
    EXPECT_NEAR(share(without.recent), share(with.recent), 0.03);
    EXPECT_EQ(topic_totals(unheard.pipeline)[0].messages, topic_totals(heard.pipeline)[0].messages);
    EXPECT_EQ(topic_totals(unheard.pipeline)[0].rate(), topic_totals(heard.pipeline)[0].rate());
  }
}

TEST(UnwantedCloud, TheFirstSubscriberGetsTheNextRevolutionWhole) {
  OneLidar heard, late;
  late.sink.there = false;
  Stamp came{};
  for (const SimulatedPacket& packet : packets_of("strongest")) {
    late.sink.there = heard.sink.clouds.size() >= 5;
    if (late.sink.there && came == Stamp()) came = packet.arrival;
    heard.receive(packet);
    late.receive(packet);
  }
  const auto& all = heard.sink.clouds;
  ASSERT_GE(all.size(), 20U);
  // The revolution in which the subscriber came has no points yet.
  ASSERT_EQ(late.sink.clouds.size(), all.size() - 6);
  EXPECT_GE(late.sink.clouds[0].stamp, came);
  EXPECT_LT(seconds(late.sink.clouds[0].stamp - came), 0.11);
  for (std::size_t i = 0; i < late.sink.clouds.size(); ++i) {
    EXPECT_EQ(late.sink.clouds[i].stamp, all[i + 6].stamp);
    EXPECT_EQ(late.sink.clouds[i].points_bytes, all[i + 6].points_bytes);
  }
}

TEST(UnwantedCloud, IsMadeForWhatIsMadeOfIt) {
  const std::string outputs =
      "\nvirtual_scans: {cut: {cloud_topic: roof, virtual_laser_scan: [chest], poses: {chest: {xyz: [0, 0, "
      "0]}}}}";
  const std::string keys = ", pose: {xyz: [0, 0, 1]}";
  OneLidar heard(outputs, keys), unheard(outputs, keys);
  unheard.sink.there = false;
  for (const SimulatedPacket& packet : packets_of("strongest")) {
    heard.receive(packet);
    unheard.receive(packet);
  }
  EXPECT_TRUE(unheard.sink.clouds.empty());
  EXPECT_EQ(unheard.sink.skipped["roof/points"].size(), heard.sink.clouds.size());
  ASSERT_EQ(heard.sink.scans.size(), 1U);
  const auto& expected = heard.sink.scans.begin()->second;
  ASSERT_EQ(unheard.sink.scans.size(), 1U);
  const auto& got = unheard.sink.scans.begin()->second;
  ASSERT_GE(expected.size(), 20U);
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) EXPECT_EQ(got[i].statuses, expected[i].statuses);
}

}  // namespace
}  // namespace lidard
