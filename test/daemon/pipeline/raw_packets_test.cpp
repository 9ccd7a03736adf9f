// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/raw_packets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/pipeline/frame_tree.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/velodyne/velodyne_scan.h"
#include "drivers/velodyne/packet.h"
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
  std::size_t raw_count() const {
    std::size_t sum = 0;
    for (const RawPackets& one : raw()) sum += one.arrivals.size();
    return sum;
  }

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

TEST(RawPackets, HoldEveryDataPacketOnceInOrderAndNoOthers) {
  Roof roof("raw_topic: raw");
  std::vector<std::uint8_t> sent;
  std::vector<Stamp> arrivals;
  for (const auto& packet : half_a_second(20)) {
    roof.take(packet);
    if (packet.payload.size() != velodyne::packet_size) continue;
    sent.insert(sent.end(), packet.payload.begin(), packet.payload.end());
    arrivals.push_back(packet.arrival);
  }
  roof.pipeline.finish(arrivals.back());
  std::vector<std::uint8_t> bytes;
  std::vector<Stamp> stamps;
  for (const RawPackets& one : roof.raw()) {
    EXPECT_EQ(one.frame_id, "roof");
    EXPECT_EQ(one.arrivals.front(), Span(0)) << "frame_stamp: first";
    bytes.insert(bytes.end(), one.bytes.begin(), one.bytes.end());
    for (const Span arrival : one.arrivals) stamps.push_back(one.stamp + arrival);
  }
  EXPECT_EQ(bytes, sent);
  EXPECT_EQ(stamps, arrivals);
  EXPECT_EQ(roof.raw().size(), roof.sink.clouds["roof/points"].size() + 1)
      << "a message each cloud, and the rest";
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

TEST(RawPackets, AreBoundedWhereNoRevolutionEnds) {
  Roof roof("raw_topic: raw");
  auto packet = half_a_second().front();
  packet.payload[0] = 0;  // no packet of a Velodyne
  for (std::size_t i = 0; i < RawPacketCollector::most_packets + 10; ++i) {
    packet.arrival = packet.arrival + std::chrono::milliseconds(1);
    roof.take(packet);
  }
  EXPECT_EQ(roof.sink.count("roof/points"), 0U);
  ASSERT_EQ(roof.raw().size(), 1U);
  EXPECT_EQ(roof.raw()[0].arrivals.size(), RawPacketCollector::most_packets);
  roof.pipeline.finish(packet.arrival);
  EXPECT_EQ(roof.raw_count(), RawPacketCollector::most_packets + 10) << "not one is lost";
}

TEST(RawPackets, OfBeforeAndAfterAGapAreNotInOneMessage) {
  Roof roof("raw_topic: raw");
  const auto packets = half_a_second();
  const Span gap = std::chrono::hours(1);
  for (std::size_t i = 0; i < packets.size(); ++i) {
    sim::SimulatedPacket packet = packets[i];
    if (i >= packets.size() / 2) packet.arrival = packet.arrival + gap;
    roof.take(packet);
  }
  roof.pipeline.finish(packets.back().arrival + gap);
  EXPECT_EQ(roof.raw_count(), packets.size());
  for (const RawPackets& one : roof.raw())
    EXPECT_LT(one.arrivals.back() - one.arrivals.front(), std::chrono::seconds(1));
}

TEST(RawPackets, UseNoNewMemoryAfterTheFirstRevolutions) {
  const Config config = parse_config("sensors: {roof: {model: velodyne_vlp16, raw_topic: raw}}", "f");
  const auto all = half_a_second();
  struct Writing final : FrameSink {
    void publish(const OutputTopic&, const Frame& frame, Stamp) override {
      test::to_message(std::get<RawPackets>(*std::get<const DeviceMessage*>(frame)), message);
    }
    VelodyneScanMessage message;
  } sink;
  Router router(sink);
  router.configure(config);
  RawPacketCollector collector(config.sensors[0], router.topic("raw"));
  std::uint64_t before = 0;
  constexpr int warm = 10, revolutions = 40;
  for (int i = 0; i < revolutions; ++i) {
    if (i == warm) before = test::allocations();
    for (std::size_t k = 0; k < 76; ++k) collector.add({all[k].view(), all[k].arrival, {}, {}}, {});
    collector.publish({});
  }
  EXPECT_EQ(test::allocations() - before, 0U);
}

TEST(RawPackets, AreForgottenWhenTheInputStartsAgain) {
  const auto all = half_a_second();
  Roof roof("raw_topic: raw");
  for (std::size_t i = 0; i < 10; ++i) roof.take(all[i]);
  roof.pipeline.restart();
  roof.take(all[0]);
  roof.pipeline.finish(all[0].arrival);
  EXPECT_EQ(roof.raw_count(), 1U);
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
