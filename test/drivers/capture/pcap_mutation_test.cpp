// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Whatever bytes a capture holds: reading ends, nothing crashes, and every record is accounted for.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "test/drivers/capture/pcap_testing.h"
#include "test/support/allocations.h"

namespace lidard::test {
namespace {

/// A capture with one of everything: VLAN, IPv6, fragments of both, UDP, TCP, ARP.
std::vector<Bytes> frames() {
  const Bytes datagram = udp(counting(24));
  const Bytes first(datagram.begin(), datagram.begin() + 16), second(datagram.begin() + 16, datagram.end());
  V4 one, two;
  one.id = two.id = 5, one.more = true, two.offset = 16;
  return {ethernet(ipv4(datagram)),
          ethernet(ipv4(datagram), {0x88a8, 0x8100, 0x0800}),
          ethernet(ipv4(second, two)),
          ethernet(ipv4(first, one)),
          ethernet(ipv6(Bytes{17, 0} + Bytes(6) + datagram, 0), {0x86dd}),
          ethernet(ipv6_fragment(first, 9, 0, true), {0x86dd}),
          ethernet(ipv6_fragment(second, 9, 16, false), {0x86dd}),
          ethernet(ipv4(tcp(counting(9), 0xfffffffaU), of_tcp())),
          ethernet(ipv4(tcp(counting(9), 12), of_tcp())),
          ethernet(ipv4(tcp(counting(9), 3), of_tcp())),
          ethernet(ipv4(tcp({}, 7, 40000, 2112, tcp_ack, 21), of_tcp())),
          ethernet(Bytes(28), {0x0806})};
}

Bytes pcap() {
  PcapBytes file;
  for (const Bytes& frame : frames()) file.add(frame, 1700000000);
  return file.bytes;
}

Bytes pcapng() {
  const auto block = [](std::uint32_t type, const Bytes& body) {
    return little(type, 4) + little(body.size() + 12, 4) + body + little(body.size() + 12, 4);
  };
  Bytes out = block(0x0a0d0d0a, little(0x1a2b3c4d, 4) + little(1, 4) + Bytes(8, 0xff)) +
              block(1, little(1, 4) + little(0, 4) + little(9, 2) + little(1, 2) + Bytes{9, 0, 0, 0}) +
              block(5, Bytes(12));
  for (Bytes frame : frames()) {
    const Bytes lengths = little(frame.size(), 4) + little(frame.size(), 4);
    frame.resize((frame.size() + 3) / 4 * 4);
    out = out + block(6, little(0, 4) + little(1, 4) + little(2, 4) + lengths + frame);
  }
  return out;
}

/// Reads everything and checks what must always hold.
Contents expect_sane(const Bytes& bytes) {
  Contents got = read_capture(bytes);
  EXPECT_TRUE(adds_up(got.counters));
  EXPECT_LE(got.counters.frames, bytes.size() / 12);
  EXPECT_TRUE(got.opened || !got.error.empty());
  if (::testing::Test::HasFailure()) ADD_FAILURE() << "mutation not survived: " << got.error;
  return got;
}

class PcapMutation : public ::testing::TestWithParam<Bytes (*)()> {
 protected:
  const Bytes whole_ = GetParam()();
};

TEST_P(PcapMutation, ReadsTheWholeCapture) {
  const Contents got = expect_sane(whole_);
  EXPECT_EQ(got.error, "");
  EXPECT_EQ(got.payloads, std::vector<std::string>(5, text(counting(24))));
}

TEST_P(PcapMutation, CutAnywhereKeepsWhatCameBefore) {
  const Contents whole = expect_sane(whole_);
  std::size_t longest = 0;
  for (std::size_t size = 0; size < whole_.size(); ++size) {
    const Contents got =
        expect_sane(Bytes(whole_.begin(), whole_.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_LE(got.payloads.size(), whole.payloads.size());
    ASSERT_TRUE(std::equal(got.payloads.begin(), got.payloads.end(), whole.payloads.begin())) << size;
    ASSERT_GE(got.payloads.size(), longest) << size;  // a longer piece never yields less
    longest = got.payloads.size();
  }
  EXPECT_EQ(longest, whole.payloads.size());  // only frames that are no datagrams stand at the end
}

TEST_P(PcapMutation, SurvivesEverySingleFlippedBit) {
  Bytes bytes = whole_;
  for (std::size_t bit = 0; bit < bytes.size() * 8 && !HasFailure(); ++bit) {
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1U << bit % 8);
    expect_sane(bytes);
    bytes[bit / 8] = whole_[bit / 8];
  }
}

TEST_P(PcapMutation, SurvivesManyChangesAtOnce) {
  std::mt19937 random(20260101);
  for (int round = 0; round < 5000 && !HasFailure(); ++round) {
    Bytes bytes = whole_;
    for (std::uint32_t changes = 1 + random() % 8; changes > 0; --changes) {
      const std::size_t at = random() % bytes.size();
      const Bytes values{0, 0xff, 0x7f, 0x80, static_cast<std::uint8_t>(random())};
      bytes[at] = values[random() % values.size()];
      if (random() % 4 == 0) bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at));
      if (random() % 8 == 0) bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at / 2), 4, 0xff);
    }
    expect_sane(bytes);
  }
}

TEST_P(PcapMutation, AllocatesNothingPerPacketOnceWarm) {
  const MemoryFile file(whole_);
  PcapSource source(file.path());
  Packet packet;
  const std::uint64_t cold = allocations();
  while (source.next(packet)) {
  }
  EXPECT_GT(allocations() - cold, 0U);
  source.rewind();
  ASSERT_TRUE(source.next(packet));  // the reader's own buffers
  ASSERT_TRUE(source.next(packet));
  const std::uint64_t before = allocations();
  while (source.next(packet)) {
  }
  // The first pass made room for the fragments; a TCP stream and its two segments that wait need room again.
  EXPECT_LE(allocations() - before, 3U);
}

INSTANTIATE_TEST_SUITE_P(Formats, PcapMutation, ::testing::Values(&pcap, &pcapng),
                         [](const auto& format) { return format.index == 0 ? "pcap" : "pcapng"; });

}  // namespace
}  // namespace lidard::test
