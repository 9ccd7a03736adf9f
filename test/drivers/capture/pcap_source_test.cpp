// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/pcap_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/drivers/capture/pcap_testing.h"

namespace lidard::test {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

const Bytes payload = counting(40);

Bytes frame(const Bytes& content = payload) { return ethernet(ipv4(udp(content))); }

TEST(PcapSource, HandsOnPayloadSenderReceiverAndStamp) {
  const Contents got =
      read_capture(PcapBytes().add(frame(), 1700000000.25).add(frame({9}), 1700000001.5).bytes);
  EXPECT_EQ(got.error, "");
  EXPECT_THAT(got.payloads, ElementsAre(text(payload), "\x09"));
  EXPECT_EQ(got.flows[0], "192.168.1.201:2368 > 255.255.255.255:2369");
  EXPECT_EQ(got.stamps[0].ns, 1'700'000'000'250'000'000);
  EXPECT_EQ(got.stamps[1].ns, 1'700'000'001'500'000'000);
  EXPECT_EQ(got.counters.frames, 2U);
  EXPECT_EQ(got.counters.datagrams, 2U);
}

TEST(PcapSource, ReadsBothByteOrdersInMicroAndNanoseconds) {
  for (const bool big_endian : {false, true}) {
    EXPECT_EQ(read_capture(PcapBytes(1, big_endian).add(frame(), 2.000005).bytes).stamps.at(0).ns,
              2'000'005'000);
    EXPECT_EQ(read_capture(PcapBytes(1, big_endian, 0xa1b23c4d).add(frame(), 2.000005).bytes).stamps.at(0).ns,
              2'000'000'005);
  }
}

TEST(PcapSource, ReadsStampsBeyond2038) {
  EXPECT_EQ(read_capture(PcapBytes().add(frame(), 4294967295.0).bytes).stamps.at(0).ns,
            4'294'967'295'000'000'000);
}

TEST(PcapSource, TrustsTheUdpLengthWhereTheIpLengthLies) {
  for (const int lie : {694, -30, -68}) {
    V4 o;
    o.lie = lie;
    const Contents got =
        read_capture(PcapBytes().add(ethernet(ipv4(udp(payload), o)) + Bytes(18, 0xa5)).bytes);
    EXPECT_THAT(got.payloads, ElementsAre(text(payload))) << lie;
  }
}

TEST(PcapSource, CountsWhatItDoesNotHandOn) {
  Bytes long_udp = udp(payload), short_udp = udp(payload);
  long_udp[4] = 4, short_udp[4] = 0, short_udp[5] = 3;
  V4 icmp;
  icmp.protocol = 1;
  Bytes snapped = frame();
  snapped.pop_back();
  const Contents got = read_capture(PcapBytes()
                                        .add(ethernet({1, 2, 3}, {0x0806}))
                                        .add(ethernet(ipv4(Bytes(20), icmp)))
                                        .add(ethernet(ipv4(long_udp)))
                                        .add(ethernet(ipv4(short_udp)))
                                        .add({1, 2, 3})
                                        .add(snapped, 0, frame().size())
                                        .add({1, 2, 3}, 0, 500)
                                        .add({}, 0, 500)
                                        .add(frame({}))
                                        .bytes);
  EXPECT_EQ(got.error, "");
  EXPECT_EQ(got.counters.frames, 9U);
  EXPECT_EQ(got.counters.not_ip, 1U);
  EXPECT_EQ(got.counters.other_ip, 1U);
  EXPECT_EQ(got.counters.malformed, 3U);
  EXPECT_EQ(got.counters.truncated, 3U);
  EXPECT_EQ(got.counters.datagrams, 1U);
  EXPECT_TRUE(adds_up(got.counters));
}

TEST(PcapSource, UsesADatagramWhosePaddingAloneWasCutBySnapshotLength) {
  const Contents got = read_capture(PcapBytes().add(frame(), 0, frame().size() + 6).bytes);
  EXPECT_THAT(got.payloads, ElementsAre(text(payload)));
}

TEST(PcapSource, UsesRecordsLongerThanTheSnapshotLengthOfTheFileHeader) {
  for (const bool big_endian : {false, true}) {
    Bytes bytes = PcapBytes(1, big_endian).add(frame()).bytes;
    const Bytes sixty_bytes = big_endian ? big(60, 4) : little(60, 4);
    std::copy(sixty_bytes.begin(), sixty_bytes.end(), bytes.begin() + 16);
    EXPECT_THAT(read_capture(bytes).payloads, ElementsAre(text(payload)));
  }
}

TEST(PcapSource, CountsALinkTypeItDoesNotRead) {
  const Contents got = read_capture(PcapBytes(105).add(frame()).add(frame()).bytes);
  EXPECT_EQ(got.counters.unsupported_link, 2U);
  EXPECT_EQ(got.error, "");
}

/// The frames of one datagram in fragments of 24 bytes.
std::vector<Bytes> fragments(std::uint16_t id, bool v6 = false) {
  const Bytes datagram = udp(payload);
  std::vector<Bytes> out;
  for (std::size_t o = 0; o < datagram.size(); o += 24) {
    const std::size_t n = std::min<std::size_t>(24, datagram.size() - o);
    const Bytes part(datagram.begin() + static_cast<std::ptrdiff_t>(o),
                     datagram.begin() + static_cast<std::ptrdiff_t>(o + n));
    V4 options;
    options.id = id, options.offset = o, options.more = o + n < datagram.size();
    out.push_back(v6 ? ethernet(ipv6_fragment(part, id, o, options.more), {0x86dd})
                     : ethernet(ipv4(part, options)));
  }
  return out;
}

TEST(PcapSource, PutsFragmentsTogether) {
  for (const bool v6 : {false, true}) {
    const auto one = fragments(1, v6), two = fragments(2, v6);
    ASSERT_EQ(one.size(), 2U);
    const Contents got =
        read_capture(PcapBytes().add(one[1], 1).add(two[0], 2).add(one[0], 3).add(two[1], 4).bytes);
    EXPECT_THAT(got.payloads, ElementsAre(text(payload), text(payload)));
    EXPECT_EQ(got.stamps[0].ns, 3'000'000'000);  // as a socket would: when the last part arrived
    EXPECT_EQ(got.counters.fragments, 4U);
    EXPECT_EQ(got.counters.reassembled, 2U);
    EXPECT_EQ(got.counters.fragments_dropped, 0U);
    EXPECT_TRUE(adds_up(got.counters));
  }
}

TEST(PcapSource, ReadsExtensionHeadersInsideAPacketPutTogether) {
  const Bytes content = Bytes{17, 0} + Bytes(6) + udp(payload);  // destination options, then UDP
  const Bytes first(content.begin(), content.begin() + 16), second(content.begin() + 16, content.end());
  const Contents got = read_capture(PcapBytes(101)
                                        .add(ipv6_fragment(first, 5, 0, true, 60))
                                        .add(ipv6_fragment(second, 5, 16, false, 60))
                                        .bytes);
  EXPECT_THAT(got.payloads, ElementsAre(text(payload)));
}

TEST(PcapSource, CountsAFragmentThatNeverBecameWholeAtTheEnd) {
  const auto parts = fragments(1);
  const Contents got = read_capture(PcapBytes().add(parts[0]).add(frame()).bytes);
  EXPECT_EQ(got.counters.datagrams, 1U);
  EXPECT_EQ(got.counters.fragments_dropped, 1U);
  EXPECT_TRUE(adds_up(got.counters));
}

TEST(PcapSource, CountsAFragmentCutByTheSnapshotLengthAndNeverUsesIt) {
  const auto parts = fragments(1);
  const Bytes cut(parts[0].begin(), parts[0].end() - 8);
  const Contents got = read_capture(PcapBytes().add(cut, 0, parts[0].size()).add(parts[1]).bytes);
  EXPECT_TRUE(got.payloads.empty());
  EXPECT_EQ(got.counters.truncated, 1U);
  EXPECT_EQ(got.counters.fragments_dropped, 1U);
  EXPECT_TRUE(adds_up(got.counters));
}

TEST(PcapSource, CountsAPacketPutTogetherThatIsNotADatagram) {
  V4 first, second;
  first.protocol = second.protocol = 1;
  first.more = true, second.offset = 16;
  const Contents got =
      read_capture(PcapBytes(228).add(ipv4(Bytes(16), first)).add(ipv4(Bytes(9), second)).bytes);
  EXPECT_EQ(got.counters.reassembled, 1U);
  EXPECT_EQ(got.counters.other_ip, 1U);
  EXPECT_TRUE(adds_up(got.counters));
}

TEST(PcapSource, KeepsWhatCameBeforeACutRecord) {
  Bytes bytes = PcapBytes().add(frame()).add(frame()).bytes;
  const std::size_t second = 24 + 16 + frame().size();
  for (std::size_t size = second + 1; size < bytes.size(); ++size) {
    const Contents got =
        read_capture(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)));
    ASSERT_EQ(got.payloads.size(), 1U);
    EXPECT_THAT(got.error, EndsWith("record cut by the end of the file at byte " + std::to_string(second) +
                                    "; what came before it was used"));
    EXPECT_FALSE(got.damaged) << "a recording was stopped";
  }
}

TEST(PcapSource, NamesThePlaceOfALyingRecord) {
  Bytes bytes = PcapBytes().add(frame()).add(frame()).bytes;
  const std::size_t second = 24 + 16 + frame().size();
  bytes[second + 11] = 0x7f;  // captured length
  const Contents got = read_capture(bytes);
  EXPECT_EQ(got.payloads.size(), 1U);
  EXPECT_THAT(got.error, HasSubstr("record of the impossible length"));
  EXPECT_THAT(got.error, HasSubstr("at byte " + std::to_string(second) + ";"));
  EXPECT_TRUE(got.damaged);
}

TEST(PcapSource, IsDamagedWhereALyingLengthHidesMoreThanALastRecord) {
  PcapBytes file;
  for (std::size_t bytes = 0; bytes < 100'000; bytes += frame().size() + 16) file.add(frame());
  Bytes bytes = file.bytes;
  bytes[24 + 16 + frame().size() + 10] = 2;  // captured length: 131072 and some more
  const Contents got = read_capture(bytes);
  EXPECT_EQ(got.payloads.size(), 1U);
  EXPECT_THAT(got.error, HasSubstr("cut by the end of the file"));
  EXPECT_TRUE(got.damaged);
}

TEST(PcapSource, RefusesWhatIsNoCaptureWithOneSentenceAndARemedy) {
  EXPECT_THAT(
      read_capture("/no/such/file.pcap").error,
      testing::AllOf(HasSubstr("/no/such/file.pcap: cannot be opened: No such file"), HasSubstr("; check")));
  EXPECT_THAT(read_capture("/tmp").error, HasSubstr("/tmp: is a directory; name the capture files"));
  EXPECT_THAT(read_capture("/dev/null").error, HasSubstr("is neither a file nor a pipe"));
  EXPECT_THAT(read_capture(Bytes{}).error, HasSubstr("the file is empty (0 bytes); record it again"));
  EXPECT_THAT(read_capture(Bytes{1, 2}).error,
              HasSubstr("too short to be a capture; give a pcap or pcapng file"));
  EXPECT_THAT(read_capture(Bytes(100, 'x')).error,
              HasSubstr("unknown file format; give a pcap or pcapng file"));
  EXPECT_THAT(read_capture(Bytes{0x0a, 0x0d, 0x0d, 0x0a} + Bytes(40, 1)).error,
              HasSubstr("unknown file format"))
      << "no byte-order magic";
  for (std::size_t n = 4; n < 24; ++n) {
    const Bytes header = PcapBytes().bytes;
    const Contents got = read_capture(Bytes(header.begin(), header.begin() + static_cast<std::ptrdiff_t>(n)));
    EXPECT_FALSE(got.opened);
    EXPECT_THAT(got.error, HasSubstr("; give a pcap or pcapng file"));
  }
}

TEST(PcapSource, SaysThatACaptureHoldsNoPacket) {
  const Contents got = read_capture(PcapBytes().bytes);
  EXPECT_TRUE(got.opened);
  EXPECT_THAT(got.error, HasSubstr("holds no packet; check interface and filter"));
}

TEST(PcapSource, StartsAgainAndCountsOn) {
  const auto parts = fragments(7);
  const MemoryFile file(PcapBytes().add(parts[1]).add(frame()).add(frame({1})).add(parts[0]).bytes);
  PcapSource source(file.path());
  Packet packet;
  ASSERT_TRUE(source.next(packet));
  source.rewind();  // in the middle: the half packet is forgotten
  Contents first, second;
  read_all(source, first);
  source.rewind();
  read_all(source, second);
  EXPECT_THAT(first.payloads, ElementsAre(text(payload), "\x01", text(payload)));
  EXPECT_EQ(first.payloads, second.payloads);
  EXPECT_EQ(second.counters.frames, 10U);
  EXPECT_EQ(second.counters.fragments_dropped, 1U);
  EXPECT_EQ(source.position(), source.size());
}

TEST(PcapSource, TellsHowFarItHasRead) {
  const MemoryFile file(PcapBytes().add(frame()).add(frame()).bytes);
  PcapSource source(file.path());
  EXPECT_EQ(source.size(), 24 + 2 * (16 + frame().size()));
  Packet packet;
  ASSERT_TRUE(source.next(packet));
  EXPECT_EQ(source.position(), 24 + 16 + frame().size());
  PcapSource moved = std::move(source);
  ASSERT_TRUE(moved.next(packet));
  EXPECT_EQ(moved.position(), moved.size());
}

}  // namespace
}  // namespace lidard::test
