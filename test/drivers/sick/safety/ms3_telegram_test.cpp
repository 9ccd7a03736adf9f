// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/ms3_telegram.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "test/drivers/sick/safety/ms3_encoder.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;

/// What parse() was given last.
Bytes& parsed_bytes() {
  static Bytes kept;
  return kept;
}

/// The views of `t` stay valid until the next call.
Reject parse(Bytes bytes, Ms3Telegram& t) {
  Bytes& kept = parsed_bytes();
  kept = std::move(bytes);
  return parse_ms3_telegram(ByteView(kept.data(), kept.size()), t);
}

/// SICK 8022708 p. 55, table 64, from the data header to the eleventh beam; what the manual leaves out is
/// zero.
Bytes printed_telegram() {
  Bytes bytes = {0x52, 0x02, 0x00, 0x00, 0x6d, 0xb5, 0x0a, 0x01, 0x8c, 0x8f, 0x0a, 0x01, 0x00, 0x00, 0x00,
                 0x00, 0x61, 0x02, 0x00, 0x00, 0x7c, 0x02, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xd4, 0x58,
                 0x00, 0x00, 0x4c, 0x00, 0x10, 0x00, 0x60, 0x00, 0x18, 0x00, 0x7c, 0x00, 0xc4, 0x00, 0x44,
                 0x01, 0x90, 0x00, 0xd8, 0x01, 0x08, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
                 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00,
                 0x00, 0x01, 0x55, 0x00, 0x00, 0xff, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00,
                 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x00, 0x30, 0x00, 0x1e, 0x00, 0x00, 0x00, 0xc0,
                 0x2d, 0x5c, 0xfd, 0xf8, 0xd5, 0x20, 0x00, 0x2b, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
                 0x01, 0x00, 0x00, 0x00, 0x30, 0x00, 0x00, 0x00, 0x80, 0x05, 0x1a, 0x01, 0x83, 0x05, 0x1a,
                 0x01, 0x83, 0x05, 0x1a, 0x01, 0x86, 0x05, 0x1a, 0x01, 0x85, 0x05, 0x1a, 0x01, 0x85, 0x05,
                 0x1a, 0x01, 0x88, 0x05, 0x1a, 0x01, 0x88, 0x05, 0x1a, 0x01, 0x8c, 0x05, 0x1a, 0x01, 0x8d,
                 0x05, 0x1a, 0x01, 0x90, 0x05, 0x1a, 0x01};
  bytes.resize(0x1d8 + 0x108);
  return bytes;
}

TEST(Ms3Telegram, DecodesTheTelegramPrintedInTheManual) {
  const Bytes bytes = printed_telegram();
  // The CoLa 2 length of table 64 is 0x2f0, 12 of it before the telegram.
  ASSERT_LE(bytes.size(), 0x2f0U - 12U);
  Ms3Telegram t;
  ASSERT_EQ(parse(bytes, t), Reject::none);
  EXPECT_EQ(t.serial, 17479021U);
  EXPECT_EQ(t.sequence, 0x261U);
  EXPECT_EQ(t.scan, 0x27cU);
  ASSERT_TRUE(t.state);
  EXPECT_TRUE(t.state->run_mode);
  EXPECT_FALSE(t.state->standby);
  EXPECT_EQ(t.state->safe_paths, 0x55U);
  EXPECT_EQ(t.state->non_safe_paths, 0xffU);
  EXPECT_EQ(t.state->monitoring_case[0], 1);
  ASSERT_TRUE(t.derived);
  EXPECT_EQ(t.derived->factor, 1);
  EXPECT_EQ(t.derived->beams, 48);
  EXPECT_EQ(t.derived->scan_time_ms, 30);
  EXPECT_NEAR(t.derived->start_deg, -10.5597, 5e-5);
  EXPECT_NEAR(t.derived->step_deg, 0.51306, 5e-6);
  EXPECT_EQ(t.derived->beam_period_us, 43U);
  ASSERT_EQ(t.beams(), 48U);
  EXPECT_EQ(t.beam(0).distance, 1408);
  EXPECT_EQ(t.beam(0).reflectivity, 26);
  EXPECT_EQ(t.beam(0).status, 1);
  EXPECT_EQ(t.beam(10).distance, 1424);
  EXPECT_TRUE(t.application);
}

