// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/reception.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "daemon/health/reception_verdict.h"

namespace lidard {
namespace {

using testing::HasSubstr;

constexpr double tick_s = 0.01;

/// Ten seconds of a sensor that should give ten frames per second.
Reception ten_seconds(double frames) {
  Reception r;
  r.watched_s = r.frames_s = 10;
  r.expected = 100;
  r.frames = frames;
  r.period_s = 0.1;
  r.counters.packets = 1000;
  return r;
}

Reception lossy(std::uint64_t packets, std::uint64_t lost) {
  Reception r = ten_seconds(100);
  r.counters.packets = packets;
  r.counters.lost_packets = lost;
  return r;
}

Reception rejecting(std::uint64_t rejected, Reject reason = Reject::size) {
  Reception r = ten_seconds(100);
  r.counters.rejected[static_cast<std::size_t>(reason)] = rejected;
  return r;
}

Reception looking(std::uint64_t returns, std::uint64_t blind) {
  Reception r = ten_seconds(100);
  r.frames_looked = 100;
  r.beams = 10000;
  r.returns = returns;
  r.blind = blind;
  return r;
}

TEST(Reception, IsJudgedByTheFramesThatAreMissing) {
  EXPECT_EQ(judge(ten_seconds(100), FrameKind::cloud).health, Health::ok);
  EXPECT_EQ(judge(ten_seconds(90), FrameKind::cloud).health, Health::ok)
      << "one frame more may be out of the window";
  EXPECT_EQ(judge(ten_seconds(89), FrameKind::cloud).health, Health::warn);
  EXPECT_EQ(judge(ten_seconds(50), FrameKind::cloud).health, Health::warn);
  EXPECT_EQ(judge(ten_seconds(49), FrameKind::cloud).health, Health::error);
  EXPECT_EQ(judge(ten_seconds(74), FrameKind::cloud).figures, "7.4 of 10.0 frames/s");
  EXPECT_EQ(judge(ten_seconds(120), FrameKind::cloud).health, Health::ok) << "more than promised is well";
  Reception young = ten_seconds(3);
  young.frames_s = 1.99;
  EXPECT_EQ(judge(young, FrameKind::cloud).health, Health::ok);
}

TEST(Reception, IsJudgedByLosses) {
  EXPECT_EQ(judge(lossy(9901, 99), FrameKind::cloud).health, Health::ok);
  EXPECT_EQ(judge(lossy(9900, 100), FrameKind::cloud).health, Health::warn);
  EXPECT_EQ(judge(lossy(9501, 499), FrameKind::cloud).health, Health::warn);
  EXPECT_EQ(judge(lossy(9500, 500), FrameKind::cloud).health, Health::error);
  EXPECT_EQ(judge(lossy(40, 1), FrameKind::cloud).health, Health::ok) << "a single one says nothing";
  EXPECT_EQ(judge(lossy(900, 100), FrameKind::cloud).figures, "10.0 of 10.0 frames/s, 10 % of packets lost");
}

TEST(Reception, OfAScannerThatCountsScansIsJudgedByItsFramesAfterALoss) {
  Reception r = ten_seconds(97);
  r.counters.packets = 97 * 14;
  EXPECT_EQ(judge(r, FrameKind::scan).health, Health::ok) << "a nominal rate may be off by so much";
  r.counters.lost_packets = 3;
  EXPECT_EQ(judge(r, FrameKind::scan).health, Health::warn);
  EXPECT_EQ(judge(r, FrameKind::scan).figures, "9.7 of 10.0 frames/s, 3 packets or scans lost");
  r.frames = 94;
  EXPECT_EQ(judge(r, FrameKind::scan).health, Health::error);
}

TEST(Reception, IsJudgedByRejects) {
  EXPECT_EQ(judge(rejecting(9), FrameKind::cloud).health, Health::ok);
  EXPECT_EQ(judge(rejecting(10), FrameKind::cloud).health, Health::warn);
  EXPECT_EQ(judge(rejecting(989), FrameKind::cloud).health, Health::warn);
  EXPECT_EQ(judge(rejecting(990), FrameKind::cloud).health, Health::error);
  EXPECT_EQ(judge(rejecting(1000), FrameKind::cloud).figures, "100 % of packets rejected: 1000 (size 1000)");
  EXPECT_EQ(judge(rejecting(99, Reject::duplicate), FrameKind::cloud).health, Health::ok);
  EXPECT_EQ(judge(rejecting(100, Reject::duplicate), FrameKind::cloud).health, Health::warn);
}

TEST(Reception, WithoutAFrameIsAnErrorAfterTwoSeconds) {
  Reception r = ten_seconds(0);
  r.frames_s = r.expected = 0;
  r.without_frame_s = 1.99;
  EXPECT_EQ(judge(r, FrameKind::cloud).health, Health::ok);
  r.without_frame_s = 2;
  EXPECT_EQ(judge(r, FrameKind::cloud).health, Health::error);
  EXPECT_EQ(judge(r, FrameKind::cloud).figures,
            "0 of 10.0 frames/s, no frame for 2.0 s although packets come");
  r.period_s = 1;
  EXPECT_EQ(judge(r, FrameKind::cloud).health, Health::ok) << "a slow sensor has five periods";
  r.without_frame_s = 5;
  EXPECT_EQ(judge(r, FrameKind::cloud).health, Health::error);
}

TEST(Reception, TellsACoveredSensor) {
  EXPECT_EQ(judge(looking(501, 9499), FrameKind::scan).health, Health::ok);
  EXPECT_EQ(judge(looking(500, 9500), FrameKind::scan).health, Health::warn);
  EXPECT_THAT(judge(looking(500, 9500), FrameKind::scan).figures, HasSubstr("95 % of the beams blind"));
  EXPECT_EQ(judge(looking(1, 0), FrameKind::scan).health, Health::ok) << "a scanner may look into the open";
  EXPECT_EQ(judge(looking(0, 0), FrameKind::scan).health, Health::warn);
  EXPECT_EQ(judge(looking(100, 0), FrameKind::cloud).health, Health::ok);
  EXPECT_EQ(judge(looking(99, 0), FrameKind::cloud).health, Health::warn);
  EXPECT_EQ(judge(looking(20, 379), FrameKind::cloud).health, Health::ok);
  EXPECT_EQ(judge(looking(20, 380), FrameKind::cloud).health, Health::warn);
  Reception young = looking(0, 0);
  young.frames_looked = 9;
  EXPECT_EQ(judge(young, FrameKind::scan).health, Health::ok);
}

/// A sensor and a clock.
struct Stream {
  explicit Stream(double promised_s) : watch(promised_s) {
    scan.reset(2);
    scan.range_max = 10;
    scan.set_hit(0, 5);
  }

