// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "drivers/sick/safety/ms3_telegram.h"
#include "test/drivers/sick/safety/ms3_encoder.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;
using std::chrono::milliseconds;

Bytes numbers(std::size_t size, std::uint8_t first = 0) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), first);
  if (size > 12) bytes[12] = 0;  // the channel
  return bytes;
}

struct Bench {
  Counters counters;
  Ms3Reassembler reassembler{counters};
  Ms3Reassembler::Instance instance;
  Bytes last;
  int completed = 0;

  Reject add(const Bytes& datagram, Stamp arrival = ms3_epoch, std::uint8_t host = 21) {
    const Reject reason = reassembler.add(packet_of(datagram, arrival, host), instance);
    if (!instance.bytes.empty()) {
      ++completed;
      last.assign(instance.bytes.begin(), instance.bytes.end());
    }
    return reason;
  }
};

TEST(Ms3Reassembler, PutsFragmentsTogetherInEveryOrder) {
  const Bytes whole = numbers(4 * 1436 - 700);
  const auto parts = ms3_datagrams(whole, 7);
  ASSERT_EQ(parts.size(), 4U);
  std::array<std::size_t, 4> order{{0, 1, 2, 3}};
  do {
    Bench bench;
    for (std::size_t i = 0; i < order.size(); ++i) {
      EXPECT_EQ(bench.add(parts[order[i]]), Reject::none);
      EXPECT_EQ(bench.completed, i == 3 ? 1 : 0);
    }
    EXPECT_EQ(bench.last, whole);
    EXPECT_EQ(bench.reassembler.open(), 0U);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(Ms3Reassembler, DuplicateNeitherCompletesNorSpoilsAnInstance) {
  const Bytes whole = numbers(3256);
  const auto parts = ms3_datagrams(whole, 331);
  Bench bench;
  EXPECT_EQ(bench.add(parts[0]), Reject::none);
  EXPECT_EQ(bench.add(parts[0]), Reject::duplicate);
  EXPECT_EQ(bench.add(parts[1]), Reject::none);
  EXPECT_EQ(bench.add(parts[1]), Reject::duplicate);
  EXPECT_EQ(bench.completed, 0);
  EXPECT_EQ(bench.add(parts[2]), Reject::none);
  EXPECT_EQ(bench.completed, 1);
  EXPECT_EQ(bench.last, whole);
  for (const Bytes& part : parts) EXPECT_EQ(bench.add(part), Reject::duplicate);
  EXPECT_EQ(bench.completed, 1);
  EXPECT_EQ(bench.reassembler.open(), 0U);
  EXPECT_EQ(bench.counters.incomplete, 0U);
}

TEST(Ms3Reassembler, OverlappingFragmentsCountEachByteOnce) {
  const Bytes whole = numbers(300);
  const auto piece = [&](std::uint32_t from, std::uint32_t to) {
    return ms3_datagram(300, 1, from, Bytes(whole.begin() + from, whole.begin() + to));
  };
  Bench bench;
  EXPECT_EQ(bench.add(piece(0, 200)), Reject::none);
  EXPECT_EQ(bench.add(piece(100, 250)), Reject::none);
  EXPECT_EQ(bench.completed, 0);
  EXPECT_EQ(bench.add(piece(250, 300)), Reject::none);
  EXPECT_EQ(bench.last, whole);
}

TEST(Ms3Reassembler, LostFragmentCostsOneInstanceAndIsCounted) {
  Bench bench;
  const auto first = ms3_datagrams(numbers(3256), 10);
  const auto second = ms3_datagrams(numbers(3256, 9), 11);
  bench.add(first[0]);
  bench.add(first[2]);
  for (const Bytes& part : second) EXPECT_EQ(bench.add(part, ms3_epoch + milliseconds(30)), Reject::none);
  EXPECT_EQ(bench.completed, 1);
  EXPECT_EQ(bench.counters.incomplete, 1U);
  EXPECT_EQ(bench.reassembler.open(), 0U);
  EXPECT_EQ(bench.add(first[1], ms3_epoch + milliseconds(31)), Reject::stale);
  EXPECT_EQ(bench.reassembler.open(), 0U);
  EXPECT_EQ(bench.counters.incomplete, 1U);
}

TEST(Ms3Reassembler, GivesUpAfterTheTimeOfTwoScans) {
  Bench bench;
  bench.reassembler.set_patience(milliseconds(60));
  bench.add(ms3_datagrams(numbers(3256), 10)[0]);
  bench.reassembler.expire(ms3_epoch + milliseconds(60));
  EXPECT_EQ(bench.reassembler.open(), 1U);
  bench.reassembler.expire(ms3_epoch + milliseconds(61));
  EXPECT_EQ(bench.reassembler.open(), 0U);
  EXPECT_EQ(bench.counters.incomplete, 1U);
}

TEST(Ms3Reassembler, GivesUpWhenTheClockGoesBack) {
  Bench bench;
  bench.add(ms3_datagrams(numbers(3256), 10)[0]);
  bench.reassembler.expire(ms3_epoch - std::chrono::hours(1));
  EXPECT_EQ(bench.reassembler.open(), 0U);
}

TEST(Ms3Reassembler, TwoDevicesWithTheSameIdentificationStayApart) {
  Bench bench;
  const Bytes a = numbers(3256, 1), b = numbers(3256, 77);
  const auto parts_a = ms3_datagrams(a, 5), parts_b = ms3_datagrams(b, 5);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(bench.add(parts_a[i], ms3_epoch, 21), Reject::none);
    if (i == 2) {
      EXPECT_EQ(bench.last, a);
    }
    EXPECT_EQ(bench.add(parts_b[i], ms3_epoch, 22), Reject::none);
  }
  EXPECT_EQ(bench.completed, 2);
  EXPECT_EQ(bench.last, b);
  EXPECT_EQ(bench.counters.incomplete, 0U);
}

TEST(Ms3Reassembler, TwoChannelsWithInterleavedIdentificationsStayApart) {
  Bench bench;
  Ms3Sample a, b;
  a.beams.resize(500);
  b.beams.resize(500);
  b.channel = 1;
  const auto parts_a = ms3_datagrams(a.instance(), 9), parts_b = ms3_datagrams(b.instance(), 8);
  ASSERT_EQ(parts_a.size(), 2U);
  bench.add(parts_b[0]);
  bench.add(parts_a[0]);
  bench.add(parts_a[1]);
  EXPECT_EQ(bench.completed, 1);
  bench.add(parts_b[1]);
  EXPECT_EQ(bench.completed, 2);
  EXPECT_EQ(bench.counters.incomplete, 0U);
}

TEST(Ms3Reassembler, IdentificationMayWrap) {
  Bench bench;
  const auto last = ms3_datagrams(numbers(3256), 0xffffffffU);
  const auto wrapped = ms3_datagrams(numbers(3256, 3), 0);
  bench.add(last[0]);
  for (const Bytes& part : wrapped) bench.add(part, ms3_epoch + milliseconds(30));
  EXPECT_EQ(bench.completed, 1);
  EXPECT_EQ(bench.counters.incomplete, 1U);
  EXPECT_EQ(bench.reassembler.open(), 0U);
}

TEST(Ms3Reassembler, MemoryStaysWithinFourInstances) {
  Bench bench;
  std::mt19937 engine(1);
  const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const std::uint32_t total = 2 + random() % 65535;
    bench.add(ms3_datagram(total, random(), random() % (total - 1), Bytes(1, 5)),
              ms3_epoch + milliseconds(i));
    ASSERT_LE(bench.reassembler.open(), Ms3Reassembler::max_open);
  }
  EXPECT_EQ(bench.counters.incomplete + bench.reassembler.open(), 20000U);
}

