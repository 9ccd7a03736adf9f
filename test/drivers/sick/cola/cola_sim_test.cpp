// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The driver against a simulated scanner on a virtual clock.
#include <gmock/gmock.h>

#include <cmath>

#include "drivers/model.h"
#include "test/sim/devices/cola_device.h"
#include "test/support/collector.h"

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
class Session final : public DriverBench {
 public:
  explicit Session(ColaDeviceOptions options = {}, const char* model = "sick_lms1xx",
                   DriverConfig config = {})
      : DriverBench(model, std::move(config)), device(std::move(options), room, now) {}

  void scan(PlanarScan& scan) override {
    DriverBench::scan(scan);
    lag = seconds(scan.stamp - sweep);
    ASSERT_EQ(scan.ranges.size(), device.options().beams);
    const auto expected = room(sweep, 3);
    EXPECT_FLOAT_EQ(scan.ranges[2], static_cast<float>(expected[2].mm[0] * 1e-3));
    EXPECT_TRUE(std::isinf(scan.ranges[0]) && std::isnan(scan.ranges[1]));
  }
  void request(ByteView bytes) override { to_device += bytes.text(); }

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
        if (outgoing->sweep) sweep = *outgoing->sweep;
        Packet packet;
        packet.payload = ByteView(outgoing->bytes);
        packet.arrival = outgoing->time;
        packet.transport = Transport::tcp;
        driver->receive(packet, *this);
      }
      driver->tick(now, *this);
    }
  }

  ColaDevice device;
  std::string to_device;
  Stamp sweep;
  double lag = 0;
};

TEST(ColaSim, ANavIsAskedForItsAngles) {
  for (const bool knows : {true, false}) {
    ColaDeviceOptions options;
    options.type = "NAV310";
    if (knows) options.compensation = {823, 1937037, 231};
    Session session(options, "sick_nav31x");
    session.connect();
    session.run(2);
    EXPECT_GT(session.scans.size(), 50U);
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
    EXPECT_EQ((session.reconnects + session.closes), 0);
    EXPECT_EQ(session.driver->counters().lost_packets, 0U);
  }
}

TEST(ColaSim, ADeviceThatStillStartsUpIsAskedAgain) {
  ColaDeviceOptions options;
  options.boot = std::chrono::seconds(3);
  Session session(options);
  for (int attempt = 0; attempt < 10 && session.scans.empty(); ++attempt) {
    session.connect();
    session.run(1);
    if ((session.reconnects + session.closes) > attempt) session.drop();
  }
  EXPECT_GT(session.scans.size(), 0U);
  EXPECT_GE((session.reconnects + session.closes), 2);
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
    EXPECT_GT(session.scans.size(), 20U);
  }
}

}  // namespace
}  // namespace lidard::test
