// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Real captures, and the odd relatives of one of them: the same 100 payloads in every dress a capture can
// wear. The expected numbers were counted with tshark 4.0.17.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "test/drivers/capture/pcap_testing.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using ::testing::HasSubstr;
using Payloads = std::vector<std::string>;

constexpr const char* plain_name = "velodyne/vlp16_2014_says_hdl32.pcap";

/// The payloads of `plain`, from which `pick` makes those of a relative: it is told the number of each
/// payload and appends what becomes of it.
template <typename Pick>
Payloads relative(const Payloads& plain, Pick pick) {
  Payloads out;
  for (std::size_t i = 0; i < plain.size(); ++i) pick(i, out);
  return out;
}

void expect_counters(const CaptureCounters& got, const CaptureCounters& expected) {
  EXPECT_EQ(got.frames, expected.frames);
  EXPECT_EQ(got.datagrams, expected.datagrams);
  EXPECT_EQ(got.not_ip, expected.not_ip);
  EXPECT_EQ(got.tcp_segments, expected.tcp_segments);
  EXPECT_EQ(got.other_ip, expected.other_ip);
  EXPECT_EQ(got.truncated, expected.truncated);
  EXPECT_EQ(got.malformed, expected.malformed);
  EXPECT_EQ(got.unsupported_link, expected.unsupported_link);
  EXPECT_EQ(got.fragments, expected.fragments);
  EXPECT_EQ(got.reassembled, expected.reassembled);
  EXPECT_EQ(got.fragments_dropped, expected.fragments_dropped);
  EXPECT_TRUE(adds_up(got));
}

CaptureCounters only_datagrams(std::uint64_t n) {
  CaptureCounters c;
  c.frames = c.datagrams = n;
  return c;
}

class OddCaptures : public ::testing::Test {
 protected:
  void SetUp() override {
    LIDARD_NEED_CAPTURE(path, plain_name);
    plain_ = read_capture(path);
    ASSERT_EQ(plain_.payloads.size(), 100U);
    expect_counters(plain_.counters, only_datagrams(100));
  }
  Contents read(const std::string& name) {
    const std::string path = shared_capture("odd/" + name);
    EXPECT_FALSE(path.empty()) << name;
    return read_capture(path);
  }
  Contents plain_;
};

TEST_F(OddCaptures, OfEveryLinkTypeByteOrderAndFormatCarryTheSamePayloadsAtTheSameTimes) {
  for (const std::string name : {"nsec.pcap",
                                 "swapped.pcap",
                                 "swapped_nsec.pcap",
                                 "vlan.pcap",
                                 "qinq.pcap",
                                 "sll.pcap",
                                 "sll2.pcap",
                                 "raw.pcap",
                                 "raw12.pcap",
                                 "null.pcap",
                                 "loop.pcap",
                                 "ipopts.pcap",
                                 "pad.pcap",
                                 "nochecksum.pcap",
                                 "ipv6.pcap",
                                 "pcapng_le.pcapng",
                                 "pcapng_be.pcapng",
                                 "pcapng_nsec.pcapng",
                                 "pcapng_two_if.pcapng",
                                 "pcapng_two_eth.pcapng"}) {
    SCOPED_TRACE(name);
    const Contents got = read(name);
    EXPECT_EQ(got.error, "");
    EXPECT_TRUE(got.payloads == plain_.payloads);
    expect_counters(got.counters, only_datagrams(100));
    for (std::size_t i = 0; i < std::min(got.stamps.size(), plain_.stamps.size()); ++i) {
      EXPECT_LT(std::abs((got.stamps[i] - plain_.stamps[i]).count()), 1000);
    }
    if (name == "ipv6.pcap") continue;
    EXPECT_EQ(got.flows, plain_.flows);
  }
}