  /// Frames every `period_s`; `comes` decides by the frame's number whether it does. Returns the worst
  /// verdict.
  Health run(
      double time_s, double period_s, const std::function<bool(int)>& comes = [](int) { return true; }) {
    Health worst = Health::ok;
    const double begin = time;
    for (int step = 0; time < begin + time_s; time = begin + ++step * tick_s) {
      for (; due <= time; due += period_s) {
        if (!comes(number++)) continue;
        ++counters.packets;
        ++counters.frames;
        scan.stamp = at(due);
        watch.scan(scan);
      }
      watch.advance(at(time), counters);
      verdict = judge(watch.recent(), FrameKind::scan);
      worst = std::max(worst, verdict.health);
    }
    return worst;
  }
  Stamp at(double s) const { return Stamp{1'767'226'643'000'000'000} + span_from_seconds(s + jump_s); }
  void silence(double time_s) {
    for (int i = 0; i < time_s / tick_s; ++i) watch.advance(at(time += tick_s), counters);
    due = time;
  }

  ReceptionWatch watch;
  Counters counters;
  PlanarScan scan;
  ReceptionVerdict verdict;
  double time = 0, due = 0, jump_s = 0;
  int number = 0;
};

struct Rate {
  const char* what;
  double promised_s, actual_s;
};
std::ostream& operator<<(std::ostream& out, const Rate& rate) { return out << rate.what; }
class EveryRate : public testing::TestWithParam<Rate> {};

TEST_P(EveryRate, RaisesNoAlarm) {
  const Rate& rate = GetParam();
  Stream stream(rate.promised_s);
  EXPECT_EQ(stream.run(40, rate.actual_s), Health::ok) << stream.verdict.figures;
  const Reception recent = stream.watch.recent();
  EXPECT_NEAR(recent.frames / recent.frames_s, 1 / rate.actual_s, 0.25 / rate.actual_s);
  EXPECT_NEAR(recent.expected / recent.frames_s, 1 / rate.actual_s, 0.05 / rate.actual_s);
}

INSTANTIATE_TEST_SUITE_P(Reception, EveryRate,
                         testing::Values(Rate{"a VLP-16 at 600 rpm", 0.1, 0.1},
                                         Rate{"a VLP-16 at 300 rpm", 0.1, 0.2},
                                         Rate{"a VLP-16 at 1200 rpm", 0.1, 0.05},
                                         Rate{"a UST-10LX", 0.025, 0.025},
                                         Rate{"a UST-10LX with skip 9", 0.25, 0.25},
                                         Rate{"a SICK at 15 Hz with a model of 50 Hz", 0.02, 1 / 15.0},
                                         Rate{"a SICK that sends every fifth scan", 1 / 15.0, 5 / 15.0},
                                         Rate{"a microScan3 that sends every second scan", 0.03, 0.06}),
                         [](const auto& of) {
                           std::string name = of.param.what;
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return std::isalnum(c) == 0; }, '_');
                           return name;
                         });

