// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/velodyne/telemetry.h"
#include "test/drivers/velodyne/telemetry_bench.h"
#include "test/support/allocations.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::velodyne {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using test::sentence;
using test::TelemetryBench;
using test::TelemetryBytes;

/// 2026-01-01 10:00:00 UTC.
constexpr Stamp ten_o_clock{1'767'261'600'000'000'000};

std::string rmc(int second) {
  std::array<char, 80> body{};
  std::snprintf(body.data(), body.size(), "GPRMC,1000%02d.00,A,4807.0380,N,01131.0000,E,0,0,010126,,,A",
                second);
  return sentence(body.data());
}

/// A packet stamped `s` seconds after ten by the sensor, which arrives `lag` later by the host.
void send(TelemetryBench& bench, double s, Pps pps, const std::string& nmea, Span lag = milliseconds(1)) {
  TelemetryBytes packet;
  packet.toh(s).pps(pps).nmea(nmea);
  bench.give(packet.view(), ten_o_clock + span_from_seconds(s) + lag);
}

// ---- real captures; the expected values were taken from the bytes by a script of its own

TEST(TelemetryOfCaptures, Vlp16WithLockedPpsGivesFixAndTimeToTheMicrosecond) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_gps_293.pcap");
  TelemetryBench bench;
  EXPECT_EQ(bench.play(path), 57U);
  EXPECT_EQ(bench.receiver->claim(), ClockClaim::synchronised);
  ASSERT_EQ(bench.fixes.size(), 1U) << "57 packets repeat one sentence";
  const GnssFix& fix = bench.fixes[0];
  EXPECT_EQ(fix.frame_id, "roof");
  EXPECT_NEAR(fix.latitude_deg, 36.829130930, 1e-9);
  EXPECT_NEAR(fix.longitude_deg, -2.407571547, 1e-9);
  EXPECT_TRUE(std::isnan(fix.altitude_m));
  EXPECT_EQ(fix.status, FixStatus::satellite);
  ASSERT_TRUE(fix.source_time);
  EXPECT_EQ(fix.source_time->ns, 1'453'364'282'000'000'000);
  EXPECT_EQ(fix.stamp.ns, 1'453'364'282'367'120'000) << "the position is 342 ms older than its packet";
  ASSERT_EQ(bench.references.size(), 1U);
  EXPECT_EQ(bench.references[0].stamp.ns, 1'453'364'282'709'121'000);
  EXPECT_EQ(bench.references[0].reference.ns, 1'453'364'282'342'001'000);
  EXPECT_EQ(bench.references[0].source, "gps_pps");
  EXPECT_EQ(bench.detail("PPS"), "locked");
  EXPECT_EQ(bench.detail("NMEA"), "valid RMC");
  EXPECT_EQ(bench.detail("Clock difference to host (s)"), "0.367");
  EXPECT_EQ(bench.detail("Sensor clock"), "synchronised (PPS and NMEA agree)");
  EXPECT_EQ(bench.detail("Temperature top board (C)"), "(no such detail)");
  EXPECT_TRUE(bench.info.warnings.empty());
}

