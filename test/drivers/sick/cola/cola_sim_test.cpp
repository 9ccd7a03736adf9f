// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The driver against a simulated scanner: first on a virtual clock, then over a real connection.
#include <gmock/gmock.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cmath>
#include <cstdio>

#include "drivers/model.h"
#include "drivers/net/tcp_source.h"
#include "drivers/registry/registry.h"
#include "test/sim/devices/cola_device.h"
#include "test/sim/servers/device_server.h"

namespace lidard::test {
namespace {

using sim::Cola;
using sim::ColaDevice;
using sim::ColaDeviceOptions;

/// A room whose wall moves: every scan is another one.
std::vector<sim::ColaBeam> room(Stamp when, std::size_t beams) {
  std::vector<sim::ColaBeam> seen(beams);
  const auto base = static_cast<std::size_t>(when.ns / 1'000'000 % 1000) + 1000;
  for (std::size_t i = 0; i < beams; ++i) seen[i].mm[0] = static_cast<std::uint16_t>(base + i % 50);
  if (beams > 2) seen[0].mm[0] = 0, seen[1].mm[0] = 2;
  return seen;
}

/// One scanner and its driver on one virtual clock.
class Session final : public DriverOutput {
 public:
  explicit Session(ColaDeviceOptions options = {}, const char* model = "sick_lms1xx",
                   DriverConfig config = {})
      : device(std::move(options), room, now) {
    config.model = find_model(model);
    driver = config.model->make(config);
  }

  void scan(PlanarScan& scan) override {
    ASSERT_EQ(violation(scan), nullptr);
    ++scans;
    lag = seconds(scan.stamp - sweep);
    ASSERT_EQ(scan.ranges.size(), device.options().beams);
    const auto expected = room(sweep, 3);
    EXPECT_FLOAT_EQ(scan.ranges[2], static_cast<float>(expected[2].mm[0] * 1e-3));
    EXPECT_TRUE(std::isinf(scan.ranges[0]) && std::isnan(scan.ranges[1]));
  }
  void cloud(Cloud&) override { ++clouds; }
  void request(ByteView bytes) override { to_device += bytes.text(); }
  void note(std::string_view sentence) override { notes.emplace_back(sentence); }
  void disconnect(bool) override { ++disconnects; }

  void connect() {
    device.connected(now);
    driver->connected(now, *this);
  }
  void drop() {
    device.disconnected();
    driver->disconnected();
    to_device.clear();
  }
  void run(double s) {
    const Stamp end = now + span_from_seconds(s);
    while (now < end) {
      now = now + std::chrono::milliseconds(2);
      if (!to_device.empty()) device.receive(std::exchange(to_device, {}), now);
      while (const auto outgoing = device.next(now)) {
        Packet packet;
        packet.payload = ByteView(outgoing->bytes);
        packet.arrival = outgoing->time;
        packet.transport = Transport::tcp;
        if (outgoing->sweep) sweep = *outgoing->sweep;
        driver->receive(packet, *this);
      }
      driver->tick(now, *this);
    }
  }
  bool has_warning(const std::string& part) const {
    for (const std::string& each : driver->info().warnings) {
      if (each.find(part) != std::string::npos) return true;
    }
    return false;
  }

