// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// When /diagnostics calls a sensor silent, and what it names as the cause.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/health/sensor_health.h"
#include "daemon/pipeline/sensor.h"
#include "drivers/registry/registry.h"
#include "test/daemon/pipeline/line_driver.h"
#include "test/support/pipeline_bench.h"
#include "test/support/says.h"

namespace lidard {
namespace {

using test::bench_begin;
using testing::HasSubstr;

/// A Velodyne that has been heard of, all its limits kept.
struct Sample {
  Sample() {
    config =
        parse_config(
            "sensors: {roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, telemetry_port: 8308}}", "s")
            .sensors.at(0);
    report.name = "roof";
    report.seen = true;
    report.last_arrival = bench_begin;
    report.counters.packets = 1000;
    report.counters.frames = 1;
  }
  DiagnosticItem after(double passed_ms) const {
    SensorStatus status = report;
    status.config = &config;
    return sensor_health(status, unknown, bench_begin + ms(passed_ms));
  }
  SensorConfig config;
  SensorStatus report;
  /// Datagrams that no sensor claims.
  void stray(const IpAddress& sender, std::uint16_t port, int packets) {
    Packet packet;
    packet.from.address = sender;
    packet.to.port = port;
    packet.arrival = bench_begin;
    for (int i = 0; i < packets; ++i) unknown.note(packet);
  }
  UnknownSenders unknown;
};

const char* const network = "; check the sensor's power, its destination address and port, and the firewall";

TEST(Silence, IsAWarningWithinOneSecondAndAnErrorWithinThree) {
  const Sample sample;
  EXPECT_EQ(sample.after(0).message, "receiving");
  EXPECT_EQ(sample.after(799).health, Health::ok);
  EXPECT_EQ(sample.after(800).health, Health::ok);
  EXPECT_EQ(sample.after(801).health, Health::warn);
  EXPECT_EQ(sample.after(801).message,
            std::string("silent: nothing received from 192.168.1.201 to port 2368") + network);
  EXPECT_EQ(sample.after(2799).health, Health::warn);
  EXPECT_EQ(sample.after(2801).health, Health::error);
  EXPECT_EQ(sample.after(2801).message, sample.after(801).message);
}

TEST(Silence, OfTheDataWhileTelemetryComesIsAnErrorAtOnce) {
  Sample sample;
  sample.report.last_telemetry = bench_begin + ms(500);
  EXPECT_EQ(sample.after(600).health, Health::ok) << "a healthy sensor sends both";
  EXPECT_EQ(sample.after(800).health, Health::ok);
  EXPECT_EQ(sample.after(801).health, Health::error);
  EXPECT_EQ(sample.after(801).message,
            "no data, only telemetry on port 8308; check that its laser and motor are on and that it sends "
            "data to port 2368");
  EXPECT_EQ(sample.after(1499).health, Health::error);
  EXPECT_EQ(sample.after(1500).health, Health::warn)
      << "a second after the telemetry it is silent altogether";
  EXPECT_THAT(sample.after(1500).message, HasSubstr("silent: nothing received"));
}

TEST(Silence, OfASourceThatSendsSeldomTakesLonger) {
  Sample sample;
  sample.report.recent.period_s = 1;
  EXPECT_EQ(sample.after(2500).health, Health::ok);
  EXPECT_EQ(sample.after(2501).health, Health::warn);
  EXPECT_EQ(sample.after(4500).health, Health::warn);
  EXPECT_EQ(sample.after(4501).health, Health::error);
}

TEST(Silence, IsPublishedWhenItIsNoticedAndWhenItEnds) {
  test::PipelineBench bench("sensors: {a: {topic: /a}}");
  std::vector<std::pair<double, Health>> told;
  bench.add_items = [&](std::vector<DiagnosticItem>& items) {
    if (told.empty() || told.back().second != items[0].health) told.emplace_back(0, items[0].health);
  };
  const auto pass = [&](double from, double to, bool scans) {
    for (double time = from; time < to; time += 100) {
      const std::size_t before = told.size();
      if (scans) bench.give("a", test::round_scan("a", bench_begin + ms(time)), bench_begin + ms(time));
      bench.pipeline.tick(bench_begin + ms(time));
      if (told.size() > before) told.back().first = time;
    }
  };
  pass(0, 5050, true);  // the last scan comes at 5000
  pass(5100, 9050, false);
  pass(9100, 12000, true);
  ASSERT_EQ(told.size(), 4U);
  EXPECT_EQ(told[1].second, Health::warn);
  EXPECT_LE(told[1].first, 5900) << "within a second of the last scan";
  EXPECT_EQ(told[2].second, Health::error);
  EXPECT_LE(told[2].first, 7900) << "and within three";
  EXPECT_EQ(told[3], std::pair(9100.0, Health::ok));
}

TEST(Silence, FromTheStartIsAnErrorUnlessAllHasJustBegun) {
  Sample sample;
  sample.report.seen = false;
  sample.report.last_arrival = {};
  EXPECT_EQ(sample.after(0).health, Health::error);
  EXPECT_EQ(sample.after(0).message,
            std::string("nothing received from 192.168.1.201 to port 2368") + network);
  sample.report.starting = true;
  EXPECT_EQ(sample.after(0).health, Health::ok);
  EXPECT_EQ(sample.after(0).message, "waiting for data from 192.168.1.201 to port 2368");
  TcpState& tcp = sample.report.connection.tcp;
  tcp = {TcpState::Phase::waiting, {TcpFault::Kind::not_connected, ECONNREFUSED}};
  EXPECT_EQ(sample.after(0).health, Health::error) << "an attempt that failed needs no patience";
  tcp = {TcpState::Phase::connecting};
  EXPECT_EQ(sample.after(0).health, Health::ok);
  tcp.fault.kind = TcpFault::Kind::not_connected;
  EXPECT_EQ(sample.after(0).health, Health::error) << "the next attempt";
  tcp = {TcpState::Phase::connecting};
  sample.report.connection.port.error = EACCES;
  EXPECT_EQ(sample.after(0).health, Health::error) << "its port cannot be opened";
}

TEST(Silence, OfAnEmptyCaptureIsNoTelemetry) {
  Sample sample;
  sample.report.seen = false;
  sample.report.config = &sample.config;
  EXPECT_THAT(sensor_health(sample.report, sample.unknown, Stamp{}).message, HasSubstr("nothing received"));
}

TEST(Silence, NamesItsCauseAsFarAsItIsKnown) {
  Sample sample;
  const auto message = [&] { return sample.after(1001).message; };
  HostCounts& counts = sample.report.connection.counts.emplace();
  counts.time_s = 1, counts.now.dropped_by_path = 754;
  EXPECT_THAT(message(), HasSubstr("to port 2368: the reverse path filter of this host drops 754 packets/s"));
  sample.report.info.warnings = {"first", "the device says so"};
  EXPECT_THAT(message(), testing::EndsWith("to port 2368: first. the device says so"));
  HostNetwork& network = sample.report.connection.network.emplace();
  network.interfaces = {{"lidar0", IpAddress::v4(192, 168, 1, 100), 24, true, false}};
  EXPECT_THAT(message(), AllOf(HasSubstr("to port 2368: lidar0 (192.168.1.100/24) has no link"),
                               test::Says(says::besides)));
  counts = {};
  EXPECT_THAT(message(),
              testing::EndsWith("has no link; check the cable, the switch and the sensor's power"));
  sample.stray(IpAddress::v4(192, 168, 1, 9), 23680, 9);
  sample.stray(IpAddress::v4(192, 168, 1, 7), 2368, 3);
  EXPECT_THAT(message(),
              testing::EndsWith(", but there are packets from 192.168.1.7 -> port 2368 (3 packets); correct "
                                "ip_address?"));
  sample.config.packet_topic = "/packets";
  EXPECT_EQ(message(), "silent: nothing received from topic /packets; is its driver running?");

  const auto device = [](const std::string& text) {
    return parse_config("sensors: {s: {" + text + "}}", "s");
  };
  const Config laser = device("model: hokuyo_utm_30lx_ew, ip_address: 192.168.0.10");
  sample = {};
  sample.config = laser.sensors[0];
  EXPECT_EQ(message(), "silent: nothing received from 192.168.0.10:10940; does the device measure?");
  sample.report.info.warnings = {"SCIP error 10"};
  EXPECT_EQ(message(), "silent: nothing received from 192.168.0.10:10940: SCIP error 10");
  const Config foreign = device("topic: /scan");
  sample.config = foreign.sensors[0];
  EXPECT_EQ(message(), "silent: nothing received from topic /scan; is its driver running?");
  const Config any = device("model: velodyne_vlp16");
  sample = {};
  sample.config = any.sensors[0];
  EXPECT_THAT(message(), HasSubstr("from any sender to port 2368"));
}

TEST(Silence, EndsWithTheNextPacketAndTheDeviceMayStillWarn) {
  Sample sample;
  sample.report.info.warnings = {"first", "its window is dirty"};
  EXPECT_EQ(sample.after(500).health, Health::warn);
  EXPECT_EQ(sample.after(500).message, "first. its window is dirty");
  sample.report.recent.sender_changes = 20;
  EXPECT_EQ(sample.after(500).health, Health::error);
  EXPECT_THAT(sample.after(500).message, HasSubstr("both send to port 2368"));
}

TEST(Silence, ASensorOfWhichNoPacketIsGoodIsAnErrorWhateverTheShareOfLate) {
  Sample sample;
  sample.report.counters.packets = 3;
  sample.report.counters.rejected[static_cast<std::size_t>(Reject::size)] = 2;
  EXPECT_EQ(sample.after(0).health, Health::ok) << "one was good";
  sample.report.counters.rejected[static_cast<std::size_t>(Reject::field)] = 1;
  EXPECT_EQ(sample.after(0).health, Health::error);
  EXPECT_EQ(sample.after(0).message,
            "no packet could be used, rejected 3 (size 2, field 1); is it a VLP-16?");
}

TEST(SensorItem, ShowsEveryCounterUnderItsName) {
  Sample sample;
  Counters& c = sample.report.counters;
  c.packets = 1, c.other_packets = 2, c.frames = 3, c.partial_frames = 4, c.lost_packets = 5,
  c.incomplete = 6;
  c.reordered = 7, c.clock_steps = 8;
  Reception& recent = sample.report.recent;
  recent.frames_s = 4, recent.frames = 38, recent.expected = 40, recent.watched_s = 4;
  recent.counters.lost_packets = 9;
  recent.counters.rejected[static_cast<std::size_t>(Reject::size)] = 1;
  recent.beams = 200, recent.returns = 50;
  sample.report.info.details = {{"Laser", "on"}};
  const DiagnosticItem item = sample.after(0);
  const std::vector<std::pair<std::string, std::string>> expected{{"IP Address", "192.168.1.201"},
                                                                  {"IP Port", "2368"},
                                                                  {"Laser", "on"},
                                                                  {"Packets", "1"},
                                                                  {"Other packets", "2"},
                                                                  {"Frames", "3"},
                                                                  {"Partial frames dropped", "4"},
                                                                  {"Lost packets", "5"},
                                                                  {"Incomplete telegrams", "6"},
                                                                  {"Reordered packets", "7"},
                                                                  {"Clock steps", "8"},
                                                                  {"Rejected", "0"},
                                                                  {"Frames/s", "9.5"},
                                                                  {"Expected frames/s", "10.0"},
                                                                  {"Lost in the last 10 s", "9"},
                                                                  {"Rejected in the last 10 s", "1 (size 1)"},
                                                                  {"Beams with a return (%)", "25.0"}};
  for (const auto& [key, value] : expected) EXPECT_EQ(test::value_of(item, key), value) << key;
  EXPECT_EQ(item.name, "sensor roof");
  EXPECT_EQ(item.hardware_id, "roof");
  sample.report.info.serial = "AB123";
  EXPECT_EQ(sample.after(0).hardware_id, "AB123");
}

TEST(Silence, ABeginningLastsASecondAndNotLonger) {
  test::PipelineBench bench(
      "sensors: {a: {topic: /a}}\nmerged_scans: {m: {laserscan_topics: a, range_max: 9}}");
  const auto health = [&](Stamp now, const char* item) {
    bench.pipeline.tick(now);
    return bench.item(item, now).health;
  };
  EXPECT_EQ(health(bench_begin, "sensor a"), Health::ok);
  EXPECT_EQ(health(bench_begin + ms(999), "sensor a"), Health::ok);
  EXPECT_EQ(health(bench_begin + ms(999), "merged m"), Health::ok);
  EXPECT_EQ(health(bench_begin + ms(1000), "sensor a"), Health::error);
  EXPECT_EQ(health(bench_begin + ms(1000), "merged m"), Health::error);
  // A step of the clock by a second is time that passed; by more it is a beginning, forwards and backwards.
  EXPECT_EQ(health(bench_begin + ms(2000), "sensor a"), Health::error);
  EXPECT_EQ(health(bench_begin + ms(3001), "sensor a"), Health::ok);
  EXPECT_EQ(health(bench_begin + ms(4001), "sensor a"), Health::error);
  EXPECT_EQ(health(bench_begin + ms(5001), "sensor a"), Health::error);
  EXPECT_EQ(health(bench_begin + ms(4001), "sensor a"), Health::error);
  EXPECT_EQ(health(bench_begin + ms(3000), "sensor a"), Health::ok);
}

TEST(Silence, AJumpBackOfTheClockDoesNotMakeOldDataYoung) {
  test::PipelineBench bench("sensors: {a: {topic: /a}}");
  const auto at = [&](double time) {
    bench.pipeline.tick(bench_begin + ms(time));
    return bench.item("sensor a", bench_begin + ms(time));
  };
  for (double time = 0; time <= 2000; time += 100) {
    bench.give("a", test::round_scan("a", bench_begin + ms(time)), bench_begin + ms(time));
    at(time);
  }
  // An hour back; the last scan is taken to have come in just then.
  const double back = -3600e3;
  EXPECT_EQ(at(back).health, Health::ok);
  EXPECT_EQ(at(back + 900).health, Health::ok) << "a jump is a beginning";
  EXPECT_EQ(at(back + 1000).health, Health::warn);
  EXPECT_EQ(at(back + 1800).health, Health::warn);
  EXPECT_EQ(at(back + 2700).health, Health::warn);
  EXPECT_EQ(at(back + 2900).health, Health::error);
}

}  // namespace
}  // namespace lidard