TEST(Ms3Telegram, EncoderAgreesWithTheManual) {
  const Ms3Sample sample;
  const Bytes made = sample.instance(), printed = printed_telegram();
  EXPECT_TRUE(std::equal(made.begin(), made.begin() + 36, printed.begin()));
  EXPECT_TRUE(std::equal(made.begin() + 76, made.begin() + 92, printed.begin() + 76));
}

TEST(Ms3Telegram, DecodesEveryBlock) {
  Ms3Sample sample;
  sample.channel = 3;
  sample.with_local_io = true;
  sample.state_flags = 0x2a;
  sample.errors = 2;
  sample.safe_paths = 0x80001;
  sample.non_safe_paths = 0xabcde;
  sample.reset_paths = 0x12345;
  sample.cases = {{9, 8, 7, 6}};
  sample.intrusion[0] = Bytes(6, 0);
  sample.intrusion[7] = {0, 0, 1, 0, 0, 0};
  sample.standby_state = 1;
  Ms3Telegram t;
  ASSERT_EQ(parse(sample.instance(), t), Reject::none);
  EXPECT_EQ(t.channel, 3);
  EXPECT_EQ(t.plug_serial, 17469324U);
  EXPECT_FALSE(t.state->run_mode);
  EXPECT_TRUE(t.state->standby);
  EXPECT_FALSE(t.state->contamination_warning);
  EXPECT_TRUE(t.state->contamination_error);
  EXPECT_FALSE(t.state->reference_contour);
  EXPECT_TRUE(t.state->manipulation);
  EXPECT_FALSE(t.state->application_error);
  EXPECT_TRUE(t.state->device_error);
  EXPECT_EQ(t.state->safe_paths, 0x80001U);
  EXPECT_EQ(t.state->non_safe_paths, 0xabcdeU);
  EXPECT_EQ(t.state->reset_required_paths, 0x12345U);
  EXPECT_EQ(t.state->monitoring_case, (std::array<std::uint8_t, 4>{{9, 8, 7, 6}}));
  EXPECT_FALSE(t.is_intruded(0));
  EXPECT_TRUE(t.is_intruded(7));
  EXPECT_FALSE(t.is_intruded(23));
  EXPECT_FALSE(t.has_unreadable_block);
}

TEST(Ms3Telegram, DecodesApplicationData) {
  Ms3Telegram t;
  Ms3Sample sample;
  sample.standby_state = 1;
  const Bytes bytes = sample.instance();
  ASSERT_EQ(parse(bytes, t), Reject::none);
  ASSERT_TRUE(t.application);
  const Ms3Application& a = *t.application;
  EXPECT_EQ(a.evaluation_paths, 0x11U);
  EXPECT_EQ(a.evaluation_safe, 1U);
  EXPECT_EQ(a.evaluation_valid, 0xfffU);
  EXPECT_EQ(a.cases[0], 1);
  EXPECT_EQ(a.cases[19], 219);
  EXPECT_EQ(a.standby_state, 1);
  EXPECT_EQ(a.valid_flags, 3);
}

TEST(Ms3Telegram, BlocksMayBeSwitchedOff) {
  Ms3Sample sample;
  sample.with_state = sample.with_derived = sample.with_measurement = false;
  sample.with_intrusion = sample.with_application = false;
  Ms3Telegram t;
  ASSERT_EQ(parse(sample.instance(), t), Reject::none);
  EXPECT_FALSE(t.state || t.derived || t.application || t.has_measurement);
  EXPECT_EQ(t.beams(), 0U);
}

TEST(Ms3Telegram, EmptyMeasurementIsNoMeasurement) {
  Ms3Sample sample;
  sample.beams.clear();
  sample.announced_beams = 48;
  Ms3Telegram t;
  EXPECT_EQ(parse(sample.instance(), t), Reject::none);
  EXPECT_FALSE(t.has_measurement);
}

TEST(Ms3Telegram, RefusesOtherVersionsAndShortTelegrams) {
  Ms3Telegram t;
  Ms3Sample sample;
  sample.indicator = 0;
  EXPECT_EQ(parse(sample.instance(), t), Reject::field);
  sample.indicator = 'R';
  sample.major = 3;
  EXPECT_EQ(parse(sample.instance(), t), Reject::version);
  EXPECT_EQ(parse(Bytes(75, 1), t), Reject::size);
  EXPECT_EQ(parse({}, t), Reject::size);
}