  Stamp now{1'800'000'000'000'000'000};
  ColaDevice device;
  std::unique_ptr<Driver> driver;
  std::string to_device;
  Stamp sweep;
  std::size_t scans = 0, clouds = 0;
  int disconnects = 0;
  double lag = 0;
  std::vector<std::string> notes;
};

TEST(ColaSim, StampsAreTheFirstBeamsInBothConventions) {
  for (const bool last : {true, false}) {
    ColaDeviceOptions options;
    options.stamps_last_beam = last;
    Session session(options, last ? "sick_lms1xx" : "sick_lms5xx");
    session.connect();
    session.run(2);
    EXPECT_NEAR(session.lag, 50e-6, 20e-6) << "the way through the network";
  }
}

TEST(ColaSim, ANavIsAskedForItsAngles) {
  for (const bool knows : {true, false}) {
    ColaDeviceOptions options;
    options.type = "NAV310";
    if (knows) options.compensation = {823, 1937037, 231};
    Session session(options, "sick_nav31x");
    session.connect();
    session.run(2);
    EXPECT_GT(session.scans, 50U);
    EXPECT_NE(session.device.received().find("sRN MCAngleCompSin"), std::string::npos);
    EXPECT_EQ(session.has_warning("MCAngleCompSin"), !knows);
  }
}

TEST(ColaSim, AScannerThatKnowsNoContaminationIsAskedOnce) {
  Session session;
  session.connect();
  session.run(25);
  std::size_t asked = 0;
  for (std::size_t at = 0; (at = session.device.received().find("LCMstate", at)) != std::string::npos; ++at)
    ++asked;
  EXPECT_EQ(asked, 1U);
  EXPECT_TRUE(session.driver->info().warnings.empty());
}

TEST(ColaSim, ContaminationIsAskedForAgainAndAgainBesideTheStream) {
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    ColaDeviceOptions options;
    options.dialect = dialect;
    options.contamination = 0;
    Session session(options);
    session.connect();
    session.run(2);
    EXPECT_FALSE(session.has_warning("contamination"));
    for (int incident = 0; incident < 2; ++incident) {
      session.device.options().contamination = 1;
      session.run(11);
      EXPECT_TRUE(session.has_warning("contamination"));
      session.device.options().contamination = 0;
      session.run(11);
      EXPECT_FALSE(session.has_warning("contamination"));
    }
    EXPECT_EQ(session.disconnects, 0);
    EXPECT_EQ(session.driver->counters().lost_packets, 0U);
  }
}

TEST(ColaSim, ComesBackAfterAPowerCycle) {
  Session session;
  session.connect();
  session.run(3);
  const std::size_t before = session.scans;
  session.device.power_cycle(session.now);
  session.drop();
  session.device.options().boot = std::chrono::seconds(1);
  session.run(5);
  EXPECT_EQ(session.scans, before);
  session.connect();
  session.run(2);
  EXPECT_GT(session.scans, before + 90);
  EXPECT_NEAR(session.lag, 50e-6, 50e-6);
}

TEST(ColaSim, ADeviceThatStillStartsUpIsAskedAgain) {
  ColaDeviceOptions options;
  options.boot = std::chrono::seconds(3);
  Session session(options);
  for (int attempt = 0; attempt < 10 && session.scans == 0; ++attempt) {
    session.connect();
    session.run(1);
    if (session.disconnects > attempt) session.drop();
  }
  EXPECT_GT(session.scans, 0U);
  EXPECT_GE(session.disconnects, 2);
  EXPECT_FALSE(session.has_warning("refused"));
}

TEST(ColaSim, WritesOnceAndFindsItAgreesNextTime) {
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    ColaDeviceOptions options;
    options.dialect = dialect;
    DriverConfig config;
    config.requests.allow_write = true;
    config.requests.skip = 4;
    Session session(options, "sick_lms1xx", config);
    session.connect();
    session.run(5);
    EXPECT_EQ(session.device.writes(), 1);
    EXPECT_EQ(session.device.options().interval, 5);
    EXPECT_EQ(session.device.options().rssi, 1);
    EXPECT_EQ(session.driver->counters().lost_packets, 0U) << "every 5th scan is no loss";
    EXPECT_EQ(session.notes.size(), 1U);
    session.drop();
    session.connect();
    session.run(3);
    EXPECT_EQ(session.device.writes(), 1);
    EXPECT_GT(session.scans, 20U);
  }
}