TEST(ReceptionWatch, TellsThatAQuarterOfTheScansIsMissing) {
  Stream stream(0.025);
  EXPECT_EQ(stream.run(20, 0.025, [](int i) { return i % 4 != 0; }), Health::warn);
  EXPECT_THAT(stream.verdict.figures, testing::MatchesRegex("(29.9|30.0|30.1) of 40.0 frames/s"));
}

TEST(ReceptionWatch, KnowsTheRateOfAScannerThatABusyComputerReadsInBursts) {
  constexpr double turn_s = 1 / 14.4;
  ReceptionWatch watch(1 / 14.5);
  Stream stream(1 / 14.5);
  stream.scan.scan_time = static_cast<float>(turn_s);
  double read_s = 0;
  for (int i = 0; i < 300; ++i) {
    // Three scans are read at once, and their stamps are drawn together.
    const double sent_s = i * turn_s, burst_s = (i - i % 3) * turn_s;
    stream.scan.stamp = stream.at(burst_s + 0.65 * (sent_s - burst_s));
    if (i % 3 == 0) read_s = sent_s;
    ++stream.counters.packets, ++stream.counters.frames;
    watch.scan(stream.scan);
    watch.advance(stream.at(read_s), stream.counters);
    const ReceptionVerdict verdict = judge(watch.recent(), FrameKind::scan);
    EXPECT_EQ(verdict.health, Health::ok) << i << ": " << verdict.figures;
  }
  const Reception recent = watch.recent();
  EXPECT_NEAR(recent.expected / recent.frames_s, 14.4, 0.4);
  EXPECT_NEAR(recent.frames / recent.frames_s, 14.4, 0.4);
}

TEST(ReceptionWatch, FollowsAMotorThatIsSetToAnotherRate) {
  Stream stream(0.1);
  EXPECT_EQ(stream.run(20, 0.1), Health::ok);
  EXPECT_EQ(stream.run(20, 0.2), Health::ok) << stream.verdict.figures;
  EXPECT_EQ(stream.run(20, 0.05), Health::ok) << stream.verdict.figures;
}

TEST(ReceptionWatch, ExpectsNoRateThatNoSensorHas) {
  Stream stream(0.1);
  stream.run(5, 0.1);
  // What waited somewhere comes in a rush, with stamps that lie nanoseconds apart.
  for (int i = 0; i < 3000; ++i) {
    stream.scan.stamp = stream.scan.stamp + Span(3);
    ++stream.counters.frames, ++stream.counters.packets;
    stream.watch.scan(stream.scan);
    if (i % 100 == 0) stream.watch.advance(stream.at(stream.time += tick_s), stream.counters);
  }
  const Reception recent = stream.watch.recent();
  EXPECT_LT(recent.expected, 100 * recent.watched_s);
  EXPECT_THAT(judge(recent, FrameKind::scan).figures, Not(HasSubstr("frames/s")));
}

TEST(ReceptionWatch, ForgetsAnOldLossAfterTenSeconds) {
  Stream stream(0.025);
  stream.run(20, 0.025);
  stream.counters.lost_packets = 100;
  EXPECT_EQ(stream.run(0.1, 0.025), Health::error);
  stream.run(9.5, 0.025);
  EXPECT_EQ(stream.verdict.health, Health::error);
  stream.run(2, 0.025);
  EXPECT_EQ(stream.verdict.health, Health::ok) << stream.verdict.figures;
  EXPECT_EQ(stream.watch.whole().lost(), 100U);
}

TEST(ReceptionWatch, TakesNoJumpOfTheClockForLostFrames) {
  for (const double jump_s : {3600.0, -3600.0, 1.5, -1.5, -0.005, 1e8, -1e8}) {
    Stream stream(0.1);
    EXPECT_EQ(stream.run(15, 0.1), Health::ok);
    stream.jump_s = jump_s;
    EXPECT_EQ(stream.run(15, 0.1), Health::ok) << jump_s << ": " << stream.verdict.figures;
  }
}

