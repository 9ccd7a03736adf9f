// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <limits>

#include "test/sim/devices/cola_telegram.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using sick::ColaScan;
using sick::ColaTelegram;
using sim::Cola;
using sim::SickScan;
using ::testing::ElementsAre;
using Bytes = std::vector<std::uint8_t>;

/// The only telegram in these bytes.
struct Single {
  Counters counters;
  sick::ColaStream stream{counters};
  ColaTelegram telegram;

  explicit Single(const Bytes& bytes) {
    stream.add({bytes.data(), bytes.size()});
    EXPECT_TRUE(stream.next(telegram));
    EXPECT_EQ(counters.rejected_total(), 0U);
  }
};

Reject parse(const Bytes& bytes, ColaScan& scan) {
  const Single single(bytes);
  return parse_cola_scan(single.telegram, scan);
}

Bytes read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

SickScan the_lot() {
  SickScan s;
  s.status[0] = 1;
  s.telegram_counter = 0xfffe;
  s.scan_counter = 17;
  s.start_us = 0xdeadbeef;
  s.transmit_us = 0xdeae0000;
  s.inputs[0] = 0x05;
  s.outputs[0] = 0x39;
  s.outputs[1] = 0x02;
  s.layer = -250;
  s.scan_frequency = 1500;
  s.measurement_frequency = 162;
  s.encoders = {{1000, 2}, {0xfffffff0, 65535}};
  s.channels = {{"DIST1", 2, 0, -450000, 3333, true, {0, 1, 500, 65535}},
                {"DIST2", 1, 0.5F, -450000, 3333, true, {9, 8, 7, 6}},
                {"RSSI1", 1, 0, -450000, 3333, false, {1, 2, 254, 255}},
                {"ANGL1", 1, -32768, -450000, 3333, true, {32768, 32769, 32767, 0}}};
  s.position = true;
  s.name = "front left";  // with a blank
  s.comment = "x";
  s.calendar_us = 123'456'789;
  s.event = true;
  return s;
}

class BothDialects : public ::testing::TestWithParam<Cola> {};
INSTANTIATE_TEST_SUITE_P(Cola, BothDialects, ::testing::Values(Cola::text, Cola::binary),
                         [](const auto& each) { return each.param == Cola::binary ? "binary" : "text"; });

TEST_P(BothDialects, EveryFieldOfAFullTelegramIsRead) {
  ColaScan scan;
  ASSERT_EQ(parse(the_lot().bytes(GetParam()), scan), Reject::none);
  EXPECT_EQ(scan.serial, 12345678U);
  EXPECT_THAT(scan.status, ElementsAre(1, 0));
  EXPECT_EQ(scan.telegram_counter, 0xfffe);
  EXPECT_EQ(scan.scan_counter, 17);
  EXPECT_EQ(scan.start_us, 0xdeadbeefU);
  EXPECT_EQ(scan.transmit_us, 0xdeae0000U);
  EXPECT_EQ(scan.layer, -250);
  EXPECT_DOUBLE_EQ(scan.scan_hz, 15);
  EXPECT_DOUBLE_EQ(scan.measurement_hz, 16200);
  ASSERT_EQ(scan.encoder_count, 2U);
  EXPECT_EQ(scan.encoders[0].position, 1000);
  EXPECT_EQ(scan.encoders[1].position, -16) << "backwards through zero";
  EXPECT_EQ(scan.encoders[1].speed, -1);
  ASSERT_EQ(scan.channel_count, 4U);
  EXPECT_EQ(scan.echo_count(), 2U);
  const sick::ColaChannel* distance = scan.channel("DIST1");
  ASSERT_NE(distance, nullptr);
  EXPECT_THAT(distance->values, ElementsAre(0, 1, 500, 65535));
  EXPECT_DOUBLE_EQ(distance->value(3), 131070);
  EXPECT_DOUBLE_EQ(distance->start_deg, -45);
  EXPECT_DOUBLE_EQ(distance->step_deg, 0.3333);
  EXPECT_DOUBLE_EQ(scan.channel("DIST2")->value(0), 9.5);
  EXPECT_THAT(scan.channel("RSSI1")->values, ElementsAre(1, 2, 254, 255));
  EXPECT_FALSE(scan.channel("RSSI1")->wide);
  EXPECT_DOUBLE_EQ(scan.channel("ANGL1")->value(2), -1);
  EXPECT_EQ(scan.channel("RSSI2"), nullptr);
}

