// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Which sensor a packet belongs to, by port and sender; and who sends without belonging to one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "test/daemon/pipeline/line_driver.h"
#include "test/support/pipeline_bench.h"
#include "test/support/says.h"

namespace lidard {
namespace {

using test::bench_begin;
using test::line_model;
using test::line_sensor;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

IpAddress host(int last) { return IpAddress::v4(10, 0, 0, static_cast<std::uint8_t>(last)); }

/// Sensors of which a test asks how many packets each got.
struct Vehicle {
  explicit Vehicle(std::vector<SensorConfig> sensors) {
    config.sensors = std::move(sensors);
    pipeline = std::make_unique<Pipeline>(config, tf, sink);
  }
  void datagram(int from, std::uint16_t to_port, std::uint16_t from_port = 40000) {
    pipeline->packet({ByteView("x"), bench_begin, {host(from), from_port}, {host(1), to_port}});
  }
  void chunk(const Endpoint& from, const Endpoint& to) {
    Packet packet{ByteView("x"), bench_begin, from, to, Transport::tcp};
    packet.stream_start = true;
    pipeline->packet(packet);
  }
  std::vector<std::uint64_t> packets() const {
    std::vector<std::uint64_t> counts;
    for (const SensorStatus& report : pipeline->status(pipeline->now()).sensors)
      counts.push_back(report.counters.packets);
    return counts;
  }