TEST(Ms3Telegram, RefusesCutTelegrams) {
  const Bytes whole = Ms3Sample().instance();
  for (std::size_t size = 0; size + 4 < whole.size(); ++size) {
    Ms3Telegram t;
    ASSERT_NE(parse(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), t), Reject::none)
        << size;
  }
}

TEST(Ms3Telegram, RefusesImpossibleGeometry) {
  const auto verdict = [](auto change) {
    Ms3Sample sample;
    change(sample);
    Ms3Telegram t;
    return parse(sample.instance(), t);
  };
  EXPECT_EQ(verdict([](Ms3Sample&) {}), Reject::none);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.factor = 0; }), Reject::field);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.scan_time_ms = 0; }), Reject::field);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.scan_time_ms = 60'000; }), Reject::field);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.step = 0; }), Reject::field);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.step = 0x7fffffff; }), Reject::field);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.step = -0x7fffffff; }), Reject::field);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.start = 0x7fffffff; }), Reject::field);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.period_us = 0xffffffffU; }), Reject::field);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.announced_beams = 47; }), Reject::field);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.announced_beams = 0; }), Reject::field);
  EXPECT_EQ(verdict([](Ms3Sample& s) { s.step = -s.step; }), Reject::none);
}

TEST(Ms3Telegram, BlockInsideTheHeaderIsALie) {
  Bytes bytes = Ms3Sample().instance();
  bytes[40] = 10;
  Ms3Telegram t;
  EXPECT_EQ(parse(bytes, t), Reject::field);
}

TEST(Ms3Telegram, ShortStatusBlockCostsNoScan) {
  Bytes bytes = Ms3Sample().instance();
  bytes[50] = 200;  // size of the application data
  bytes[51] = 0;
  Ms3Telegram t;
  ASSERT_EQ(parse(bytes, t), Reject::none);
  EXPECT_FALSE(t.application);
  EXPECT_TRUE(t.has_unreadable_block);
  EXPECT_EQ(t.beams(), 48U);
}

/// Every view must lie inside the telegram, whatever was parsed.
/// All that a telegram refers to lies in the bytes that it was read from, and fits together.
void expect_within(const Ms3Telegram& t) {
  const Bytes& bytes = parsed_bytes();
  const auto within = [&](const ByteView& view) {
    if (view.size() == 0) return true;
    const std::uint8_t* const end = bytes.data() + bytes.size();
    return view.data() >= bytes.data() && view.data() <= end &&
           view.size() <= static_cast<std::size_t>(end - view.data());
  };
  ASSERT_TRUE(within(t.beam_bytes));
  for (std::size_t path = 0; path < t.intrusion.size(); ++path) {
    ASSERT_TRUE(within(t.intrusion[path])) << path;
    const bool any = std::any_of(t.intrusion[path].begin(), t.intrusion[path].end(),
                                 [](std::uint8_t byte) { return byte != 0; });
    EXPECT_EQ(t.is_intruded(path), any) << path;
  }
  EXPECT_EQ(t.beam_bytes.size() % 4, 0U);
  if (!t.has_measurement) {
    EXPECT_EQ(t.beams(), 0U);
  }
}

TEST(Ms3Telegram, SurvivesExtremeValuesInEveryField) {
  Ms3Sample sample;
  sample.with_local_io = true;
  sample.intrusion[3] = Bytes(6, 1);
  const Bytes whole = sample.instance();
  int refused = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const std::uint32_t value : {0U, 1U, 0x7fU, 0x80U, 0xffU, 0x7fffU, 0x8000U, 0xffffU, 0x7fffffffU,
                                      0x80000000U, 0xfffffff0U, 0xffffffffU}) {
      for (const std::size_t width : {1U, 2U, 4U}) {
        Bytes bytes = whole;
        for (std::size_t i = 0; i < width && at + i < bytes.size(); ++i)
          bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
        Ms3Telegram t;
        if (parse(bytes, t) != Reject::none) {
          ++refused;
        } else {
          expect_within(t);
        }
      }
    }
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace lidard::sick