TEST_P(BothDialects, TheNameBehindTheChannelsIsRead) {
  ColaScan scan;
  ASSERT_EQ(parse(the_lot().bytes(GetParam()), scan), Reject::none);
  EXPECT_EQ(scan.name(), "front left");
}

TEST_P(BothDialects, ATelegramCutAnywhereIsRejected) {
  SickScan whole = the_lot();
  whole.event = false;
  const Bytes bytes = whole.bytes(GetParam());
  const std::size_t head = GetParam() == Cola::binary ? 8 : 1;
  const ByteView payload(bytes.data() + head, bytes.size() - head - 1);
  const auto dialect = GetParam() == Cola::binary ? sick::ColaDialect::b : sick::ColaDialect::a;
  ColaScan scan;
  // The last field is one that old firmware leaves out; before it stands a number that stays one when its
  // last digits are cut off.
  const std::size_t end = payload.size() - (GetParam() == Cola::text ? 7 : 2);
  for (std::size_t size = 4; size < end; ++size) {
    EXPECT_NE(parse_cola_scan({dialect, payload.sub(0, size)}, scan), Reject::none) << size;
  }
  EXPECT_EQ(parse_cola_scan({dialect, payload}, scan), Reject::none);
}

TEST_P(BothDialects, ImpossibleCountsAreRejected) {
  ColaScan scan;
  SickScan many = the_lot();
  many.encoders.assign(5, {1, 1});
  EXPECT_EQ(parse(many.bytes(GetParam()), scan), Reject::field);
  many = the_lot();
  many.channels.assign(25, {"DIST1", 1, 0, 0, 5000, true, {1}});
  EXPECT_EQ(parse(many.bytes(GetParam()), scan), Reject::field);
  many = the_lot();
  many.channels = {{"DIST1", 1, 0, 0, 5000, true, std::vector<std::uint16_t>(20000)}};
  EXPECT_EQ(parse(many.bytes(GetParam()), scan), Reject::field);
}

TEST(ColaScan, TextNumbersMayBeDecimalWithASign) {
  ColaScan scan;
  std::string text =
      "sSN LMDscandata 1 1 89A27F 0 0 +343 +347 271FF0 271FF1 0 0 7 0 -5 +5000 168 0 1 DIST1 3F800000 "
      "00000000 -450000 1388 +3 10 +17 12 0 0 0 0 0 0";
  ASSERT_EQ(parse_cola_scan({sick::ColaDialect::a, ByteView(text)}, scan), Reject::none);
  EXPECT_EQ(scan.telegram_counter, 343);
  EXPECT_EQ(scan.layer, -5);
  EXPECT_DOUBLE_EQ(scan.channel("DIST1")->start_deg, -45);
  EXPECT_THAT(scan.channel("DIST1")->values, ElementsAre(16, 17, 18));
  for (const char* bad : {"+ABC", "G", "123456789AB", "-", ""}) {
    std::string wrong = text;
    wrong.replace(wrong.find("89A27F"), 6, bad);
    EXPECT_NE(parse_cola_scan({sick::ColaDialect::a, ByteView(wrong)}, scan), Reject::none) << bad;
  }
}

TEST(ColaScan, ScalesThatAreNoNumbersAreRejected) {
  ColaScan scan;
  SickScan s = the_lot();
  s.channels[0].scale = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(parse(s.bytes(Cola::binary), scan), Reject::field);
  EXPECT_EQ(parse(s.bytes(Cola::text), scan), Reject::field);
}

TEST(ColaScan, RealTextTelegramOfATim) {
  LIDARD_NEED_CAPTURE(path, "sick/tim_sRA_LMDscandata_colaA.bin");
  ColaScan scan;
  ASSERT_EQ(parse(read_file(path), scan), Reject::none);
  EXPECT_EQ(scan.serial, 0x10A719EU);
  EXPECT_EQ(scan.telegram_counter, 0x20F9);
  EXPECT_EQ(scan.start_us, 0x26C0C24AU);
  EXPECT_DOUBLE_EQ(scan.scan_hz, 15);
  ASSERT_EQ(scan.channel_count, 1U);
  const sick::ColaChannel* distance = scan.channel("DIST1");
  ASSERT_EQ(distance->values.size(), 811U);
  EXPECT_DOUBLE_EQ(distance->start_deg, -45);
  EXPECT_EQ(distance->values[0], 0x87B);
  EXPECT_EQ(distance->values[1], 0x88D);
}