TEST(TelemetryReceiver, ComparesItsClockWithTheHostsAfterThatWasSet) {
  TelemetryBench bench;
  TelemetryBytes packet;
  const Stamp arrival{1'700'000'000'000'000'000};  // 22:13:20
  packet.toh(800).pps(velodyne::Pps::locked);
  bench.give(packet.view(), arrival);
  EXPECT_EQ(bench.detail("Clock difference to host (s)"), "0.000");
  // Since the program began the host's clock was set by 3 s, and so was the sensor's.
  packet.toh(805);
  bench.give(packet.view(), arrival + std::chrono::seconds(2), HostStamp{arrival.ns + 5'000'000'000});
  EXPECT_EQ(bench.detail("Clock difference to host (s)"), "0.000");
}

TEST(TelemetryOfCaptures, Hdl32eWithoutPpsGivesTwoFixesAndAHundredImuSamples) {
  LIDARD_NEED_CAPTURE(path, "velodyne/hdl32e_gprmc_876.pcap");
  TelemetryBench bench(true);
  EXPECT_EQ(bench.play(path), 100U);
  EXPECT_EQ(bench.receiver->claim(), ClockClaim::agrees);
  EXPECT_EQ(bench.detail("PPS"), "absent");
  EXPECT_EQ(bench.detail("Clock difference to host (s)"), "0.905");
  EXPECT_TRUE(bench.info.warnings.empty());
  ASSERT_EQ(bench.fixes.size(), 2U);
  EXPECT_NEAR(bench.fixes[0].latitude_deg, 37.143015, 1e-9);
  EXPECT_NEAR(bench.fixes[0].longitude_deg, -121.663021667, 1e-9);
  EXPECT_NEAR(bench.fixes[1].latitude_deg, 37.14289, 1e-9);
  EXPECT_NEAR(bench.fixes[1].longitude_deg, -121.662965, 1e-9);
  EXPECT_EQ(bench.fixes[1].status, FixStatus::sbas);
  EXPECT_EQ(bench.fixes[1].stamp.ns, 1'355'263'365'756'183'000);
  ASSERT_EQ(bench.references.size(), 1U) << "the age of the first sentence is not known";
  EXPECT_EQ(bench.references[0].stamp.ns, 1'355'263'365'756'183'000);
  EXPECT_EQ(bench.references[0].reference.ns, 1'355'263'364'000'000'000);
  EXPECT_EQ(bench.references[0].source, "gps_nmea");

  ASSERT_EQ(bench.samples.size(), 100U);
  EXPECT_EQ(bench.samples[0].stamp.ns, 1'355'263'365'380'293'000);
  EXPECT_NEAR(bench.samples[0].angular_velocity.z(), -0.54714082, 1e-8);
  EXPECT_NEAR(bench.samples[0].linear_acceleration.x(), 3.18506263, 1e-8);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& sample : bench.samples) sum += sample.linear_acceleration / 100;
  EXPECT_NEAR(sum.x(), -0.0181 * 9.80665, 1e-3);
  EXPECT_NEAR(sum.y(), -0.0658 * 9.80665, 1e-3);
  EXPECT_NEAR(sum.z(), 0.9277 * 9.80665, 1e-3) << "up, and about 1 g";
}

TEST(TelemetryOfCaptures, AFileNamedVlp32HoldsTheImuOfAnHdl32e) {
  LIDARD_NEED_CAPTURE(path, "velodyne/hdl32e_named_vlp32.pcap");
  TelemetryBench bench(true);
  EXPECT_EQ(bench.play(path), 9U);
  EXPECT_EQ(bench.samples.size(), 9U);
  EXPECT_NEAR(bench.samples[0].linear_acceleration.z(), 9.54920092, 1e-8);
  ASSERT_EQ(bench.fixes.size(), 1U);
  EXPECT_NEAR(bench.fixes[0].latitude_deg, 37.139071667, 1e-9);
  EXPECT_NEAR(bench.fixes[0].longitude_deg, -121.657165, 1e-9);
  EXPECT_EQ(bench.fixes[0].source_time->ns, 1'355'262'376'000'000'000);
  EXPECT_TRUE(bench.references.empty());
}

TEST(TelemetryOfCaptures, ASensorWithoutReceiverIsNoReasonToWarn) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_2014_says_hdl32.pcap");
  TelemetryBench bench(true);
  EXPECT_EQ(bench.play(path), 16U);
  EXPECT_EQ(bench.receiver->claim(), ClockClaim::none);
  EXPECT_EQ(bench.detail("PPS"), "absent");
  EXPECT_EQ(bench.detail("NMEA"), "none");
  EXPECT_EQ(bench.detail("Sensor clock"), "free-running");
  EXPECT_EQ(bench.detail("Clock difference to host (s)"), "-1715.534") << "1884.466 s the longer way round";
  EXPECT_TRUE(bench.info.warnings.empty());
  EXPECT_TRUE(bench.fixes.empty());
  EXPECT_TRUE(bench.references.empty());
  EXPECT_TRUE(bench.samples.empty()) << "a VLP-16 has no inertial unit, whatever its name";
}

// ---- made packets

TEST(TelemetryReceiver, RefusesOtherSizes) {
  TelemetryBench bench;
  const std::array<std::uint8_t, 511> bytes{};
  EXPECT_EQ(bench.give(ByteView(bytes.data(), bytes.size()), ten_o_clock), Reject::size);
  EXPECT_TRUE(bench.info.details.empty());
}

