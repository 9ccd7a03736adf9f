// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What /diagnostics says where another model's packets come than the configured one's, and of unknown
// senders.
#include "drivers/registry/other_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/registry/registry.h"
#include "test/support/allocations.h"
#include "test/support/pipeline_bench.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const IpAddress sender = IpAddress::v4(192, 168, 1, 201);

/// Two seconds of one Velodyne where `configured` is expected; the last state of the sensor.
DiagnosticItem taken_as(const std::string& configured, const std::string& sent) {
  test::PipelineBench bench("sensors: {roof: {model: " + configured + ", ip_port: 2368}}");
  Stamp now{};
  for (const auto& packet : test::spin({sent, sim::ReturnMode::strongest, ""}, 20)) {
    now = packet.arrival;
    bench.pipeline.packet({{packet.bytes.data(), packet.bytes.size()}, now, {sender, 2368}, {{}, 2368}});
    bench.pipeline.tick(now);
  }
  return bench.item("sensor roof", now);
}

TEST(OtherModel, IsNamedWithTheWayToConfigureIt) {
  EXPECT_EQ(taken_as("velodyne_vlp16", "velodyne_vlp16").health, Health::ok);
  for (const auto& [configured, sent, sentence] :
       {std::tuple("velodyne_vlp16", "velodyne_vlp32c",
                   "this is a VLP-32C, not a VLP-16; set model: velodyne_vlp32c"),
        std::tuple("velodyne_vlp32c", "velodyne_vls128",
                   "this is a VLS-128 or Alpha Prime, not a VLP-32C; set model: velodyne_vls128"),
        std::tuple("velodyne_hdl32e", "velodyne_vlp32c",
                   "this is a VLP-32C, not a HDL-32E; set model: velodyne_vlp32c"),
        std::tuple("velodyne_hdl64e_s3", "velodyne_hdl64e_s1",
                   "this is a HDL-64E S1, not a HDL-64E S3; set model: velodyne_hdl64e_s1"),
        std::tuple("sick_microscan3", "velodyne_vlp32c",
                   "this is a VLP-32C, not a microScan3; set model: velodyne_vlp32c"),
        std::tuple("sick_picoscan150", "velodyne_vlp32c",
                   "this is a VLP-32C, not a picoScan150; set model: velodyne_vlp32c")}) {
    const DiagnosticItem item = taken_as(configured, sent);
    EXPECT_EQ(item.health, Health::error) << configured << ' ' << sent;
    EXPECT_EQ(item.message, sentence)
        << test::value_of(item, "Rejected") << " of " << test::value_of(item, "Packets");
  }
}

TEST(OtherModel, ThatSendsBesideTheConfiguredOneIsASecondDevice) {
  test::PipelineBench bench("sensors: {roof: {model: velodyne_vlp16, ip_address: 192.168.1.201}}");
  const auto own = test::spin({"velodyne_vlp16", sim::ReturnMode::strongest, ""}, 20);
  const auto second = test::spin({"velodyne_vlp32c", sim::ReturnMode::strongest, ""}, 20);
  Stamp now{};
  for (std::size_t i = 0; i < own.size(); ++i) {
    now = own[i].arrival;
    bench.pipeline.packet({{own[i].bytes.data(), own[i].bytes.size()}, now, {sender, 2368}, {{}, 2368}});
    if (i < second.size())
      bench.pipeline.packet(
          {{second[i].bytes.data(), second[i].bytes.size()}, now, {sender, 2368}, {{}, 2368}});
    bench.pipeline.tick(now);
  }
  const DiagnosticItem item = bench.item("sensor roof", now);
  EXPECT_EQ(item.health, Health::error);
  EXPECT_EQ(item.message,
            "two devices have the address 192.168.1.201 (VLP-16 and VLP-32C); give one of them "
            "another IP address");
}

TEST(OtherModel, OfTheSameRowOrOfNoKnownProtocolIsNotNamed) {
  EXPECT_EQ(taken_as("velodyne_puck_lite", "velodyne_vlp16").health, Health::ok);
  OtherModel other(find_model("velodyne_vlp16"));
  const std::string junk(1206, 'x');
  Packet packet;
  packet.payload = ByteView(junk);
  for (int i = 0; i < 1000; ++i) other.refused(packet, Reject::magic);
  EXPECT_TRUE(other.models().empty());
}

TEST(OtherModel, IsLookedForInFewPackets) {
  OtherModel other(find_model("velodyne_vlp16"));
  const auto packets = test::spin({"velodyne_vlp32c", sim::ReturnMode::strongest, ""}, 5);
  const auto refuse = [&](std::size_t i) {
    Packet packet;
    packet.payload = {packets[i].bytes.data(), packets[i].bytes.size()};
    packet.arrival = packets[i].arrival;
    other.refused(packet, Reject::model);
  };
  for (std::size_t i = 0; i < 20; ++i) refuse(i);
  ASSERT_FALSE(other.models().empty());
  EXPECT_EQ(other.models().front()->name, "velodyne_vlp32c");
  const std::uint64_t before = test::allocations();
  for (std::size_t i = 20; i < packets.size(); ++i) refuse(i);
  EXPECT_EQ(test::allocations(), before);
}

TEST(UnknownSenders, AreForgottenAMinuteAfterTheirLastPacket) {
  test::PipelineBench bench("sensors: {roof: {model: velodyne_vlp16, ip_address: 192.168.1.9}}");
  const std::string bytes = "hello";
  const auto reported = [&](double time) {
    const Stamp now = test::bench_begin + ms(time);
    bench.pipeline.tick(now);
    for (const DiagnosticItem& item : items_of(bench.pipeline, now)) {
      if (item.name == "unknown senders") return item.message;
    }
    return std::string();
  };
  const auto send = [&](double time) {
    bench.pipeline.packet({ByteView(bytes), test::bench_begin + ms(time), {sender, 2368}, {{}, 2368}});
  };
  send(0);
  send(1000);
  EXPECT_THAT(reported(1100), HasSubstr("192.168.1.201 -> port 2368 (2 packets)"));
  EXPECT_THAT(reported(60'900), HasSubstr("192.168.1.201"));
  EXPECT_EQ(reported(61'100), "");
  EXPECT_EQ(bench.pipeline.unclaimed_senders().size(), 1U) << "the table after a replay knows all";
  send(70'000);
  EXPECT_THAT(reported(70'100), HasSubstr("(3 packets)"));
}

}  // namespace
}  // namespace lidard
