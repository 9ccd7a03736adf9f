// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// TCP streams in capture files. The expected numbers of the real captures were counted with a script of a few
// lines that knows nothing of this program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <random>
#include <utility>
#include <vector>

#include "test/drivers/capture/pcap_testing.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using ::testing::ElementsAre;

Bytes frame(const std::string& bytes, std::uint32_t sequence, std::uint8_t flags = tcp_ack) {
  return ethernet(ipv4(tcp({bytes.begin(), bytes.end()}, sequence, 2112, 40000, flags), of_tcp()));
}
/// What the device of port 2112 sent.
std::string sent_by_device(const Contents& contents) {
  std::string out;
  for (const TcpChunk& chunk : contents.chunks) {
    if (chunk.from.port == 2112) out += chunk.bytes;
  }
  return out;
}

TEST(TcpCapture, HandsOnBothDirectionsBesideDatagrams) {
  const Contents got = read_capture(PcapBytes()
                                        .add(frame("abc", 100), 1)
                                        .add(ethernet(ipv4(udp({1, 2}))), 2)
                                        .add(ethernet(ipv4(tcp({'?'}, 7, 40000, 2112), of_tcp())), 3)
                                        .add(frame("de", 103), 4)
                                        .bytes);
  ASSERT_EQ(got.chunks.size(), 3U);
  EXPECT_EQ(got.chunks[0].from.to_string(), "192.168.1.201:2112");
  EXPECT_EQ(got.chunks[0].to.to_string(), "255.255.255.255:40000");
  EXPECT_EQ(got.chunks[0].arrival, Stamp{1'000'000'000});
  EXPECT_TRUE(got.chunks[0].stream_start);
  EXPECT_EQ(got.chunks[1].bytes, "?");
  EXPECT_TRUE(got.chunks[1].stream_start);
  EXPECT_FALSE(got.chunks[2].stream_start);
  EXPECT_EQ(sent_by_device(got), "abcde");
  EXPECT_EQ(got.payloads.size(), 1U);
  EXPECT_EQ(got.counters.tcp_segments, 3U);
  EXPECT_EQ(got.counters.tcp.streams, 2U);
  EXPECT_EQ(got.counters.tcp.bytes, 6U);
  EXPECT_TRUE(adds_up(got.counters));
}

TEST(TcpCapture, ReadsSegmentsInEveryDress) {
  const Bytes one = tcp({'a'}, 100, 2112, 40000, tcp_ack, 0, 12);
  Bytes offloaded = ipv4(tcp({'b'}, 101), of_tcp());
  offloaded[2] = offloaded[3] = 0;  // the total length that the network card would have filled in
  const Bytes whole = tcp(counting(40, 'A'), 500);
  V4 first = of_tcp(), second = of_tcp();
  first.id = second.id = 3, first.more = true, second.offset = 24;
  const Contents got = read_capture(PcapBytes()
                                        .add(ethernet(ipv4(one, of_tcp()) + Bytes(6), {0x8100, 0x0800}))
                                        .add(ethernet(offloaded))
                                        .add(ethernet(ipv6(tcp({'c'}, 9), 6), {0x86dd}))
                                        .add(ethernet(ipv4({whole.begin() + 24, whole.end()}, second)))
                                        .add(ethernet(ipv4({whole.begin(), whole.begin() + 24}, first)))
                                        .bytes);
  ASSERT_EQ(got.chunks.size(), 4U);
  EXPECT_EQ(got.chunks[0].bytes, "a");
  EXPECT_EQ(got.chunks[1].bytes, "b");
  EXPECT_EQ(got.chunks[2].bytes, "c");
  EXPECT_EQ(got.chunks[2].from.to_string(), "[fe80::1]:2112");
  EXPECT_EQ(got.chunks[3].bytes, text(counting(40, 'A')));
  EXPECT_EQ(got.chunks[3].missing, 398U);
}

TEST(TcpCapture, HandsOnWhatWaitsBehindAHoleAtTheEnd) {
  const Contents got = read_capture(PcapBytes().add(frame("abc", 100), 1).add(frame("xyz", 110), 2).bytes);
  ASSERT_EQ(got.chunks.size(), 2U);
  EXPECT_EQ(got.chunks[1].bytes, "xyz");
  EXPECT_EQ(got.chunks[1].missing, 7U);
  EXPECT_EQ(got.chunks[1].arrival, Stamp{2'000'000'000});
  EXPECT_EQ(got.counters.tcp.holes, 1U);
  EXPECT_EQ(got.counters.tcp.missing, 7U);
}

TEST(TcpCapture, UsesWhatTheSnapshotLengthLeft) {
  Bytes cut = frame("abcdef", 100);
  const std::size_t length = cut.size();
  cut.resize(length - 4);
  const Contents got = read_capture(PcapBytes().add(cut, 1, length).add(frame("gh", 106), 2).bytes);
  ASSERT_EQ(got.chunks.size(), 2U);
  EXPECT_EQ(got.chunks[0].bytes, "ab");
  EXPECT_EQ(got.chunks[1].missing, 4U);
  EXPECT_EQ(got.counters.truncated, 1U);
  EXPECT_TRUE(adds_up(got.counters));
}

TEST(TcpCapture, CountsImpossibleSegments) {
  Bytes short_header = tcp({'a'}, 1), long_header = tcp({'a'}, 1);
  short_header[12] = 0x40;
  long_header[12] = 0xf0;
  V4 lying = of_tcp();
  lying.lie = 100;
  const Contents got = read_capture(PcapBytes()
                                        .add(ethernet(ipv4(short_header, of_tcp())))
                                        .add(ethernet(ipv4(long_header, of_tcp())))
                                        .add(ethernet(ipv4(tcp({'a'}, 1), lying)))
                                        .add(ethernet(ipv4(Bytes(19), of_tcp())))
                                        .bytes);
  EXPECT_TRUE(got.chunks.empty());
  EXPECT_EQ(got.counters.malformed, 4U);
  EXPECT_TRUE(adds_up(got.counters));
}

TEST(TcpCapture, BeginsItsStreamsAgainAfterARewind) {
  const MemoryFile file(PcapBytes().add(frame("abc", 100), 1).add(frame("xyz", 110), 2).bytes);
  PcapSource source(file.path());
  Packet packet;
  ASSERT_TRUE(source.next(packet));
  source.rewind();
  Contents first, second;
  read_all(source, first);
  source.rewind();
  read_all(source, second);
  for (const Contents* got : {&first, &second}) {
    EXPECT_EQ(sent_by_device(*got), "abcxyz");
    EXPECT_TRUE(got->chunks[0].stream_start);
  }
}

/// CoLa B: four times 02, length of the payload (32 bit, highest byte first), payload, XOR of its bytes (SICK
/// "Telegram Listing", framing). Counts telegrams that begin with `name`; fails where framing is lost.
std::size_t cola_b_telegrams(const std::string& stream, const std::string& name) {
  const ByteView bytes(stream);
  std::size_t count = 0;
  for (std::size_t at = 0; at < bytes.size();) {
    if (!bytes.has(at, 9) || bytes.be32(at) != 0x02020202U || !bytes.has(at + 8, bytes.be32(at + 4) + 1U)) {
      ADD_FAILURE() << "no telegram at byte " << at;
      return count;
    }
    const ByteView payload = bytes.sub(at + 8, bytes.be32(at + 4));
    std::uint8_t sum = 0;
    for (const std::uint8_t byte : payload) sum = static_cast<std::uint8_t>(sum ^ byte);
    EXPECT_EQ(sum, bytes.u8(at + 8 + payload.size())) << "at byte " << at;
    count += payload.text().substr(0, name.size()) == name ? 1U : 0U;
    at += 9 + payload.size();
  }
  return count;
}

struct RealCapture {
  const char* name;
  std::uint64_t segments;
  std::size_t bytes, bytes_to_device;
  std::size_t scans;
};
class RealTcpCapture : public ::testing::TestWithParam<RealCapture> {};

TEST_P(RealTcpCapture, HoldsTheBytesOfBothDirectionsWithoutAHole) {
  LIDARD_NEED_CAPTURE(path, std::string("sick/") + GetParam().name + ".pcap");
  const Contents got = read_capture(path);
  EXPECT_EQ(got.error, "");
  EXPECT_EQ(got.counters.tcp_segments, GetParam().segments);
  const std::string stream = sent_by_device(got);
  EXPECT_EQ(stream.size(), GetParam().bytes);
  EXPECT_EQ(got.counters.tcp.bytes - stream.size(), GetParam().bytes_to_device);
  EXPECT_EQ(got.counters.tcp.streams, 2U);
  EXPECT_EQ(got.counters.tcp.holes, 0U);
  EXPECT_TRUE(adds_up(got.counters));
  if (GetParam().scans == 0) return;
  EXPECT_EQ(cola_b_telegrams(stream, "sSN LMDscandata "), GetParam().scans);
}

/// The same conversation, its segments cut anew, disordered, doubled and overlapping.
TEST_P(RealTcpCapture, GivesTheSameStreamWhateverHappenedToTheSegments) {
  LIDARD_NEED_CAPTURE(path, std::string("sick/") + GetParam().name + ".pcap");
  const std::string stream = sent_by_device(read_capture(path));
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::mt19937 rng(seed);
    std::vector<Bytes> frames;
    for (std::size_t begin = 0; begin < stream.size();) {
      const std::size_t length = std::min<std::size_t>(stream.size() - begin, 1 + rng() % 2900);
      const std::size_t overlap = std::min<std::size_t>(begin, rng() % 3 == 0 ? rng() % 500 : 0);
      frames.push_back(frame(stream.substr(begin - overlap, length + overlap),
                             static_cast<std::uint32_t>(0xffff0000U + begin - overlap)));
      if (rng() % 5 == 0) frames.push_back(frames.back());
      begin += length;
    }
    for (std::size_t i = 1; i + 6 < frames.size(); ++i) std::swap(frames[i], frames[i + rng() % 6]);
    PcapBytes capture;
    capture.bytes.reserve(4 * stream.size());
    capture.add(frame("", 0xfffeffffU, tcp_syn));
    for (const Bytes& one : frames) capture.add(one);
    const Contents got = read_capture(capture.bytes);
    EXPECT_TRUE(sent_by_device(got) == stream) << "seed " << seed;
    EXPECT_EQ(got.counters.tcp.missing, 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(Sick, RealTcpCapture,
                         ::testing::Values(RealCapture{"lms111_colab_20210302", 560, 210500, 1138, 175},
                                           RealCapture{"lms511_colab_20210301", 832, 486327, 1516, 136},
                                           RealCapture{"tim781s_colab_20210125", 840, 476838, 1488, 140},
                                           RealCapture{"mrs1104_colab_20210722", 446, 222960, 1042, 96},
                                           RealCapture{"tim7xx_sopas_et_field_test", 1114, 935012, 0, 0},
                                           RealCapture{"rms1xxx_colaa_radar", 1630, 258452, 287, 0}),
                         [](const auto& capture) { return std::string(capture.param.name); });

/// The connections picked of chunks at some times, ms; capitals begin a connection.
std::string picked(const std::vector<std::pair<int, char>>& chunks) {
  ConnectionPicker picker;
  std::string out;
  for (const auto& [at, name] : chunks) {
    Packet chunk;
    chunk.arrival = Stamp{1'000'000'000'000LL + at * 1'000'000LL};
    chunk.stream_start = std::isupper(name) != 0;
    chunk.to.port = static_cast<std::uint16_t>(std::tolower(name));
    if (picker.pick(chunk)) out += chunk.stream_start ? static_cast<char>(std::toupper(name)) : name;
  }
  return out;
}

TEST(ConnectionPicker, FollowsTheNewestConnectionAndTheOldOneOnceThatIsSilent) {
  EXPECT_EQ(picked({{0, 'A'}, {20, 'a'}, {25, 'B'}, {40, 'b'}, {60, 'b'}}), "AaBbb") << "a reconnect";
  // A configuration tool asks twice while the driver's connection goes on.
  EXPECT_EQ(
      picked({{0, 'A'}, {20, 'a'}, {30, 'T'}, {40, 'a'}, {800, 't'}, {1790, 'a'}, {1810, 'a'}, {1830, 'a'}}),
      "AaTtAa");
  EXPECT_EQ(picked({{0, 'a'}, {20, 'a'}, {25, 'b'}, {40, 'a'}}), "Aaa") << "none begins in the capture";
  // A tool that asks on does not keep the place that it had while the scans paused.
  EXPECT_EQ(
      picked(
          {{0, 'T'}, {10, 'A'}, {500, 't'}, {1400, 't'}, {1700, 't'}, {2010, 'a'}, {2030, 'a'}, {2040, 't'}}),
      "TATtAa");
}

}  // namespace
}  // namespace lidard::test