TEST(TelemetryReceiver, SendsOneFixPerSentence) {
  TelemetryBench bench;
  for (int i = 0; i < 300; ++i) send(bench, 5.3 + 0.01 * i, Pps::locked, rmc(5 + i / 100));
  ASSERT_EQ(bench.fixes.size(), 3U);
  ASSERT_EQ(bench.references.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const auto n = static_cast<std::size_t>(i);
    EXPECT_EQ(bench.fixes[n].stamp, ten_o_clock + std::chrono::seconds(5 + i) + milliseconds(1));
    EXPECT_EQ(Span(bench.references[n].stamp.ns - bench.references[n].reference.ns), milliseconds(1));
    EXPECT_EQ(bench.references[n].reference.ns,
              (ten_o_clock + std::chrono::seconds(5 + i) + milliseconds(300)).ns);
  }
}

TEST(TelemetryReceiver, WarnsWhileTheSensorReportsAPpsErrorAndNoLonger) {
  TelemetryBench bench;
  bench.info.warnings = {"somebody else's"};
  send(bench, 1, Pps::error, rmc(0));
  ASSERT_EQ(bench.info.warnings.size(), 2U);
  EXPECT_NE(bench.info.warnings.back().find("PPS error; check"), std::string::npos);
  EXPECT_EQ(bench.detail("PPS"), "error");
  send(bench, 1.01, Pps::locked, rmc(0));
  EXPECT_EQ(bench.info.warnings, std::vector<std::string>{"somebody else's"});
  EXPECT_EQ(bench.receiver->claim(), ClockClaim::synchronised);
}

TEST(TelemetryReceiver, WarnsWhenLockedIsClaimedWithoutAUsableTime) {
  struct Case {
    std::string nmea;
    std::string says;
    unsigned bad;
  };
  const std::vector<Case> cases = {{"", "none", 0},
                                   {sentence("GPRMC,100000,V,,,,,,,010126,,,N"), "receiver has no fix", 0},
                                   {sentence("GPRMC,100000,A,0000.0,N,00000.0,E,0,0,010100"),
                                    "date of 2000 or before: not from a satellite", 0},
                                   {"$GPRMC,100000,A*00", "checksum wrong", 1},
                                   {sentence("GPZDA,100000.00,01,01,2026,00,00"), "neither RMC nor GGA", 1},
                                   {"junk", "malformed", 1}};
  for (const Case& c : cases) {
    TelemetryBench bench;
    send(bench, 1, Pps::locked, c.nmea);
    EXPECT_EQ(bench.receiver->claim(), ClockClaim::no_time) << c.nmea;
    EXPECT_EQ(bench.info.warnings.size(), 1U) << c.nmea;
    EXPECT_EQ(bench.detail("NMEA"), c.says);
    EXPECT_TRUE(bench.references.empty()) << c.nmea;
    EXPECT_EQ(bench.receiver->bad_sentences(), c.bad) << c.nmea;
  }
}

TEST(TelemetryReceiver, WarnsWhenLockedButAnotherTimeThanTheReceivers) {
  TelemetryBench bench;
  send(bench, 1531, Pps::locked, rmc(5));
  EXPECT_EQ(bench.receiver->claim(), ClockClaim::other_time);
  ASSERT_EQ(bench.info.warnings.size(), 1U);
  EXPECT_NE(bench.info.warnings[0].find("differs from the NMEA time; check"), std::string::npos);
  EXPECT_TRUE(bench.references.empty());
  send(bench, 1532, Pps::locked, rmc(6));
  ASSERT_EQ(bench.references.size(), 1U) << "the sentence's own time stays good";
  EXPECT_EQ(bench.references[0].source, "gps_nmea");
  EXPECT_EQ(bench.info.warnings.size(), 1U);
}

