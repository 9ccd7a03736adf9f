// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/drivers/capture/pcap_testing.h"

namespace lidard::test {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

const Bytes odd_payload = counting(41);  // odd, so that the block needs padding
const Bytes odd_frame = ethernet(ipv4(udp(odd_payload)));

/// Builds a pcapng file.
class Pcapng {
 public:
  explicit Pcapng(bool big_endian = false) { section(big_endian); }

  Pcapng& section(bool big_endian, std::uint16_t major = 1) {
    big_endian_ = big_endian;
    return block(0x0a0d0d0a, u(0x1a2b3c4d, 4) + u(major, 2) + u(0, 2) + u(~std::uint64_t{0}, 8));
  }
  Pcapng& interface(std::uint16_t link_type = 1, const Bytes& options = {}, std::uint32_t snapshot = 0) {
    return block(1, u(link_type, 2) + u(0, 2) + u(snapshot, 4) + options);
  }
  Bytes option(std::uint16_t code, const Bytes& value) const {
    return u(code, 2) + u(value.size(), 2) + padded(value);
  }
  Pcapng& enhanced(const Bytes& data, std::uint64_t ticks = 0, std::uint32_t interface = 0,
                   std::size_t length = 0) {
    return block(6, u(interface, 4) + u(ticks >> 32U, 4) + u(ticks, 4) + u(data.size(), 4) +
                        u(length == 0 ? data.size() : length, 4) + padded(data));
  }
  Pcapng& obsolete(const Bytes& data, std::uint64_t ticks, std::uint16_t interface) {
    return block(2, u(interface, 2) + u(3, 2) + u(ticks >> 32U, 4) + u(ticks, 4) + u(data.size(), 4) +
                        u(data.size(), 4) + padded(data));
  }
  Pcapng& simple(const Bytes& data, std::size_t length) { return block(3, u(length, 4) + padded(data)); }
  Pcapng& block(std::uint32_t type, const Bytes& body) {
    last = bytes.size();
    bytes = bytes + u(type, 4) + u(body.size() + 12, 4) + body + u(body.size() + 12, 4);
    return *this;
  }
  Bytes u(std::uint64_t value, std::size_t n) const { return big_endian_ ? big(value, n) : little(value, n); }

  Bytes bytes;
  std::size_t last = 0;  ///< where the last block begins

