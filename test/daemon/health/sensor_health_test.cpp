// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What /diagnostics and the table of a replay say of sensors that give less than they should.
#include "daemon/health/sensor_health.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "daemon/health/report.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "test/drivers/sick/safety/ms3_encoder.h"
#include "test/support/pipeline_bench.h"
#include "test/support/recording_sink.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const IpAddress first = IpAddress::v4(192, 168, 1, 201);
const IpAddress second = IpAddress::v4(192, 168, 1, 202);

/// 12 s of a VLP-16 at ten turns per second.
const std::vector<test::WirePacket>& twelve_seconds() {
  static const auto packets = test::spin({"velodyne_vlp16", sim::ReturnMode::strongest, ""}, 120);
  return packets;
}

struct Room {
  explicit Room(const std::string& keys = "")
      : config(parse_config("sensors: {roof: {model: velodyne_vlp16" + keys + "}}", "c")) {}

  void give(const std::vector<std::uint8_t>& bytes, Stamp arrival, const IpAddress& from = first) {
    now = std::max(now, arrival);
    pipeline.packet({{bytes.data(), bytes.size()}, arrival, {from, 2368}, {{}, 2368}});
    pipeline.tick(arrival);
    note();
  }
  void note() {
    const Health health = item().health;
    worst = std::max(worst, health);
  }
  DiagnosticItem item() const { return items_of(pipeline, now).at(0); }
  std::string value(const std::string& key) const {
    for (const auto& [name, text] : item().values) {
      if (name == key) return text;
    }
    return "no such key";
  }
  std::string table() const {
    std::ostringstream out;
    print_table(pipeline.status(pipeline.now()).sensors, out);
    print_verdicts(pipeline.status(pipeline.now()).sensors, out);
    return out.str();
  }

  Config config;
  NoTransforms poses;
  test::RecordingSink sink{false};
  Pipeline pipeline{config, poses, sink};
  Stamp now{};
  Health worst = Health::ok;
};

TEST(SensorHealth, OfAWholeStreamIsWellAllTheTime) {
  Room room(", ip_address: 192.168.1.201");
  for (const auto& packet : twelve_seconds()) room.give(packet.bytes, packet.arrival);
  EXPECT_EQ(room.worst, Health::ok);
  EXPECT_EQ(room.item().message, "receiving");
  EXPECT_EQ(room.value("Frames/s"), "10.0");
  EXPECT_EQ(room.value("Expected frames/s"), "10.0");
  EXPECT_EQ(room.value("Lost in the last 10 s"), "0");
  EXPECT_THAT(room.table(), AllOf(Not(HasSubstr("WARN")), Not(HasSubstr("ERROR"))));
}

// SICK 8022708 p. 18-19: 4 contamination warning, 8 contamination error.
TEST(SensorHealth, ASafetyScannerThatReportsTroubleIsNotOkThoughItsScansCome) {
  const Config config = parse_config(
      "sensors: {front: {model: sick_microscan3, ip_address: 192.168.1.201, ip_port: 6060}}", "c");
  NoTransforms poses;
  test::RecordingSink sink{false};
  Pipeline pipeline{config, poses, sink};
  test::Ms3Sample sample;
  Stamp now = test::ms3_epoch;
  std::uint32_t identification = 0;
  const auto level_with = [&](std::uint8_t flags) {
    sample.state_flags = flags;
    for (int scan = 0; scan < 100; ++scan) {
      ++sample.sequence, ++sample.scan;
      now = now + std::chrono::milliseconds(sample.scan_time_ms);
      for (const auto& bytes : test::ms3_datagrams(sample.instance(), ++identification))
        pipeline.packet({{bytes.data(), bytes.size()}, now, {first, 6060}, {{}, 6060}});
      pipeline.tick(now);
    }
    return items_of(pipeline, now).at(0);
  };
  for (int incident = 0; incident < 2; ++incident) {
    EXPECT_EQ(level_with(1).health, Health::ok);
    EXPECT_EQ(level_with(1 | 4).health, Health::warn);
    const DiagnosticItem blind = level_with(1 | 8);
    EXPECT_EQ(blind.health, Health::error);
    EXPECT_THAT(blind.message, HasSubstr("clean its optics cover"));
  }
  EXPECT_EQ(level_with(1).health, Health::ok);
}

TEST(SensorHealth, TellsThatATenthOfThePacketsIsLost) {
  Room room;
  std::mt19937 random(7);
  for (const auto& packet : twelve_seconds()) {
    if (random() % 10 != 0) room.give(packet.bytes, packet.arrival);
  }
  EXPECT_EQ(room.item().health, Health::error);
  EXPECT_THAT(room.item().message,
              testing::MatchesRegex(".* of 10.0 frames/s, .* % of packets lost in the last 10 s; "
                                    "check the cable, the switch and the load of this computer"));
  EXPECT_THAT(room.table(), HasSubstr("ERROR roof: "));
}

