// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "test/drivers/capture/pcap_testing.h"
#include "test/sim/devices/cola_telegram.h"
#include "test/sim/world/rng.h"

namespace lidard::test {
namespace {

using sick::ColaDialect;
using sick::ColaStream;
using sick::ColaTelegram;
using sim::Cola;
using sim::ColaWords;
using ::testing::ElementsAre;

Bytes number(Cola dialect, unsigned value) { return ColaWords(dialect, "sSN N").number(value, 4).bytes(); }
Bytes of(const std::string& text) { return {text.begin(), text.end()}; }

/// Reads streams and keeps the payloads of the telegrams.
struct Reading {
  Counters counters;
  ColaStream stream{counters};
  std::vector<std::string> found;

  Reading& add(const Bytes& bytes) {
    stream.add({bytes.data(), bytes.size()});
    ColaTelegram telegram;
    while (stream.next(telegram)) found.emplace_back(telegram.payload.text());
    return *this;
  }
};

TEST(ColaStream, FindsTelegramsOfBothDialectsInOneStream) {
  Reading reading;
  reading.add(of("\x02sRA A 1\x03") + ColaWords(Cola::binary, "sRA B").bytes() + of("\x02sFA 4\x03"));
  EXPECT_THAT(reading.found, ElementsAre("sRA A 1", "sRA B", "sFA 4"));
  EXPECT_EQ(reading.counters.rejected_total(), 0U);
  EXPECT_EQ(reading.counters.incomplete, 0U);
}

TEST(ColaStream, NamesKindNameAndArguments) {
  Counters counters;
  ColaStream stream(counters);
  const Bytes bytes = of("\x02sSN LMDscandata 1 2\x03\x02sFA 4\x03\x02sWA X\x03");
  stream.add({bytes.data(), bytes.size()});
  ColaTelegram t;
  ASSERT_TRUE(stream.next(t));
  EXPECT_EQ(t.dialect, ColaDialect::a);
  EXPECT_EQ(t.kind(), "sSN");
  EXPECT_EQ(t.name(), "LMDscandata");
  EXPECT_EQ(t.arguments().text(), "1 2");
  ASSERT_TRUE(stream.next(t));
  EXPECT_EQ(t.kind(), "sFA");
  ASSERT_TRUE(stream.next(t));
  EXPECT_EQ(t.name(), "X");
  EXPECT_TRUE(t.arguments().empty());
}

TEST(ColaStream, FindsTheNextTelegramWhenItJoinsInTheMiddle) {
  const Bytes first = number(Cola::binary, 0x02020202);
  const Bytes all = first + number(Cola::binary, 2) + of("\x02sSN N 3\x03");
  for (std::size_t skip = 1; skip < first.size(); ++skip) {
    Reading reading;
    reading.add({all.begin() + static_cast<std::ptrdiff_t>(skip), all.end()});
    EXPECT_EQ(reading.found.size(), 2U) << "joined at " << skip;
    EXPECT_EQ(reading.counters.incomplete, 1U);
    EXPECT_EQ(reading.counters.rejected_total(), 0U);
  }
}

TEST(ColaStream, ADamagedLengthCostsOneTelegramOnly) {
  for (const std::size_t at : {4U, 5U, 6U, 7U}) {
    Bytes damaged = number(Cola::binary, 7);
    damaged[at] ^= 0x01U;
    Reading reading;
    reading.add(damaged);
    for (unsigned i = 0; i < 20000; ++i) reading.add(number(Cola::binary, i));
    // A length that grew by 64 KiB swallows that much before its checksum shows the lie.
    EXPECT_EQ(reading.found.size(), 20000U) << "byte " << at;
    EXPECT_GE(reading.counters.rejected_total() + reading.counters.incomplete, 1U);
  }
}

TEST(ColaStream, CountsARowOfForeignBytesOnce) {
  Reading reading;
  reading.add(number(Cola::binary, 1) + of("GET / HTTP/1.1\r\n\r\n") + number(Cola::binary, 2));
  EXPECT_EQ(reading.found.size(), 2U);
  EXPECT_EQ(reading.counters.rejected[static_cast<std::size_t>(Reject::magic)], 1U);
}

TEST(ColaStream, WaitsForNoTelegramThatIsTooLong) {
  Reading reading;
  Bytes text = of("\x02sSN ");
  text.resize(ColaStream::longest + 100, 'A');
  reading.add(text).add(of("\x03") + number(Cola::binary, 1));
  EXPECT_EQ(reading.found.size(), 1U);
  Reading binary;
  binary.add(Bytes{2, 2, 2, 2, 0, 4, 0, 1, 's', 'S', 'N', ' '} + number(Cola::binary, 1));
  EXPECT_EQ(binary.found.size(), 1U);
}

TEST(ColaStream, SurvivesDamageAnywhereAndFindsWhatWasNotHit) {
  Bytes all;
  for (unsigned i = 0; i < 4; ++i) all = all + number(Cola::binary, i) + number(Cola::text, i);
  const Bytes end = Bytes(ColaStream::longest + 16, 0) + number(Cola::binary, 99);
  sim::Rng random(7);
  for (int trial = 0; trial < 300; ++trial) {
    Bytes damaged = all;
    damaged[random.bits() % damaged.size()] = static_cast<std::uint8_t>(random.bits());
    Reading reading;
    reading.add(damaged).add(end);
    EXPECT_GE(reading.found.size(), 7U);
    EXPECT_LE(reading.found.size(), 9U);
  }
}

}  // namespace
}  // namespace lidard::test