 private:
  static Bytes padded(const Bytes& data) { return data + Bytes((4 - data.size() % 4) % 4); }
  bool big_endian_ = false;
};

TEST(Pcapng, ReadsEnhancedSimpleAndObsoletePacketsOfEitherByteOrder) {
  for (const bool big_endian : {false, true}) {
    const Contents got = read_capture(Pcapng(big_endian)
                                          .interface()
                                          .enhanced(odd_frame, 1'700'000'000'250'000)
                                          .simple(odd_frame, odd_frame.size())
                                          .obsolete(odd_frame, 1'700'000'001'000'000, 0)
                                          .bytes);
    EXPECT_EQ(got.error, "");
    EXPECT_THAT(got.payloads, ElementsAre(text(odd_payload), text(odd_payload), text(odd_payload)));
    EXPECT_EQ(got.stamps[0].ns, 1'700'000'000'250'000'000);
    EXPECT_EQ(got.stamps[1], got.stamps[0]);
    EXPECT_EQ(got.stamps[2].ns, 1'700'000'001'000'000'000);
  }
}

std::int64_t stamp(std::uint8_t resolution, std::uint64_t ticks, std::int64_t offset_s = 0) {
  Pcapng file;
  const Bytes options = file.option(9, {resolution}) +
                        file.option(14, file.u(static_cast<std::uint64_t>(offset_s), 8)) +
                        file.option(0, {}) + file.option(9, {1});
  return read_capture(file.interface(1, options).enhanced(odd_frame, ticks).bytes).stamps.at(0).ns;
}

TEST(Pcapng, ReadsResolutionsThatArePowersOfTen) {
  EXPECT_EQ(stamp(0, 1'700'000'000), 1'700'000'000'000'000'000);
  EXPECT_EQ(stamp(3, 1'700'000'000'123), 1'700'000'000'123'000'000);
  EXPECT_EQ(stamp(9, 1'700'000'000'123'456'789), 1'700'000'000'123'456'789);
  EXPECT_EQ(stamp(12, 5'123'456'789'999), 5'123'456'789);
  EXPECT_EQ(stamp(19, 15'000'000'000'000'000'000U), 1'500'000'000);
  EXPECT_EQ(stamp(20, 15'000'000'000'000'000'000U), 150'000'000);
  EXPECT_EQ(stamp(0x7f, ~std::uint64_t{0}), 1'000'000'000) << "a record without a time";
}

TEST(Pcapng, ReadsResolutionsThatArePowersOfTwo) {
  EXPECT_EQ(stamp(0x80, 7), 7'000'000'000);
  EXPECT_EQ(stamp(0x81, 3), 1'500'000'000);
  EXPECT_EQ(stamp(0x80 | 32, 3ULL << 31U), 1'500'000'000);
  EXPECT_EQ(stamp(0x80 | 63, 3ULL << 62U), 1'500'000'000);
  EXPECT_EQ(stamp(0x80 | 64, 3ULL << 62U), 750'000'000);
  EXPECT_EQ(stamp(0xff, ~std::uint64_t{0}), 1'000'000'000) << "a record without a time";
}

TEST(Pcapng, AddsTheOffsetOfTheInterfaceWhicheverSignItHas) {
  EXPECT_EQ(stamp(6, 250'000, 1'700'000'000), 1'700'000'000'250'000'000);
  EXPECT_EQ(stamp(6, 1'700'000'000'250'000, -3600), 1'699'996'400'250'000'000);
}

TEST(Pcapng, KeepsStampsWithinWhatCanBeSubtracted) {
  const std::int64_t late = stamp(0, ~std::uint64_t{0}, std::numeric_limits<std::int64_t>::max());
  const std::int64_t early = stamp(0, 0, std::numeric_limits<std::int64_t>::min());
  EXPECT_GT(late, 0);
  EXPECT_LT(early, 0);
  EXPECT_LT(late, std::numeric_limits<std::int64_t>::max() / 2);
  EXPECT_GT(early, std::numeric_limits<std::int64_t>::min() / 2);
}

TEST(Pcapng, ReadsInterfacesOfDifferentLinkTypesAndSectionsOfDifferentByteOrder) {
  const Contents got = read_capture(Pcapng()
                                        .interface(1)
                                        .interface(101)
                                        .enhanced(ipv4(udp({1})), 0, 1)
                                        .enhanced(ethernet(ipv4(udp({2}))), 0, 0)
                                        .section(true)
                                        .interface(101)
                                        .enhanced(ipv4(udp({3})))
                                        .bytes);
  EXPECT_EQ(got.error, "");
  EXPECT_THAT(got.payloads, ElementsAre("\x01", "\x02", "\x03"));
}

TEST(Pcapng, StepsOverBlocksItDoesNotKnow) {
  const Contents got = read_capture(Pcapng()
                                        .block(4, Bytes(8))
                                        .interface()
                                        .block(5, Bytes(40))
                                        .block(0x40000bad, {})
                                        .block(0xa, Bytes(5000))
                                        .enhanced(odd_frame)
                                        .block(0xbad, Bytes(16))
                                        .bytes);
  EXPECT_EQ(got.error, "");
  EXPECT_EQ(got.payloads.size(), 1U);
}

TEST(Pcapng, CutsASimplePacketAtTheSnapshotLength) {
  const Bytes part(odd_frame.begin(), odd_frame.begin() + 60);
  const Contents got = read_capture(Pcapng().interface(1, {}, 60).simple(part, odd_frame.size()).bytes);
  EXPECT_EQ(got.error, "");
  EXPECT_EQ(got.counters.truncated, 1U);
}

/// The file reads `before` payloads and then ends with `what` at the last block.
void expect_broken(const Pcapng& file, const std::string& what, std::size_t before = 1) {
  const Contents got = read_capture(file.bytes);
  EXPECT_EQ(got.payloads.size(), before) << what;
  EXPECT_THAT(got.error, HasSubstr(what));
  EXPECT_THAT(got.error,
              EndsWith(" at byte " + std::to_string(file.last) + "; what came before it was used"));
}

Pcapng one_packet() { return Pcapng().interface().enhanced(odd_frame); }

TEST(Pcapng, EndsAtABlockThatLies) {
  Pcapng length = one_packet().enhanced(odd_frame);
  length.bytes[length.last + 4] ^= 1U;
  expect_broken(length, "block of the impossible length");
  length = one_packet().enhanced(odd_frame);
  length.bytes[length.last + 7] = 0x7f;
  expect_broken(length, "block of the impossible length");
  Pcapng trailer = one_packet().enhanced(odd_frame);
  trailer.bytes[trailer.bytes.size() - 4] ^= 4U;
  expect_broken(trailer, "whose two lengths differ");
  Pcapng skipped = one_packet().block(0xbad, Bytes(16));
  skipped.bytes[skipped.bytes.size() - 4] ^= 4U;
  expect_broken(skipped, "whose two lengths differ");
  Pcapng captured = one_packet().enhanced(odd_frame);
  captured.bytes[captured.last + 22] = 1;
  expect_broken(captured, "bytes in a block that holds");
}

TEST(Pcapng, EndsAtAPacketOrSectionThatCannotBe) {
  expect_broken(one_packet().enhanced(odd_frame, 0, 1), "packet of undescribed interface 1");
  expect_broken(one_packet().obsolete(odd_frame, 0, 7), "packet of undescribed interface 7");
  expect_broken(one_packet().section(false).enhanced(odd_frame), "packet of undescribed interface 0");
  expect_broken(one_packet().section(false).simple(odd_frame, odd_frame.size()),
                "packet of undescribed interface 0");
  expect_broken(one_packet().block(6, Bytes(16)), "packet block too short");
  expect_broken(one_packet().block(2, Bytes(16)), "packet block too short");
  expect_broken(one_packet().block(3, {}), "packet block too short");
  expect_broken(one_packet().block(1, Bytes(4)), "interface description too short");
  expect_broken(one_packet().simple(Bytes(8), 9000), "packet of 9000 bytes in a block that holds 8");
  expect_broken(one_packet().section(false, 2), "section of an unknown version");
  expect_broken(one_packet().block(0x0a0d0d0a, Bytes(16)), "section without a byte-order magic");
  Pcapng magic_only = one_packet();
  magic_only.block(0x0a0d0d0a, magic_only.u(0x1a2b3c4d, 4));
  expect_broken(magic_only, "section of an unknown version");
}

TEST(Pcapng, RefusesABlockBeyondReasonWithoutReadingIt) {
  for (const std::uint32_t type : {6U, 0xbadU})
    expect_broken(one_packet().block(type, Bytes((16U << 20U) + 4)), "block of the impossible length");
}

TEST(Pcapng, KeepsWhatCameBeforeACutBlock) {
  const Pcapng whole = one_packet().enhanced(odd_frame);
  for (std::size_t size = whole.last + 1; size < whole.bytes.size(); ++size) {
    Pcapng cut = whole;
    cut.bytes.resize(size);
    expect_broken(cut, "block cut by the end of the file");
    EXPECT_FALSE(read_capture(cut.bytes).damaged) << "a recording was stopped";
  }
}

TEST(Pcapng, IgnoresOptionsThatRunOutOfTheirBlock) {
  Pcapng file;
  const Contents got =
      read_capture(file.interface(1, file.u(9, 2) + file.u(4000, 2)).enhanced(odd_frame, 1'000'000).bytes);
  ASSERT_EQ(got.stamps.size(), 1U);
  EXPECT_EQ(got.stamps[0].ns, 1'000'000'000);
}

TEST(Pcapng, StartsAgain) {
  const MemoryFile file(one_packet().section(true).interface().enhanced(odd_frame).bytes);
  PcapSource source(file.path());
  Contents first, second;
  read_all(source, first);
  source.rewind();
  read_all(source, second);
  EXPECT_EQ(first.payloads.size(), 2U);
  EXPECT_EQ(first.payloads, second.payloads);
}

}  // namespace
}  // namespace lidard::test