TEST(Ms3Reassembler, RefusesWhatContradictsItself) {
  const Bytes data(100, 1);
  Bench bench;
  EXPECT_EQ(bench.add({}), Reject::size);
  EXPECT_EQ(bench.add(Bytes(5, 'M')), Reject::size);
  EXPECT_EQ(bench.add(Bytes(1206, 0xff)), Reject::magic);
  EXPECT_EQ(bench.add(ms3_datagram(100, 1, 0, {})), Reject::size);
  EXPECT_EQ(bench.add(ms3_datagram(0, 1, 0, data)), Reject::field);
  EXPECT_EQ(bench.add(ms3_datagram(65537, 1, 0, data)), Reject::field);
  EXPECT_EQ(bench.add(ms3_datagram(0xffffffffU, 1, 0xffffff00U, data)), Reject::field);
  EXPECT_EQ(bench.add(ms3_datagram(99, 1, 0, data)), Reject::field);
  EXPECT_EQ(bench.add(ms3_datagram(200, 1, 101, data)), Reject::field);
  EXPECT_EQ(bench.add(ms3_datagram(200, 1, 200, data)), Reject::field);
  EXPECT_EQ(bench.add(ms3_datagram(200, 1, 0xffffffffU, data)), Reject::field);
  Bytes other = ms3_datagram(200, 1, 0, data);
  other[6] = 2;
  EXPECT_EQ(bench.add(other), Reject::version);
  EXPECT_EQ(bench.reassembler.open(), 0U);
  EXPECT_EQ(bench.completed, 0);
}

TEST(Ms3Reassembler, DifferentTotalInAnInstanceIsRefusedAndTheInstanceSurvives) {
  Bench bench;
  const Bytes whole = numbers(300);
  const auto parts = ms3_datagrams(whole, 4, 150);
  bench.add(parts[0]);
  EXPECT_EQ(bench.add(ms3_datagram(301, 4, 150, Bytes(151, 0))), Reject::field);
  EXPECT_EQ(bench.add(ms3_datagram(1, 4, 0, Bytes(1, 0))), Reject::field);
  EXPECT_EQ(bench.add(parts[1]), Reject::none);
  EXPECT_EQ(bench.last, whole);
}

TEST(Ms3Reassembler, ReadsTheDatagramHeaderPrintedInTheManual) {
  // SICK 8022708 p. 15, table 2, from the UDP payload on.
  const Bytes printed = {0x4d, 0x53, 0x33, 0x20, 0x4d, 0x44, 0x01, 0x00, 0xb8, 0x0c, 0x00, 0x00, 0x4b,
                         0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x52};
  Ms3Datagram datagram;
  ASSERT_EQ(read_ms3_datagram(ByteView(printed.data(), printed.size()), datagram), Reject::none);
  EXPECT_EQ(datagram.total, 3256U);
  EXPECT_EQ(datagram.identification, 331U);
  EXPECT_EQ(datagram.offset, 0U);
  EXPECT_EQ(datagram.data.size(), 1U);
}

}  // namespace
}  // namespace lidard::sick
