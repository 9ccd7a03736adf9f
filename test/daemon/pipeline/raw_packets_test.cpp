// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/raw_packets.h"

#include <gtest/gtest.h>

#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/velodyne/velodyne_scan.h"
#include "test/sim/servers/velodyne_stream.h"
#include "test/support/allocations.h"
#include "test/support/recording_sink.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

/// A pipeline with one VLP-16.
struct Roof {
  explicit Roof(const std::string& keys)
      : config(parse_config("sensors: {roof: {model: velodyne_vlp16, " + keys + "}}", "f")),
        pipeline(config, poses, sink) {}
  void take(const sim::SimulatedPacket& packet) {
    pipeline.packet({packet.view(), packet.arrival, {}, {{}, packet.port}});
  }
  std::vector<RawPackets> raw() const { return sink.of<RawPackets>("raw"); }

  Config config;
  NoTransforms poses;
  test::RecordingSink sink;
  Pipeline pipeline;
};

std::vector<sim::SimulatedPacket> half_a_second(double telemetry_hz = 0) {
  sim::VelodyneSetup setup;
  setup.duration = std::chrono::milliseconds(450);
  setup.telemetry_hz = telemetry_hz;
  return simulate_velodyne(setup);
}

TEST(RawPackets, AreAMessageEachCloudAndTheRest) {
  Roof roof("raw_topic: raw");
  const auto all = half_a_second(20);
  for (const auto& packet : all) roof.take(packet);
  roof.pipeline.finish(all.back().arrival);
  EXPECT_EQ(roof.raw().size(), roof.sink.clouds["roof/points"].size() + 1);
}

TEST(RawPackets, ReadBackByAnotherPipelineGiveTheSameClouds) {
  const auto all = half_a_second();
  Roof direct("raw_topic: raw");
  for (const auto& packet : all) direct.take(packet);
  direct.pipeline.finish(all.back().arrival);
  Roof from_topic("packet_topic: raw");
  for (const RawPackets& one : direct.raw()) {
    VelodyneScanMessage message;
    test::to_message(one, message);
    const char* const wrong =
        read_velodyne_scan({message.bytes.data(), message.bytes.size()}, [&](ByteView payload, HostStamp at) {
          from_topic.pipeline.packet_message("roof", {payload, {at.ns}, {}, {}}, {at.ns});
        });
    EXPECT_EQ(wrong, nullptr);
  }
  from_topic.pipeline.finish(all.back().arrival);
  const auto& expected = direct.sink.clouds["roof/points"];
  const auto& clouds = from_topic.sink.clouds["roof/points"];
  ASSERT_GE(expected.size(), 3U);
  ASSERT_EQ(clouds.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(clouds[i].stamp, expected[i].stamp);
    EXPECT_EQ(clouds[i].points_bytes, expected[i].points_bytes);
  }
}

TEST(RawPackets, AreStampedAsVelodyneDriverStampsThem) {
  const auto all = half_a_second();
  Roof roof("raw_topic: raw, frame_stamp: last, time_offset: 0.25");
  for (const auto& packet : all) roof.take(packet);
  roof.pipeline.finish(all.back().arrival);
  const RawPackets last = roof.raw().back();
  EXPECT_EQ(last.arrivals.back(), Span(0));
  EXPECT_EQ(last.stamp, all.back().arrival + std::chrono::milliseconds(250));
  EXPECT_EQ(last.stamp + last.arrivals.front(),
            all[all.size() - last.arrivals.size()].arrival + std::chrono::milliseconds(250));
}

TEST(RawPackets, UseNoNewMemoryAfterTheFirstRevolutions) {
  const auto all = half_a_second();
  struct Writing final : FrameReceiver {
    void scan(PlanarScan&) override {}
    void cloud(Cloud&) override {}
    void message(const DeviceMessage& packets) override {
      test::to_message(std::get<RawPackets>(packets), written);
    }
    VelodyneScanMessage written;
  } writing;
  velodyne::RawPacketCollector collector(
      parse_config("sensors: {roof: {model: velodyne_vlp16, raw_topic: raw}}", "f").sensors[0].driver);
  std::uint64_t before = 0;
  constexpr int warm = 10, revolutions = 40;
  for (int i = 0; i < revolutions; ++i) {
    if (i == warm) before = test::allocations();
    for (std::size_t k = 0; k < 76; ++k) collector.add({all[k].view(), all[k].arrival, {}, {}}, writing);
    collector.publish(writing);
  }
  EXPECT_EQ(test::allocations() - before, 0U);
  EXPECT_FALSE(writing.written.bytes.empty());
}

TEST(RawPackets, AreNotPublishedUnlessAskedFor) {
  Roof roof("cut_angle: 0");
  for (const auto& packet : half_a_second()) roof.take(packet);
  EXPECT_TRUE(roof.sink.messages.empty());
  for (const OutputTopic& topic : output_topics(roof.config))
    EXPECT_NE(topic.message == message_kind<RawPackets>() && topic.kind == TopicKind::message, true)
        << topic.name;
}

}  // namespace
}  // namespace lidard
