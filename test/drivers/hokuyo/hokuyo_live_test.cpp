// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Driver and TCP source against devices behind real sockets on loopback.
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>

#include "drivers/model.h"
#include "drivers/net/tcp_source.h"
#include "test/drivers/hokuyo/scip_bench.h"
#include "test/sim/devices/scip_device.h"
#include "test/sim/devices/uam_device.h"
#include "test/sim/servers/device_server.h"
#include "test/support/starved.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
using sim::DeviceServer;

/// A driver behind a TcpSource, as the daemon has it; the device is a server on loopback.
class LiveDriver final : public DriverBench {
 public:
  LiveDriver(const std::string& model, const sim::DeviceServer& server) : DriverBench(model) {
    TcpOptions options;
    options.device = {IpAddress::v4(127, 0, 0, 1), server.port()};
    options.read_time_out = std::chrono::seconds(1);
    TcpHandlers handlers;
    handlers.receive = [this](Packet packet) {
      packet.arrival = {packet.received.ns};
      driver->receive(packet, *this);
    };
    handlers.connected = [this](HostStamp at) { driver->connected({at.ns}, *this); };
    handlers.disconnected = [this] { driver->disconnected(); };
    source = std::make_unique<TcpSource>(io, options, handlers);
    source->start();
    tick();
  }

  void request(ByteView bytes) override { source->send(bytes); }
  void disconnect(bool again) override { source->disconnect(again); }

  void run(Span time) { io.run_for(time); }
  /// s until `more` further scans came, without what was waited for a processor; at most 30 s.
  double until_scans(std::size_t more) {
    const std::size_t wanted = scans.size() + more;
    const Starved starved;
    const auto begin = std::chrono::steady_clock::now();
    const auto passed = [&] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    while (scans.size() < wanted && passed() < 30) io.run_for(std::chrono::milliseconds(5));
    return scans.size() < wanted ? passed() : passed() - starved.seconds();
  }

  boost::asio::io_context io;
  std::unique_ptr<TcpSource> source;

 private:
  void tick() {
    timer_.expires_after(std::chrono::milliseconds(20));
    timer_.async_wait([this](const boost::system::error_code& error) {
      if (error) return;
      driver->tick(sim::now_of_host(), *this);
      tick();
    });
  }
  boost::asio::steady_timer timer_{io};
};

std::unique_ptr<sim::TcpDevice> ust() {
  sim::ScipDeviceOptions options;
  options.clock_ppm = 100;
  options.transit.jitter = 5ms;
  return std::make_unique<sim::ScipDevice>(
      options, [](Stamp) { return scip_wall(1081); }, sim::now_of_host() - 100s);
}

std::unique_ptr<sim::TcpDevice> uam() {
  return std::make_unique<sim::UamDevice>(
      sim::UamDeviceOptions(),
      [](Stamp, std::size_t beams) {
        return std::vector<sim::UamBeam>(beams, {1500, 100});
      },
      sim::now_of_host() - 100s);
}

const Endpoint loopback{IpAddress::v4(127, 0, 0, 1), 0};

TEST(HokuyoLive, StreamsWithoutLoss) {
  DeviceServer server(loopback, ust());
  LiveDriver live("hokuyo_ust_10lx", server);
  live.until_scans(10);
  const std::uint64_t before = live.scans.size();
  const Stamp from = live.scans.back().stamp;
  const Starved starved;
  EXPECT_LT(live.until_scans(120), 3.3);
  EXPECT_GE(live.scans.size() - before, 120U);
  // By the device's own clock; each missing scan would be 25 ms more.
  EXPECT_NEAR(seconds(live.scans.back().stamp - from),
              0.025 * static_cast<double>(live.scans.size() - before), 0.01 + starved.seconds());
  EXPECT_EQ(live.driver->counters().lost_packets, 0U);
  EXPECT_EQ(live.driver->counters().rejected_total(), 0U);
  EXPECT_EQ(server.connections(), 1U);
  EXPECT_EQ(live.driver->info().serial, "H1234567");
}

TEST(HokuyoLive, ComesBackWithinTwoSecondsWhateverHappensToTheConnection) {
  const std::vector<std::pair<std::string, std::function<void(DeviceServer&)>>> accidents = {
      {"closed", [](DeviceServer& server) { server.drop(false); }},
      {"reset", [](DeviceServer& server) { server.drop(true); }},
      {"power cycle", [](DeviceServer& server) {
         server.switch_off();
         server.with<sim::ScipDevice>(
             [](sim::ScipDevice& device) { device.power_cycle(sim::now_of_host()); });
       }}};
  DeviceServer server(loopback, ust());
  LiveDriver live("hokuyo_ust_10lx", server);
  live.until_scans(10);
  for (const auto& [name, happens] : accidents) {
    happens(server);
    live.run(700ms);
    server.switch_on();
    EXPECT_LT(live.until_scans(5), 2.2) << name;
  }
  EXPECT_EQ(live.driver->counters().rejected_total(), 0U);
}

TEST(HokuyoLive, AHalfOpenConnectionIsLeftAndMadeAnew) {
  DeviceServer server(loopback, ust());
  LiveDriver live("hokuyo_ust_10lx", server);
  live.until_scans(10);
  server.hang(true);
  live.run(3s);
  server.hang(false);
  EXPECT_LT(live.until_scans(5), 2.2);
  EXPECT_GE(server.connections(), 2U);
}

TEST(HokuyoLive, AUamStreamsAndComesBack) {
  DeviceServer server(loopback, uam());
  LiveDriver live("hokuyo_uam_05lp", server);
  EXPECT_LT(live.until_scans(20), 4);
  server.drop(true);
  EXPECT_LT(live.until_scans(5), 2.2);
  EXPECT_EQ(live.driver->counters().rejected_total(), 0U);
  EXPECT_EQ(live.driver->info().serial, "H7001234");
}

}  // namespace
}  // namespace lidard::test