struct Known {
  const char* file;
  std::vector<std::pair<std::string, std::size_t>> channels;
  std::size_t encoders;
  const char* name;
};

TEST(ColaScan, RealTelegramsOfAnLms151) {
  const std::vector<Known> all = {
      {"sick/lms151_16bit_rssi_name_time.bin", {{"DIST1", 9}, {"RSSI1", 9}}, 0, "not defined"},
      {"sick/lms151_8bit_rssi_encoder_time.bin", {{"DIST1", 2}, {"RSSI1", 2}}, 1, ""},
      {"sick/lms151_8bit_rssi_time.bin", {{"DIST1", 2}, {"RSSI1", 2}}, 0, ""},
      {"sick/lms151_the_lot.bin",
       {{"DIST1", 41}, {"DIST2", 41}, {"RSSI1", 41}, {"RSSI2", 41}},
       1,
       "LMS151 Test"},
      {"sick/doc_lms151_sRA.bin", {{"DIST1", 21}}, 0, ""}};
  for (const Known& known : all) {
    LIDARD_NEED_CAPTURE(path, known.file);
    ColaScan scan;
    ASSERT_EQ(parse(read_file(path), scan), Reject::none) << known.file;
    ASSERT_EQ(scan.channel_count, known.channels.size());
    for (std::size_t i = 0; i < known.channels.size(); ++i) {
      EXPECT_EQ(scan.channels[i].name(), known.channels[i].first);
      EXPECT_EQ(scan.channels[i].values.size(), known.channels[i].second);
    }
    EXPECT_EQ(scan.encoder_count, known.encoders);
    EXPECT_EQ(scan.name(), known.name);
  }
}

TEST(ColaEvents, FieldEvaluationOfATim781s) {
  // As recorded: field 1 and 2 infringed, field 3 free, with dates.
  const auto field = [](sim::ColaWords& out, std::uint32_t number, std::uint32_t result) {
    out.number(1, 2).number(number, 1).number(0, 4).real(1).real(0).number(3333, 4).number(0xfff92230, 4);
    out.number(result, 1).number(0, 2).number(0, 2).number(0, 2).number(1, 2).number(1970, 2);
    for (int i = 0; i < 5; ++i) out.number(1, 1);
    out.number(765880, 4);
  };
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    sim::ColaWords words(dialect, "sSN LFErec");
    words.number(3, 2);
    field(words, 1, 2), field(words, 2, 2), field(words, 3, 1);
    const Single single(words.bytes());
    sick::ColaFields fields;
    ASSERT_EQ(parse_cola_fields(single.telegram, fields), Reject::none);
    ASSERT_EQ(fields.count, 3U);
    EXPECT_EQ(fields.fields[1].number, 2);
    EXPECT_EQ(fields.fields[1].result, 2);
    EXPECT_EQ(fields.fields[2].result, 1);
    EXPECT_FALSE(fields.time_us.has_value());
  }
}

TEST(ColaEvents, PinsWithAndWithoutDate) {
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    for (const bool dated : {true, false}) {
      sim::ColaWords out(dialect, "sSN LIDoutputstate"), in(dialect, "sSN LIDinputstate");
      out.number(0, 2).number(0x52cbc00a, 4).number(1, 1).number(0x8d, 4).number(2, 1).number(0, 4);
      in.number(0, 2).number(0, 4).number(0, 1).number(1, 1).number(0, 1).number(2, 1);
      for (sim::ColaWords* words : {&out, &in}) {
        words->number(dated ? 1 : 0, 2);
        if (!dated) continue;
        words->number(1970, 2);
        for (int i = 0; i < 5; ++i) words->number(0, 1);
        words->number(5, 4);
      }
      sick::ColaPins pins;
      ASSERT_EQ(parse_cola_outputs(Single(out.bytes()).telegram, pins), Reject::none) << dated;
      ASSERT_EQ(pins.count, 2U);
      EXPECT_EQ(pins.pins[0].state, 1);
      EXPECT_EQ(pins.pins[0].count, 0x8dU);
      EXPECT_EQ(pins.time_us, 0x52cbc00aU);
      ASSERT_EQ(parse_cola_inputs(Single(in.bytes()).telegram, pins), Reject::none);
      ASSERT_EQ(pins.count, 4U);
      EXPECT_EQ(pins.pins[1].state, 1);
      EXPECT_EQ(pins.pins[3].state, 2);
    }
  }
}

}  // namespace
}  // namespace lidard::test