TEST(ReceptionWatch, SeesFramesStopWhilePacketsCome) {
  Stream stream(0.1);
  stream.run(15, 0.1);
  for (int i = 0; i < 185; ++i) {
    ++stream.counters.packets;
    stream.watch.advance(stream.at(stream.time += tick_s), stream.counters);
  }
  EXPECT_EQ(judge(stream.watch.recent(), FrameKind::cloud).health, Health::warn) << "19 of 100 are missing";
  for (int i = 0; i < 30; ++i) {
    ++stream.counters.packets;
    stream.watch.advance(stream.at(stream.time += tick_s), stream.counters);
  }
  EXPECT_THAT(judge(stream.watch.recent(), FrameKind::cloud).figures,
              HasSubstr("0 of 10.0 frames/s, no frame for 2."));
}

TEST(ReceptionWatch, WaitsForTheEndOfADialogue) {
  ReceptionWatch watch(0.025);
  Counters counters;
  Stamp now{1'767'226'643'000'000'000};
  for (int i = 0; i < 600; ++i) {
    ++counters.other_packets;
    watch.advance(now = now + std::chrono::milliseconds(10), counters);
    EXPECT_EQ(judge(watch.recent(), FrameKind::scan).health, Health::ok) << "answers alone promise no frame";
  }
  for (int i = 0; i < 250; ++i) {
    ++counters.packets;
    watch.advance(now = now + std::chrono::milliseconds(10), counters);
  }
  EXPECT_EQ(judge(watch.recent(), FrameKind::scan).health, Health::error);
}

TEST(ReceptionWatch, BeginsAnewAfterASilenceThatWasAnErrorWhileAShorterOneCounts) {
  Stream stream(0.025);
  stream.run(15, 0.025);
  stream.silence(3.1);
  EXPECT_EQ(stream.run(12, 0.025), Health::ok) << "that silence was reported as an error while it lasted";
  stream.silence(1.5);
  EXPECT_EQ(stream.run(5, 0.025), Health::warn) << "a loose plug";
  EXPECT_THAT(stream.verdict.figures, HasSubstr("of 40.0 frames/s"));
  stream.run(7, 0.025);
  EXPECT_EQ(stream.verdict.health, Health::ok) << stream.verdict.figures;
}

TEST(ReceptionWatch, WhatWasLostInASilenceIsNotToldAgainAfterIt) {
  Stream stream(0.1);
  stream.run(15, 0.1);
  stream.silence(4);
  stream.run(0.1, 0.1);
  stream.counters.lost_packets = 3000;  // with the first frame that is complete
  EXPECT_EQ(stream.run(12, 0.1), Health::ok) << stream.verdict.figures;
  EXPECT_EQ(stream.watch.whole().lost(), 3000U);
  stream.counters.lost_packets = 3100;
  EXPECT_EQ(stream.run(1, 0.1), Health::error) << "what is lost later is told";
}

TEST(ReceptionWatch, BeginsAnewWithAReplay) {
  Stream stream(0.025);
  for (int loop = 0; loop < 20; ++loop) {
    stream.silence(0.3);
    EXPECT_EQ(stream.run(1.5, 0.025), Health::ok) << stream.verdict.figures;
    stream.watch.restart();
  }
}

TEST(ReceptionWatch, NamesSendersThatSendAtTheSameTime) {
  const IpAddress one = IpAddress::v4(192, 168, 1, 201), two = IpAddress::v4(192, 168, 1, 202);
  const auto send = [&](Stream& stream, double time_s, int of_one, int of_two) {
    for (int i = 0; i < time_s / tick_s; ++i) {
      for (int n = 0; n < of_one; ++n) stream.watch.sender(one);
      for (int n = 0; n < of_two; ++n) stream.watch.sender(two);
      stream.counters.packets += static_cast<unsigned>(of_one + of_two);
      stream.watch.advance(stream.at(stream.time += tick_s), stream.counters);
    }
    return rivals_text(stream.watch.recent(), 2368);
  };
  Stream both(0.1);
  EXPECT_EQ(
      send(both, 1, 7, 7),
      "192.168.1.201 and 192.168.1.202 both send to port 2368; one entry takes one sensor: set ip_address: "
      "192.168.1.201 here, and give each other sensor an entry of its own");
  EXPECT_EQ(send(both, 12, 7, 0), "") << "one was switched off";
  EXPECT_THAT(rivals_text(both.watch.whole(), 2368), HasSubstr("both send"));
  Stream moved(0.1);
  send(moved, 5.5, 7, 0);
  EXPECT_EQ(send(moved, 5, 0, 7), "") << "a sensor whose address changed";
  Stream stray(0.1);
  for (int i = 0; i < 9; ++i) {
    send(stray, 0.5, 7, 0);
    EXPECT_EQ(send(stray, 0.01, 0, 1), "") << "a packet astray is no sensor";
  }
}

}  // namespace
}  // namespace lidard