TEST(TelemetryReceiver, AFixWithoutPositionIsToldAsSuch) {
  TelemetryBench bench;
  send(bench, 1, Pps::absent, sentence("GPRMC,100000,V,4807.0,N,01131.0,E,,,010126,,,N"));
  ASSERT_EQ(bench.fixes.size(), 1U);
  EXPECT_EQ(bench.fixes[0].status, FixStatus::none);
  EXPECT_TRUE(std::isnan(bench.fixes[0].latitude_deg));
  EXPECT_FALSE(bench.fixes[0].source_time);
  send(bench, 2, Pps::absent, "$GPRMC,broken*00");
  EXPECT_EQ(bench.fixes.size(), 1U) << "what is not understood is counted, not published";
  EXPECT_EQ(bench.receiver->bad_sentences(), 1U);
  EXPECT_TRUE(bench.info.warnings.empty());
}

TEST(TelemetryReceiver, GgaGivesAFixButNoTimeReference) {
  TelemetryBench bench;
  for (int i = 0; i < 3; ++i) {
    send(bench, i + 0.4, Pps::locked,
         sentence("GPGGA,10000" + std::to_string(i) + ",4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"));
  }
  ASSERT_EQ(bench.fixes.size(), 3U);
  EXPECT_NEAR(bench.fixes[0].altitude_m, 592.3, 1e-9);
  EXPECT_EQ(bench.fixes[2].stamp, ten_o_clock + std::chrono::seconds(2) + milliseconds(1));
  EXPECT_TRUE(bench.references.empty()) << "GGA has no date";
  EXPECT_EQ(bench.receiver->claim(), ClockClaim::synchronised);
}

TEST(TelemetryReceiver, TimesGoOnAcrossTheHourAndPastItsEnd) {
  TelemetryBench bench(false, ClockMode::smooth);
  // 3600.4 s: a counter that is not reset in time (ros-drivers/velodyne issue 218).
  const auto give = [&](double toh, double s, const std::string& nmea) {
    TelemetryBytes packet;
    packet.toh(toh).pps(Pps::locked).nmea(nmea);
    bench.give(packet.view(), ten_o_clock + span_from_seconds(s));
  };
  give(3599.4, 3599.4, sentence("GPRMC,105959.00,A,4807.0380,N,01131.0000,E,0,0,010126,,,A"));
  give(3600.4, 3600.4, sentence("GPRMC,110000.00,A,4807.0380,N,01131.0000,E,0,0,010126,,,A"));
  give(1.4, 3601.4, sentence("GPRMC,110001.00,A,4807.0380,N,01131.0000,E,0,0,010126,,,A"));
  ASSERT_EQ(bench.fixes.size(), 3U);
  ASSERT_EQ(bench.references.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const auto n = static_cast<std::size_t>(i);
    EXPECT_EQ(bench.fixes[n].stamp, ten_o_clock + std::chrono::seconds(3599 + i)) << i;
    EXPECT_EQ(bench.references[n].reference.ns, bench.references[n].stamp.ns) << i;
  }
}

TEST(TelemetryReceiver, ClaimsEndWhenTelemetryDoes) {
  TelemetryBench bench;
  bench.receiver->tick(ten_o_clock, bench.info);
  EXPECT_TRUE(bench.info.details.empty());
  send(bench, 1, Pps::locked, "");
  EXPECT_EQ(bench.info.warnings.size(), 1U);
  bench.receiver->tick(ten_o_clock + std::chrono::seconds(3), bench.info);
  EXPECT_EQ(bench.detail("PPS"), "locked");
  bench.receiver->tick(ten_o_clock + std::chrono::seconds(5), bench.info);
  EXPECT_EQ(bench.detail("PPS"), "unknown");
  EXPECT_EQ(bench.detail("Sensor clock"), "unknown: no telemetry for 3 s");
  EXPECT_TRUE(bench.info.warnings.empty());
  send(bench, 6, Pps::locked, rmc(5));
  EXPECT_EQ(bench.detail("PPS"), "locked");
  EXPECT_EQ(bench.receiver->claim(), ClockClaim::synchronised);
}