TEST(SensorHealth, NamesTwoSensorsInOneEntry) {
  Room room;
  for (const auto& packet : twelve_seconds()) {
    room.give(packet.bytes, packet.arrival, first);
    // The other one looks elsewhere at that time.
    auto other = packet.bytes;
    for (std::size_t block = 0; block < 12; ++block) {
      const std::size_t at = block * 100 + 2;
      const unsigned azimuth = (other[at] + 256U * other[at + 1] + 17000U) % 36000U;
      other[at] = static_cast<std::uint8_t>(azimuth & 0xFFU);
      other[at + 1] = static_cast<std::uint8_t>(azimuth >> 8U);
    }
    room.give(other, packet.arrival + std::chrono::microseconds(600), second);
  }
  EXPECT_EQ(room.item().health, Health::error);
  EXPECT_THAT(room.item().message, HasSubstr("192.168.1.201 and 192.168.1.202 both send to port 2368"));
  EXPECT_THAT(room.item().message, HasSubstr("set ip_address: 192.168.1.201"));
  EXPECT_THAT(room.table(), HasSubstr("ERROR roof: 192.168.1.201 and 192.168.1.202 both send to port 2368"));
}

TEST(SensorHealth, TellsThatOnlyForeignPacketsCome) {
  Room room;
  const auto& packets = twelve_seconds();
  for (std::size_t i = 0; i < 2000; ++i) room.give(packets[i].bytes, packets[i].arrival);
  EXPECT_EQ(room.worst, Health::ok);
  const std::vector<std::uint8_t> foreign(1212, 0x55);
  for (int i = 0; i < 14000; ++i) room.give(foreign, room.now + std::chrono::milliseconds(1));
  EXPECT_EQ(room.item().health, Health::error);
  EXPECT_THAT(room.item().message, AllOf(HasSubstr("0 of 10.0 frames/s, no frame for 1"),
                                         HasSubstr("100 % of packets rejected"), HasSubstr("size")));
}

TEST(Counters, OfTroubleStandOnALineOfTheirOwn) {
  Counters counters;
  std::ostringstream none, two;
  print_counters(counters, none);
  EXPECT_EQ(none.str(), "  packets 0, rejected 0, lost 0\n");
  counters.reordered = 2, counters.clock_steps = 1;
  print_counters(counters, two);
  EXPECT_EQ(two.str(), none.str() + "  reordered packets 2, clock steps 1\n");
}

TEST(SensorHealth, TellsACoveredSensor) {
  Room room;
  for (const auto& packet : twelve_seconds()) {
    auto covered = packet.bytes;
    for (std::size_t block = 0; block < 12; ++block)
      for (std::size_t k = 0; k < 32; ++k)
        covered[block * 100 + 4 + k * 3] = covered[block * 100 + 5 + k * 3] = 0;
    room.give(covered, packet.arrival);
  }
  EXPECT_EQ(room.item().health, Health::warn);
  EXPECT_EQ(room.item().message,
            "0.0 % of the beams with a return in the last 10 s; is its window covered? An empty field looks "
            "the same");
}

/// No connection; its presence says that the packets are live.
class NoConnections final : public DeviceConnections {
 public:
  void connect(std::size_t, const IpAddress&) override {}
  void send(std::size_t, ByteView) override {}
  Stamp now() const override { return {}; }
  void disconnect(std::size_t, bool) override {}
  ConnectionStatus status(std::size_t) const override { return {}; }
};

TEST(SensorHealth, PacketsOfOneArrivalAreThoseOfACaptureOrWaitedForTheDaemon) {
  for (const bool is_live : {false, true}) {
    test::PipelineBench bench("sensors: {roof: {model: velodyne_vlp16, ip_port: 2368}}");
    NoConnections connections;
    if (is_live) bench.pipeline.set_connections(&connections);
    Stamp now{};
    const Span standing = std::chrono::seconds(4);
    const Stamp begin = twelve_seconds().front().arrival;
    for (const test::WirePacket& packet : twelve_seconds()) {
      // From 2 s on those of 4 s have one arrival.
      const bool waits = packet.arrival > begin + standing / 2 && packet.arrival < begin + 3 * standing / 2;
      now = waits ? begin + standing / 2 : packet.arrival;
      bench.pipeline.packet({{packet.bytes.data(), packet.bytes.size()}, now, {first, 2368}, {{}, 2368}});
    }
    bench.pipeline.tick(now);
    EXPECT_EQ(bench.item("sensor roof", now).message.find("has no arrival times") == std::string::npos,
              is_live);
  }
}

}  // namespace
}  // namespace lidard
