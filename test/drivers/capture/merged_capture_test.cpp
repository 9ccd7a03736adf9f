// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/capture/pcap_source.h"
#include "test/drivers/capture/pcap_testing.h"

namespace lidard::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A capture with a datagram of one byte at each of these times (s).
PcapBytes capture_of(const std::vector<std::pair<double, std::uint8_t>>& datagrams) {
  PcapBytes file;
  for (const auto& [at, byte] : datagrams) file.add(ethernet(ipv4(udp({byte}))), at);
  return file;
}

std::vector<int> bytes_of(MergedCapture& capture) {
  std::vector<int> all;
  for (Packet packet; capture.next(packet);) all.push_back(packet.payload.data()[0]);
  return all;
}

TEST(MergedCapture, GivesThePacketsOfAllFilesInTheOrderOfTheirStamps) {
  const MemoryFile one(capture_of({{1, 1}, {4, 4}, {5, 5}}).bytes);
  const MemoryFile two(capture_of({{2, 2}, {3, 3}, {6, 6}}).bytes);
  MergedCapture capture({two.path(), one.path()});
  EXPECT_THAT(bytes_of(capture), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_EQ(capture.counters().datagrams, 6U);
  EXPECT_EQ(capture.counters().frames, 6U);
  EXPECT_NEAR(capture.progress(), 1, 1e-9);
  Packet packet;
  EXPECT_FALSE(capture.next(packet)) << "the end is the end";
  capture.rewind();
  EXPECT_THAT(bytes_of(capture), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_TRUE(capture.errors().empty());
  EXPECT_FALSE(capture.is_damaged());
}

TEST(MergedCapture, KeepsTheOrderOfTheFilesWhereStampsAreEqual) {
  const MemoryFile one(capture_of({{1, 1}, {2, 3}}).bytes), two(capture_of({{1, 2}, {2, 4}}).bytes);
  MergedCapture capture({one.path(), two.path()});
  EXPECT_THAT(bytes_of(capture), ElementsAre(1, 2, 3, 4));
}

TEST(MergedCapture, RewindsInTheMiddle) {
  const MemoryFile one(capture_of({{1, 1}, {3, 3}}).bytes), two(capture_of({{2, 2}}).bytes);
  MergedCapture capture({one.path(), two.path()});
  Packet packet;
  ASSERT_TRUE(capture.next(packet));
  ASSERT_TRUE(capture.next(packet));
  EXPECT_LT(capture.progress(), 1.001);
  EXPECT_GT(capture.progress(), 0.5);
  capture.rewind();
  EXPECT_THAT(bytes_of(capture), ElementsAre(1, 2, 3));
}

TEST(MergedCapture, GoesOnWithTheOthersWhereAFileIsDamagedAndNamesIt) {
  const MemoryFile good(capture_of({{1, 1}, {5, 5}, {9, 9}}).bytes);
  // A record that says it has 2^31 bytes, in the middle of the file.
  PcapBytes bad = capture_of({{2, 2}, {3, 3}, {4, 4}});
  Bytes bytes = bad.bytes;
  const std::size_t record = (bytes.size() - 24) / 3;
  for (std::size_t i = 0; i < 4; ++i) bytes[24 + record + 8 + i] = 0x7f;
  bytes.resize(bytes.size() + 200000);
  const MemoryFile damaged(bytes);
  MergedCapture capture({good.path(), damaged.path()});
  EXPECT_THAT(bytes_of(capture), ElementsAre(1, 2, 5, 9));
  ASSERT_EQ(capture.errors().size(), 1U);
  EXPECT_THAT(capture.errors()[0], HasSubstr(damaged.path()));
  EXPECT_TRUE(capture.is_damaged());
  EXPECT_EQ(capture.counters().datagrams, 4U);
}

TEST(MergedCapture, RefusesAFileThatCannotBeRead) {
  const MemoryFile good(capture_of({{1, 1}}).bytes);
  EXPECT_THROW(MergedCapture({good.path(), "/no/such.pcap"}), CaptureError);
}

}  // namespace
}  // namespace lidard::test