TEST_F(OddCaptures, InFragmentsArePutTogetherInOrderReversedAndDoubled) {
  CaptureCounters expected = only_datagrams(100);
  expected.frames = expected.fragments = 300;
  expected.reassembled = 100;
  for (const std::string name : {"frag.pcap", "frag_reorder.pcap"}) {
    SCOPED_TRACE(name);
    const Contents got = read(name);
    EXPECT_TRUE(got.payloads == plain_.payloads);
    expect_counters(got.counters, expected);
  }
  const Contents doubled = read("frag_dup.pcap");
  EXPECT_TRUE(doubled.payloads == plain_.payloads);
  expected.frames = expected.fragments = 450;
  expected.fragments_dropped = 150;
  expect_counters(doubled.counters, expected);
}

TEST_F(OddCaptures, WithHolesInEveryFifthPacketLackExactlyThose) {
  const Contents got = read("frag_hole.pcap");
  EXPECT_TRUE(got.payloads == relative(plain_.payloads, [&](std::size_t i, Payloads& out) {
                if (i % 5 != 4) out.push_back(plain_.payloads[i]);
              }));
  CaptureCounters expected = only_datagrams(80);
  expected.frames = expected.fragments = 280;
  expected.reassembled = 80;
  expected.fragments_dropped = 40;
  expect_counters(got.counters, expected);
}

TEST_F(OddCaptures, WithLostDoubledAndSwappedPacketsHandOnWhatWasRecorded) {
  const Payloads& p = plain_.payloads;
  EXPECT_TRUE(read("drop10.pcap").payloads == relative(p, [&](std::size_t i, Payloads& out) {
                if (i % 10 != 9) out.push_back(p[i]);
              }));
  EXPECT_TRUE(read("dup8.pcap").payloads == relative(p, [&](std::size_t i, Payloads& out) {
                out.insert(out.end(), i % 8 == 7 ? 2 : 1, p[i]);
              }));
  EXPECT_TRUE(read("swap8.pcap").payloads == relative(p, [&](std::size_t i, Payloads& out) {
                const bool first = i % 8 == 7, second = i % 8 == 0 && i > 0;
                out.push_back(p[first ? i + 1 : second ? i - 1 : i]);
              }));
}

TEST_F(OddCaptures, ShortenedBySnapshotLengthLackTheCutPacketsAndSaySo) {
  const Contents got = read("snaplen.pcap");
  EXPECT_TRUE(got.payloads == relative(plain_.payloads, [&](std::size_t i, Payloads& out) {
                if (i % 7 != 6 || plain_.payloads[i].size() == 512) out.push_back(plain_.payloads[i]);
              }));
  CaptureCounters expected = only_datagrams(87);
  expected.frames = 100;
  expected.truncated = 13;
  expect_counters(got.counters, expected);
}

TEST_F(OddCaptures, WithRecordsOfNoBytesCountThemAsCut) {
  const Contents got = read("zero_len.pcap");
  EXPECT_TRUE(got.payloads == plain_.payloads);
  CaptureCounters expected = only_datagrams(100);
  expected.frames = 125;
  expected.truncated = 25;
  expect_counters(got.counters, expected);
}

TEST_F(OddCaptures, WithNoiseBetweenStillHoldAllPackets) {
  const Contents got = read("noise.pcap");
  Payloads sensor, foreign;
  for (const std::string& payload : got.payloads) {
    (payload.size() == 1206 || payload.size() == 512 ? sensor : foreign).push_back(payload);
  }
  EXPECT_TRUE(sensor == plain_.payloads);
  EXPECT_EQ(foreign.size(), 15U);
  CaptureCounters expected = only_datagrams(115);
  expected.frames = 134;
  expected.not_ip = 4;
  expected.other_ip = 3;
  expected.malformed = 9 + 3;  // three of TCP with a header of no length
  expect_counters(got.counters, expected);
}

TEST_F(OddCaptures, AcrossTheHourDifferInTheDevicesTimeAlone) {
  const Contents got = read("hourwrap.pcap");
  ASSERT_EQ(got.payloads.size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) {
    if (plain_.payloads[i].size() != 1206) continue;
    EXPECT_TRUE(got.payloads[i].substr(0, 1200) == plain_.payloads[i].substr(0, 1200)) << i;
    EXPECT_TRUE(got.payloads[i].substr(1204) == plain_.payloads[i].substr(1204)) << i;
  }
}