TEST(TelemetryReceiver, ASensorThatIsMeantToFollowAReceiverWarnsAfterTenSecondsWithoutOne) {
  TelemetryBench bench(false, ClockMode::smooth, true);
  const auto tick = [&bench](int s) {
    bench.receiver->tick(ten_o_clock + std::chrono::seconds(s), bench.info);
    return bench.info.warnings.size();
  };
  EXPECT_EQ(tick(0), 0U);
  EXPECT_EQ(tick(9), 0U) << "a receiver that was just switched on";
  ASSERT_EQ(tick(10), 1U) << "no telemetry at all";
  EXPECT_NE(bench.info.warnings[0].find("as expect_pps requires"), std::string::npos);
  EXPECT_EQ(tick(11), 1U) << "told once";
  send(bench, 12, Pps::locked, rmc(11));
  EXPECT_EQ(tick(12), 0U);
  send(bench, 13, Pps::absent, "");
  EXPECT_EQ(tick(13), 0U);
  for (int s = 14; s < 23; ++s) send(bench, s, Pps::absent, "");
  EXPECT_EQ(tick(22), 0U) << "lost for less than ten seconds";
  EXPECT_EQ(tick(23), 1U);
  send(bench, 24, Pps::error, "");
  EXPECT_EQ(tick(24), 1U) << "the cause alone, which the sensor reports";
  EXPECT_NE(bench.info.warnings[0].find("PPS error"), std::string::npos);
}

TEST(TelemetryReceiver, AFreeRunningClockIsNoReasonToWarnUnlessItIsMeantToFollowAReceiver) {
  TelemetryBench bench;
  for (int s = 0; s < 30; ++s) {
    send(bench, s, Pps::absent, "");
    bench.receiver->tick(ten_o_clock + std::chrono::seconds(s), bench.info);
  }
  EXPECT_TRUE(bench.info.warnings.empty());
}

TEST(TelemetryReceiver, AgeOfASentenceThatIsRepeatedGrows) {
  TelemetryBench bench;
  send(bench, 1.5, Pps::locked, rmc(1));
  EXPECT_EQ(bench.detail("NMEA age (s)"), "0.0");
  send(bench, 9.5, Pps::locked, rmc(1));
  EXPECT_EQ(bench.detail("NMEA age (s)"), "8.0");
}

TEST(TelemetryReceiver, TemperaturesAreOnDiagnosticsWhereTheFirmwareTellsThem) {
  TelemetryBench bench;
  TelemetryBytes packet;
  packet.toh(1).little(0xBB, 53, 1).little(0xBC, 0xFB, 1).little(0xBE, 0xFFFD, 2).little(0xC0, 70'000, 4);
  bench.give(packet.view(), ten_o_clock);
  EXPECT_EQ(bench.detail("Temperature top board (C)"), "53");
  EXPECT_EQ(bench.detail("Temperature bottom board (C)"), "-5");
  EXPECT_EQ(bench.detail("Temperature change since calibration (K)"), "-3");
  EXPECT_EQ(bench.detail("Calibration age (s)"), "70000");
  EXPECT_EQ(bench.detail("Thermal state"), "ok");
}

TEST(TelemetryReceiver, StartsAnewAfterRestart) {
  TelemetryBench bench;
  send(bench, 5.2, Pps::absent, rmc(5));
  send(bench, 6.2, Pps::absent, rmc(6));
  EXPECT_EQ(bench.references.size(), 1U);
  bench.receiver->restart();
  send(bench, 5.2, Pps::absent, rmc(5));
  EXPECT_EQ(bench.fixes.size(), 3U);
  EXPECT_EQ(bench.references.size(), 1U) << "again a first sentence of unknown age";
}

TEST(TelemetryReceiver, AllocatesNothingPerPacket) {
  test::Counted out;
  TelemetryBench bench(true);
  std::vector<TelemetryBytes> packets(200);
  for (std::size_t i = 0; i < packets.size(); ++i)
    packets[i]
        .toh(5.3 + 0.1 * static_cast<double>(i))
        .pps(Pps::locked)
        .nmea(rmc(5 + static_cast<int>(i) / 10));
  std::uint64_t before = 0;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    if (i == 20) before = test::allocations();
    const Stamp arrival = ten_o_clock + std::chrono::seconds(5) + milliseconds(100) * static_cast<int>(i);
    Packet packet;
    packet.payload = packets[i].view();
    packet.arrival = arrival;
    bench.receiver->receive(packet, out, bench.info);
  }
  EXPECT_EQ(test::allocations() - before, 0U);
  EXPECT_EQ(out.fixes, 20U);
}

}  // namespace
}  // namespace lidard::velodyne