  test::KnownTransforms tf;
  test::RecordingSink sink;
  Config config;
  std::unique_ptr<Pipeline> pipeline;
};

TEST(Routing, ASendersOwnEntryComesBeforeAnEntryForAnySenderInWhateverOrderTheyStand) {
  const Model model = line_model(Transport::udp, 2368);
  std::vector<int> order{0, 1, 2};
  do {
    std::vector<SensorConfig> sensors;
    for (const int which : order) {
      sensors.push_back(line_sensor(model, "s" + std::to_string(which), host(10 + which)));
      if (which == 2) sensors.back().ip_address.reset();
    }
    Vehicle vehicle(std::move(sensors));
    for (int i = 0; i < 5; ++i) vehicle.datagram(10, 2368);
    for (int i = 0; i < 3; ++i) vehicle.datagram(11, 2368);
    for (int i = 0; i < 7; ++i) vehicle.datagram(99, 2368);
    const std::uint64_t expected[] = {5, 3, 7};
    for (std::size_t place = 0; place < 3; ++place)
      EXPECT_EQ(vehicle.packets()[place], expected[order[place]]) << testing::PrintToString(order);
    EXPECT_THAT(vehicle.pipeline->unclaimed_senders(), IsEmpty());
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(Routing, PortAndSenderBothDecide) {
  const Model model = line_model(Transport::udp, 2368);
  SensorConfig first = line_sensor(model, "first", host(10));
  SensorConfig second = line_sensor(model, "second", host(10));
  second.ip_port = 2370;
  SensorConfig third = line_sensor(model, "third", host(11));
  Vehicle vehicle({first, second, third});
  vehicle.datagram(10, 2368);
  vehicle.datagram(10, 2370);
  vehicle.datagram(10, 2370);
  vehicle.datagram(11, 2368);
  EXPECT_THAT(vehicle.packets(), ElementsAre(1, 2, 1));
  vehicle.datagram(11, 2370);
  vehicle.datagram(12, 2368);
  EXPECT_THAT(vehicle.packets(), ElementsAre(1, 2, 1)) << "neither is of any sensor";
  EXPECT_THAT(vehicle.pipeline->unclaimed_senders(), SizeIs(2));
}

TEST(Routing, TelemetryComesInOnAPortOfItsOwn) {
  const Model model = line_model(Transport::udp, 2368);
  SensorConfig with = line_sensor(model, "with", host(10));
  with.telemetry_port = 8308;
  SensorConfig without = line_sensor(model, "without", host(11));
  Vehicle vehicle({without, with});
  vehicle.datagram(10, 8308);
  EXPECT_THAT(vehicle.packets(), ElementsAre(0, 1));
  vehicle.datagram(11, 8308);
  vehicle.datagram(11, 0);
  EXPECT_THAT(vehicle.packets(), ElementsAre(0, 1)) << "a port of 0 is no port";
}

TEST(Routing, TelemetryOfSensorsWithoutAddressGoesToTheOneWhoseDataComeFromThere) {
  const Model model = line_model(Transport::udp, 2368);
  SensorConfig first = line_sensor(model, "first", host(10));
  first.ip_address.reset();
  first.telemetry_port = 8308;
  SensorConfig second = first;
  second.name = "second";
  second.ip_port = 2370;
  Vehicle vehicle({first, second});
  vehicle.datagram(10, 2368);
  vehicle.datagram(11, 2370);
  vehicle.datagram(11, 8308);
  EXPECT_THAT(vehicle.packets(), ElementsAre(1, 2));
  vehicle.datagram(10, 8308);
  EXPECT_THAT(vehicle.packets(), ElementsAre(2, 2));
}

TEST(Routing, ASensorThatIsFedByATopicTakesNoDatagrams) {
  const Model model = line_model(Transport::udp, 2368);
  SensorConfig fed = line_sensor(model, "fed", host(10));
  fed.ip_address.reset();
  fed.packet_topic = "/packets";
  Vehicle vehicle({fed});
  vehicle.datagram(10, 2368);
  EXPECT_THAT(vehicle.packets(), ElementsAre(0));
  Packet packet{ByteView("x"), bench_begin, {}, {}};
  vehicle.pipeline->packet_message("fed", packet, bench_begin);
  EXPECT_THAT(vehicle.packets(), ElementsAre(1));
}

TEST(Routing, SendersOfDatagramsThatNoSensorClaimsAreNamedByAddressAndOurPort) {
  const Model model = line_model(Transport::udp, 2368);
  Vehicle vehicle({line_sensor(model, "a", host(10))});
  vehicle.datagram(20, 2368, 50001);
  vehicle.datagram(20, 2368, 50002);
  vehicle.datagram(20, 2370, 50001);
  vehicle.datagram(21, 2368, 50001);
  EXPECT_THAT(vehicle.pipeline->unclaimed_senders(),
              testing::UnorderedElementsAre("10.0.0.20 -> port 2368 (2 packets)",
                                            "10.0.0.20 -> port 2370 (1 packets)",
                                            "10.0.0.21 -> port 2368 (1 packets)"));
}

TEST(Routing, OfManyUnknownSendersTheNewest32AreNamed) {
  const Model model = line_model(Transport::udp, 2368);
  Vehicle vehicle({line_sensor(model, "a", host(1))});
  for (int sender = 100; sender < 140; ++sender) vehicle.datagram(sender, 2368);
  const auto names = vehicle.pipeline->unclaimed_senders();
  EXPECT_THAT(names, SizeIs(32));
  EXPECT_THAT(names, testing::Contains("10.0.0.139 -> port 2368 (1 packets)"));
}

TEST(Routing, AChunkBelongsToTheDeviceItComesFrom) {
  const Model model = line_model(Transport::tcp, 10940);
  Vehicle vehicle({line_sensor(model, "a", host(10)), line_sensor(model, "b", host(11))});
  const Endpoint us{host(1), 50000};
  vehicle.chunk({host(11), 10940}, us);
  EXPECT_THAT(vehicle.packets(), ElementsAre(0, 1));
  vehicle.chunk(us, {host(10), 10940});
  EXPECT_THAT(vehicle.packets(), ElementsAre(0, 1)) << "what is sent to a device is no data";
  EXPECT_THAT(vehicle.pipeline->unclaimed_senders(), IsEmpty());
  vehicle.chunk({host(12), 10940}, us);
  vehicle.chunk({host(12), 10940}, us);
  vehicle.chunk({host(12), 22}, us);
  EXPECT_THAT(vehicle.packets(), ElementsAre(0, 1));
  EXPECT_THAT(vehicle.pipeline->unclaimed_senders(), ElementsAre("10.0.0.12:10940 over TCP (2 packets)"))
      << "a connection to another port is none of ours";
}

TEST(Routing, UnknownSendersAreADiagnosticItemOfTheirOwn) {
  const Model model = line_model(Transport::udp, 2368);
  Vehicle vehicle({line_sensor(model, "a", host(10))});
  const auto items = [&] { return items_of(*vehicle.pipeline, bench_begin); };
  EXPECT_THAT(items(), SizeIs(1));
  vehicle.datagram(20, 2368);
  ASSERT_THAT(items(), SizeIs(2));
  EXPECT_EQ(items()[1].name, "unknown senders");
  EXPECT_EQ(items()[1].health, Health::warn);
  EXPECT_EQ(items()[1].message,
            "10.0.0.20 -> port 2368 (1 packets) sends to a port of ours but belongs to no sensor; add it to "
            "the configuration, or correct an ip_address");
  vehicle.datagram(21, 2368);
  EXPECT_THAT(items()[1].message, test::Says(says::unknown_senders));
  EXPECT_EQ(test::value_of(items()[1], "Sender 1"), "10.0.0.20 -> port 2368 (1 packets)");
  EXPECT_EQ(test::value_of(items()[1], "Sender 2"), "10.0.0.21 -> port 2368 (1 packets)");
}

TEST(Routing, ASilentSensorIsToldOfAnUnknownSenderToItsOwnPortAlone) {
  const Model model = line_model(Transport::udp, 2368);
  SensorConfig other = line_sensor(model, "other", host(11));
  other.ip_port = 23;
  Vehicle vehicle({line_sensor(model, "a", host(10)), other});
  vehicle.pipeline->tick(bench_begin);
  vehicle.datagram(20, 2368);
  vehicle.pipeline->tick(bench_begin + std::chrono::seconds(1));
  const auto items = items_of(*vehicle.pipeline, bench_begin + std::chrono::seconds(1));
  EXPECT_EQ(items[0].message,
            "nothing received from 10.0.0.10 to port 2368, but there are packets from 10.0.0.20 -> port 2368 "
            "(1 packets); correct ip_address?");
  EXPECT_EQ(items[1].message,
            "nothing received from 10.0.0.11 to port 23; check the sensor's power, its destination address "
            "and port, and the firewall");
}

}  // namespace
}  // namespace lidard
