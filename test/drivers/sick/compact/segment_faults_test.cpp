// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <boost/crc.hpp>

#include "test/drivers/sick/compact/segment_bench.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;

TEST(SegmentFaults, BadTelegramsAreCountedByTheirFault) {
  SegmentBench bench;
  auto bytes = bench.encode(bench.segment(0, 0));
  bytes[200] ^= 1U;
  EXPECT_EQ(bench.send(bytes, bench.epoch), Reject::checksum);
  bytes = bench.encode(bench.segment(0, 0));
  bytes[24] = 5;
  EXPECT_EQ(bench.send(bytes, bench.epoch), Reject::version);
  bytes.resize(500);
  bytes[24] = 4;
  EXPECT_EQ(bench.send(bytes, bench.epoch), Reject::size);
  EXPECT_EQ(bench.send({1, 2, 3, 4, 5, 6, 7, 8, 9}, bench.epoch), Reject::magic);
  sim::SickSegment twice = bench.segment(0, 0);
  twice.modules[0].push_back(twice.modules[0][0]);
  EXPECT_EQ(bench.send(bench.encode(twice), bench.epoch), Reject::model);
  EXPECT_TRUE(bench.has_warning("sick_multiscan136"));
  EXPECT_EQ(bench.driver->counters().rejected_total(), 5U);
  EXPECT_EQ(bench.driver->counters().packets, 5U);
}

/// The verdict on a telegram of MSGPACK in which `marker` takes the place of the first byte of `value`.
Reject with_marker(std::uint8_t marker, const std::vector<std::uint8_t>& value) {
  SegmentBench bench;
  bench.version = 0;
  auto bytes = bench.encode(bench.segment(130, 0));  // frame 200
  const auto found = std::search(bytes.begin(), bytes.end(), value.begin(), value.end());
  if (found == bytes.end()) return Reject::magic;
  *found = marker;
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data() + 8, bytes.size() - 12);
  for (std::size_t i = 0; i < 4; ++i)
    bytes[bytes.size() - 4 + i] = static_cast<std::uint8_t>(crc.checksum() >> 8 * i);
  return bench.send(bytes, bench.epoch);
}

TEST(SegmentFaults, DistancesInMsgpackAreBytesAndNothingElse) {
  for (unsigned marker = 0; marker < 256; ++marker)  // bin16: 60 beams of four bytes
    EXPECT_EQ(with_marker(static_cast<std::uint8_t>(marker), {0xc5, 0, 240}),
              marker == 0xc5 ? Reject::none : Reject::field)
        << marker;
}

TEST(SegmentFaults, ANegativeFrameNumberInMsgpackIsRefused) {
  EXPECT_EQ(with_marker(0xcc, {0xcc, 200}), Reject::none);
  EXPECT_EQ(with_marker(0xd0, {0xcc, 200}), Reject::field) << "-56";
}

TEST(SegmentFaults, TypesNobodyReadsAreSetAside) {
  SegmentBench bench;
  for (const unsigned type : {3U, 5U, 6U, 7U}) {
    std::vector<std::uint8_t> bytes = {2, 2, 2, 2, static_cast<std::uint8_t>(type), 0, 0, 0};
    bytes.resize(1200, 0xee);
    EXPECT_EQ(bench.send(bytes, bench.epoch), Reject::none);
  }
  EXPECT_EQ(bench.driver->counters().other_packets, 4U);
  EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
}

TEST(SegmentFaults, AnotherDeviceOnTheSamePortIsLeftOutAndNamed) {
  SegmentBench bench;
  for (std::uint64_t f = 0; f < 4; ++f) {
    for (int i = 0; i < SegmentBench::segments; ++i) {
      bench.send(f, i);
      EXPECT_EQ(bench.device, "device 23370016");
      sim::SickSegment other = bench.segment(f, i);
      other.sender = 4711;
      bench.send(bench.encode(other), bench.arrival(f, i));
      EXPECT_EQ(bench.device, "device 4711");
    }
  }
  EXPECT_EQ(bench.scans.size(), 3U);
  EXPECT_EQ(bench.driver->counters().other_packets, 40U);
  EXPECT_TRUE(bench.has_warning("set ip_address of both"));
}

TEST(SegmentFaults, ADeviceThatIsExchangedIsNotASecondOne) {
  SegmentBench bench;
  for (std::uint64_t f = 0; f < 60; ++f) {
    for (int i = 0; i < SegmentBench::segments; ++i) {
      sim::SickSegment segment = bench.segment(f, i);
      if (f >= 4) segment.sender = 4711;
      bench.send(bench.encode(segment), bench.arrival(f, i));
    }
  }
  EXPECT_EQ(bench.driver->info().serial, "4711");
}

}  // namespace
}  // namespace lidard::sick