TEST(ColaSim, FourPlanesOfAnMrs1000) {
  ColaDeviceOptions options;
  options.type = "MRS1xxxx";
  options.scans_per_turn = 4;
  options.start = -475000;
  options.step = 2500;
  options.exact_step_deg = 0.25;
  options.beams = 1101;
  options.layers = {250, -500, 0, -250};
  options.stamps_last_beam = false;
  Session session(options, "sick_mrs1000");
  session.connect();
  session.run(4);
  EXPECT_GE(session.clouds, 45U);
  EXPECT_LE(session.driver->counters().partial_frames, 1U);
}

/// A driver behind a TcpSource, as the daemon has it.
class LiveClient final : public DriverOutput {
 public:
  LiveClient(boost::asio::io_context& io, std::uint16_t port, const char* model) {
    DriverConfig config;
    config.model = find_model(model);
    driver = config.model->make(config);
    TcpOptions options;
    options.device = {IpAddress::v4(127, 0, 0, 1), port};
    TcpHandlers handlers;
    handlers.receive = [this](Packet packet) {
      packet.arrival = {packet.received.ns};
      driver->receive(packet, *this);
    };
    handlers.connected = [this](HostStamp at) { driver->connected({at.ns}, *this); };
    handlers.disconnected = [this] { driver->disconnected(); };
    source = std::make_unique<TcpSource>(io, options, handlers);
    source->start();
  }
  void scan(PlanarScan& scan) override {
    EXPECT_EQ(violation(scan), nullptr);
    ++scans;
  }
  void cloud(Cloud&) override {}
  void request(ByteView bytes) override { source->send(bytes); }
  void disconnect(bool again) override { source->disconnect(again, "the dialogue ended"); }

  std::unique_ptr<Driver> driver;
  std::unique_ptr<TcpSource> source;
  std::size_t scans = 0;
};

class ColaLive : public ::testing::TestWithParam<Cola> {};
INSTANTIATE_TEST_SUITE_P(Dialects, ColaLive, ::testing::Values(Cola::binary, Cola::text),
                         [](const auto& each) { return each.param == Cola::binary ? "binary" : "text"; });

TEST_P(ColaLive, StreamsAndComesBackAfterResetPowerCycleAndSilence) {
  ColaDeviceOptions options;
  options.dialect = GetParam();
  sim::DeviceServer server({IpAddress::v4(127, 0, 0, 1), 0},
                           std::make_unique<ColaDevice>(options, room, sim::now_of_host()));
  boost::asio::io_context io;
  LiveClient client(io, server.port(), "sick_lms1xx");
  boost::asio::steady_timer ticker(io);
  std::function<void()> tick = [&] {
    ticker.expires_after(std::chrono::milliseconds(50));
    ticker.async_wait([&](const auto& error) {
      if (error) return;
      client.driver->tick(sim::now_of_host(), client);
      tick();
    });
  };
  tick();
  /// Seconds until `count` more scans came.
  const auto wait_for_scans = [&](std::size_t count, double limit) {
    const Stamp begin = sim::now_of_host();
    const std::size_t goal = client.scans + count;
    while (client.scans < goal && seconds(sim::now_of_host() - begin) < limit)
      io.run_for(std::chrono::milliseconds(20));
    EXPECT_GE(client.scans, goal);
    return seconds(sim::now_of_host() - begin);
  };
  wait_for_scans(50, 60);
  EXPECT_EQ(client.driver->counters().lost_packets, 0U);
  server.drop(true);
  const double after_reset = wait_for_scans(5, 60);
  server.switch_off();
  io.run_for(std::chrono::milliseconds(300));
  server.with<ColaDevice>([](ColaDevice& device) { device.power_cycle(sim::now_of_host()); });
  server.switch_on();
  const double after_power = wait_for_scans(5, 60);
  server.hang(true);
  io.run_for(std::chrono::milliseconds(700));
  server.hang(false);
  const double after_silence = wait_for_scans(5, 60);
  std::printf("scans again %.2f s after a reset, %.2f s after a power cycle, %.2f s after silence\n",
              after_reset, after_power, after_silence);
  EXPECT_EQ(client.driver->counters().rejected_total(), 0U);
  client.source->stop();
}

}  // namespace
}  // namespace lidard::test