void expect_first(const Contents& got, const Contents& plain, std::size_t n, const std::string& error) {
  EXPECT_TRUE(got.opened);
  EXPECT_TRUE(got.payloads ==
              Payloads(plain.payloads.begin(), plain.payloads.begin() + static_cast<long>(n)));
  expect_counters(got.counters, only_datagrams(n));
  EXPECT_THAT(got.error, HasSubstr(error));
}

TEST_F(OddCaptures, ThatAreCutOrLieEndWithTheirPlaceAndKeepWhatCameBefore) {
  expect_first(
      read("cut_record.pcap"), plain_, 99,
      "cut_record.pcap: record cut by the end of the file at byte 114056; what came before it was used");
  expect_first(
      read("cut_header.pcap"), plain_, 99,
      "cut_header.pcap: record cut by the end of the file at byte 114056; what came before it was used");
  expect_first(read("biglen.pcap"), plain_, 50, "at byte 58366; what came before it was used");
}

TEST_F(OddCaptures, ThatAreNoneAreRefusedWithOneMessage) {
  EXPECT_THAT(read("zero.pcap").error, HasSubstr("zero.pcap: the file is empty (0 bytes); record it again"));
  EXPECT_THAT(read("bad_magic.pcap").error,
              HasSubstr("bad_magic.pcap: unknown file format; give a pcap or pcapng"));
  EXPECT_THAT(read("empty.pcap").error, HasSubstr("empty.pcap: holds no packet; check interface and filter"));
  EXPECT_FALSE(read("zero.pcap").opened);
  EXPECT_FALSE(read("bad_magic.pcap").opened);
}

TEST_F(OddCaptures, OfTheOusterSdkAreReadToTheLastDatagram) {
  EXPECT_EQ(read("ouster_sdk/OS-0-32-U1_v2.2.0_1024x10.pcap").counters.datagrams, 74U);
  EXPECT_EQ(read("ouster_sdk/OS-0-32-U1_single-packet.pcap").payloads.at(0).size(), 8448U);  // a jumbo frame
  EXPECT_EQ(read("ouster_sdk/VLI-16-one-packet.pcap").payloads.at(0).size(), 1212U);
  EXPECT_EQ(read("ouster_sdk/imu_zm_no_lidar.pcap").counters.datagrams, 9U);
  EXPECT_EQ(read("ouster_sdk/windowed_frame1.pcap").counters.datagrams, 27U);
  EXPECT_THAT(read("ouster_sdk/empty_pcap.pcap").error, HasSubstr("holds no packet"));
  EXPECT_THAT(read("ouster_sdk/zero_bytes.pcap").error, HasSubstr("the file is empty"));
}

TEST_F(OddCaptures, OfTheOusterSdkHoldRecordedFragments) {
  CaptureCounters expected;
  expected.frames = 23, expected.datagrams = 4, expected.fragments = 21, expected.reassembled = 2;
  const Contents same_ports = read("ouster_sdk/same_ports.pcap");
  expect_counters(same_ports.counters, expected);
  EXPECT_EQ(same_ports.payloads[2].size(), 12608U);
  EXPECT_EQ(same_ports.payloads[3].size(), 16640U);
  expected.frames = expected.fragments = 26, expected.datagrams = expected.reassembled = 2;
  expect_counters(read("ouster_sdk/same_ports_legacy.pcap").counters, expected);
  // The first of seven fragments came 88 s before a packet of the same number: it is too old to belong to it.
  expected.frames = expected.fragments = 7, expected.datagrams = expected.reassembled = 1;
  expected.fragments_dropped = 1;
  expect_counters(read("ouster_sdk/duplicate_id.pcap").counters, expected);
}

TEST_F(OddCaptures, OfAnOfficeNetworkAreCountedByKind) {
  CaptureCounters expected = only_datagrams(132);
  expected.frames = 324;
  expected.not_ip = 8;
  expected.other_ip = 156;  // ICMP
  expected.tcp_segments = 28;
  const Contents got = read("sick_lls_udp5009_office_noise.pcapng");
  EXPECT_EQ(got.error, "");
  expect_counters(got.counters, expected);
}

