// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What /diagnostics makes of a device that talks but sends no data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/health/pipeline_health.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/registry/registry.h"
#include "test/daemon/pipeline/line_driver.h"
#include "test/sim/devices/scip_wire.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr Stamp begin{1'767'225'600'000'000'000};

Config config_of(const char* model) {
  Config config;
  SensorConfig sensor;
  sensor.name = sensor.frame_id = sensor.driver.frame_id = "front";
  sensor.model = sensor.driver.model = find_model(model);
  sensor.ip_address = IpAddress::v4(192, 168, 0, 10);
  sensor.ip_port = sensor.model->port;
  sensor.driver.requests.host_address = IpAddress::v4(192, 168, 0, 1);
  config.sensors.push_back(sensor);
  return config;
}

struct Bench {
  explicit Bench(const char* model) : pipeline(config_of(model), poses, sink) {}
  void chunk(const std::string& bytes) {
    Packet packet;
    packet.transport = Transport::tcp;
    packet.arrival = now;
    packet.payload = ByteView(bytes);
    pipeline.chunk(0, packet);
  }
  /// Long enough that silence counts; in steps, for a jump would be a new start.
  void pass_a_start() {
    for (int i = 0; i < 11; ++i) pipeline.tick(now = now + 100ms);
  }
  DiagnosticItem health() { return items_of(pipeline, now).at(0); }

  NoTransforms poses;
  RecordingSink sink;
  Pipeline pipeline;
  Stamp now = begin;
};

TEST(DialogueHealth, AnswersOfADialogueAreNoData) {
  Bench bench("hokuyo_ust_10lx");
  bench.pipeline.connected(0, bench.now);
  bench.chunk(sim::scip_answer("QT", "00"));
  bench.chunk(sim::scip_answer("VV", "00", sim::scip_entries({{"PROD", "UST-10LX"}})));
  bench.pass_a_start();
  EXPECT_FALSE(bench.pipeline.status(bench.pipeline.now()).sensors.at(0).seen);
  EXPECT_EQ(bench.health().health, Health::error);
  EXPECT_THAT(bench.health().message, HasSubstr("nothing received from 192.168.0.10:10940"));
}

TEST(DialogueHealth, AScanIsData) {
  Bench bench("hokuyo_ust_10lx");
  const std::string stamp = sim::scip_line(sim::scip_code(1000, 4));
  bench.chunk(sim::scip_answer("MD0000000101000", "99", stamp + sim::scip_block("0010020")));
  EXPECT_TRUE(bench.pipeline.status(bench.pipeline.now()).sensors.at(0).seen);
  EXPECT_EQ(bench.pipeline.status(bench.pipeline.now()).sensors.at(0).last_arrival, bench.now);
}

// The device of a model that sends datagrams is told over TCP to do so; that it refuses is why none come.
TEST(DialogueHealth, WhatStopsTheDialogueOfAPicoScanIsTheReasonForSilence) {
  Bench bench("sick_picoscan150");
  bench.pipeline.connected(0, bench.now);
  bench.chunk("\x02sFA 3\x03");
  bench.pass_a_start();
  EXPECT_EQ(bench.health().health, Health::error);
  EXPECT_THAT(bench.health().message, HasSubstr("nothing received from 192.168.0.10 to port 2115"));
  EXPECT_THAT(bench.health().message, HasSubstr("the device refuses to report ScanDataEthSettings"));
}

}  // namespace
}  // namespace lidard::test
