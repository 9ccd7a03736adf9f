// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A safety scanner's settings behind a real TCP socket, its data output over a real UDP socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/registry/registry.h"
#include "test/daemon/live/live_bench.h"
#include "test/drivers/sick/safety/ms3_encoder.h"
#include "test/sim/servers/safety_device.h"
#include "test/sim/servers/udp_sender.h"
#include "test/support/ros_master.h"
#include "test/support/starved.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
using testing::Contains;

const Endpoint any_port{IpAddress::v4(127, 0, 0, 1), 0};

/// The scanner as a whole: sends datagrams only where its settings say, and only while it has power.
struct Scanner {
  Scanner() : server(any_port, std::make_unique<sim::SafetyDevice>()) {}

  sim::SafetySettings settings() {
    sim::SafetySettings copy;
    server.with<sim::SafetyDevice>([&](sim::SafetyDevice& device) { copy = device.settings; });
    return copy;
  }
  void send_if_due() {
    const Stamp now = now_of_host();
    if (!powered || now - last < 30ms) return;
    last = now;
    const auto output = settings().current;
    if (!output.enabled || output.host != any_port.address) return;
    ++sample.sequence;
    ++sample.scan;
    for (const Bytes& datagram : ms3_datagrams(sample.instance(), ++identification))
      sender.send({any_port.address, 0}, {output.host, output.port},
                  ByteView(datagram.data(), datagram.size()));
  }
  void power_off() {
    powered = false;
    server.switch_off();
    server.with<sim::SafetyDevice>([](sim::SafetyDevice& device) { device.settings.power_cycle(); });
  }
  void power_on() {
    powered = true;
    server.switch_on();
  }

  sim::DeviceServer server;
  sim::UdpSender sender{sim::Route()};
  Ms3Sample sample;
  std::uint32_t identification = 0;
  Stamp last{};
  bool powered = true;
};

struct ScannerBench final : LiveBench {
  ScannerBench(Scanner& device, const Config& config) : LiveBench(config), scanner(device) {}
  void meanwhile() override { scanner.send_if_due(); }
  std::uint64_t scans() { return sink.count("front/scan"); }
  Scanner& scanner;
};

Config config_of(const Model& model) {
  Config config;
  SensorConfig sensor;
  sensor.name = sensor.frame_id = sensor.driver.frame_id = "front";
  sensor.model = sensor.driver.model = &model;
  sensor.ip_address = any_port.address;
  sensor.ip_port = free_port();
  sensor.driver.requests.host_address = any_port.address;
  sensor.driver.requests.host_port = sensor.ip_port;
  sensor.driver.requests.allow_write = true;
  config.sensors.push_back(sensor);
  return config;
}

Model scanner_at(std::uint16_t port) {
  Model model = *find_model("sick_microscan3");
  model.dialogue_port = port;
  return model;
}

TEST(SafetyLive, TheStreamStartsWhenTheSettingIsWrittenAndAgainAfterAPowerCycle) {
  Scanner scanner;
  const Model model = scanner_at(scanner.server.port());
  ScannerBench bench(scanner, config_of(model));
  ASSERT_TRUE(bench.until([&] { return bench.scans() > 5; }));
  EXPECT_THAT(scanner.settings().heard, Contains("call 176").Times(1));
  ASSERT_TRUE(bench.until([&] { return !scanner.server.has_client(); })) << "hangs up when all is said";
  scanner.power_off();
  bench.run(2500ms);
  const std::uint64_t before = bench.scans();
  scanner.power_on();
  const test::Starved starved;
  const auto back = std::chrono::steady_clock::now();
  ASSERT_TRUE(bench.until([&] { return bench.scans() > before; }));
  EXPECT_LT(std::chrono::steady_clock::now() - back, 2s + starved.time());
  EXPECT_THAT(scanner.settings().heard, Contains("call 176").Times(2));
}

}  // namespace
}  // namespace lidard::test