TEST(SickCaptures, RecordedInIpFragmentsArePutTogether) {
  LIDARD_NEED_CAPTURE(compact, "sick/multiscan_compact_frag.pcap");
  const Contents got = read_capture(compact);
  CaptureCounters expected;
  expected.frames = 358, expected.datagrams = 94, expected.fragments = 330, expected.reassembled = 66;
  expect_counters(got.counters, expected);
  EXPECT_EQ(std::count_if(got.payloads.begin(), got.payloads.end(), [](auto& p) { return p.size() == 64; }),
            28);
  EXPECT_EQ(std::count_if(got.payloads.begin(), got.payloads.end(), [](auto& p) { return p.size() == 6960; }),
            66);

  LIDARD_NEED_CAPTURE(msgpack, "sick/multiscan_msgpack_3echo_frag.pcap");
  const Contents packed = read_capture(msgpack);
  expected.frames = expected.fragments = 400, expected.datagrams = expected.reassembled = 25;
  expect_counters(packed.counters, expected);
  for (const std::string& payload : packed.payloads) EXPECT_EQ(payload.size(), 23656U);
}

/// One file of the pcapng suite, the same in both byte orders.
struct SuiteFile {
  const char* name;
  std::uint64_t frames, datagrams, truncated;
};
void PrintTo(const SuiteFile& file, std::ostream* out) { *out << file.name; }

class PcapngSuite : public ::testing::TestWithParam<SuiteFile> {};

TEST_P(PcapngSuite, IsReadInBothByteOrders) {
  const SuiteFile& file = GetParam();
  Contents by_order[2];
  for (const bool big_endian : {false, true}) {
    LIDARD_NEED_CAPTURE(
        path, std::string("odd/pcapng_suite/") + (big_endian ? "be_" : "le_") + file.name + ".pcapng");
    Contents& got = by_order[big_endian ? 1 : 0];
    got = read_capture(path);
    EXPECT_TRUE(got.opened);
    EXPECT_THAT(got.error, HasSubstr(file.frames == 0 ? "holds no packet" : ""));
    EXPECT_EQ(got.error.empty(), file.frames > 0);
    CaptureCounters expected;
    expected.frames = file.frames, expected.datagrams = file.datagrams, expected.truncated = file.truncated;
    expect_counters(got.counters, expected);
  }
  EXPECT_EQ(by_order[0].payloads, by_order[1].payloads);
  EXPECT_EQ(by_order[0].stamps, by_order[1].stamps);
}

INSTANTIATE_TEST_SUITE_P(
    AllFiles, PcapngSuite,
    ::testing::Values(SuiteFile{"advanced_test100", 5, 5, 0}, SuiteFile{"advanced_test101", 4, 1, 3},
                      SuiteFile{"advanced_test102", 5, 2, 3}, SuiteFile{"basic_test001", 4, 4, 0},
                      SuiteFile{"basic_test002", 0, 0, 0}, SuiteFile{"basic_test003", 0, 0, 0},
                      SuiteFile{"basic_test004", 4, 0, 4}, SuiteFile{"basic_test005", 4, 0, 4},
                      SuiteFile{"basic_test006", 5, 1, 4}, SuiteFile{"basic_test007", 1, 0, 1},
                      SuiteFile{"basic_test008", 4, 0, 4}, SuiteFile{"basic_test009", 2, 2, 0},
                      SuiteFile{"basic_test010", 4, 4, 0}, SuiteFile{"basic_test011", 4, 4, 0},
                      SuiteFile{"basic_test012", 4, 2, 2}, SuiteFile{"basic_test013", 0, 0, 0},
                      SuiteFile{"basic_test014", 0, 0, 0}, SuiteFile{"basic_test015", 0, 0, 0},
                      SuiteFile{"basic_test016", 4, 4, 0}, SuiteFile{"basic_test017", 0, 0, 0},
                      SuiteFile{"basic_test018", 4, 4, 0}, SuiteFile{"difficult_test200", 0, 0, 0},
                      SuiteFile{"difficult_test201", 4, 1, 3}, SuiteFile{"difficult_test202", 8, 2, 6}),
    [](const auto& file) { return std::string(file.param.name); });

}  // namespace
}  // namespace lidard::test
