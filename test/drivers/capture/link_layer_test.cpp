// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "drivers/capture/ip_packet.h"
#include "test/drivers/capture/pcap_testing.h"

namespace lidard::test {
namespace {

struct Found {
  HeaderResult result;
  Bytes bytes;
  bool v6;
};

Found find(std::uint32_t link_type, const Bytes& frame) {
  LinkPayload payload;
  const HeaderResult result = find_ip(link_type, view(frame), payload);
  return {result, Bytes(payload.bytes.begin(), payload.bytes.end()), payload.v6};
}

const Bytes v4 = ipv4(udp({1, 2, 3}));
const Bytes v6 = ipv6(udp({4, 5}));

/// Finds `ip` behind `header`, and calls every shorter frame cut as long as the header is not whole.
void expect_found(std::uint32_t link_type, const Bytes& header, const Bytes& ip, bool is_v6) {
  const Found found = find(link_type, header + ip);
  EXPECT_EQ(found.result, HeaderResult::ok) << "link type " << link_type;
  EXPECT_EQ(found.bytes, ip) << "link type " << link_type;
  EXPECT_EQ(found.v6, is_v6) << "link type " << link_type;
  for (std::size_t n = 0; n < header.size(); ++n) {
    const Bytes part(header.begin(), header.begin() + static_cast<std::ptrdiff_t>(n));
    EXPECT_EQ(find(link_type, part).result, HeaderResult::cut)
        << "link type " << link_type << ", " << n << " bytes";
  }
}

TEST(LinkLayer, FindsIpBehindEthernetAndAnyNumberOfVlanTags) {
  expect_found(1, ethernet({}), v4, false);
  expect_found(1, ethernet({}, {0x86dd}), v6, true);
  for (const std::uint16_t tag : std::vector<std::uint16_t>{0x8100, 0x88a8, 0x9100, 0x9200})
    expect_found(1, ethernet({}, {tag, 0x0800}), v4, false);
  expect_found(1, ethernet({}, {0x88a8, 0x8100, 0x0800}), v4, false);
  expect_found(1, ethernet({}, {0x9100, 0x88a8, 0x8100, 0x8100, 0x86dd}), v6, true);
}

TEST(LinkLayer, FindsIpBehindLinuxCookedHeaders) {
  const Bytes sll = Bytes{0, 0, 0, 1, 0, 6, 1, 2, 3, 4, 5, 6, 0, 0};
  expect_found(113, sll + Bytes{0x08, 0x00}, v4, false);
  expect_found(113, sll + Bytes{0x86, 0xdd}, v6, true);
  expect_found(113, sll + Bytes{0x81, 0x00, 0, 7, 0x08, 0x00}, v4, false);
  const Bytes sll2 = Bytes{0, 0, 0, 0, 0, 2, 0, 1, 0, 6, 1, 2, 3, 4, 5, 6, 0, 0};
  expect_found(276, Bytes{0x08, 0x00} + sll2, v4, false);
  expect_found(276, Bytes{0x86, 0xdd} + sll2, v6, true);
}

TEST(LinkLayer, FindsRawIpByItsVersion) {
  for (const std::uint32_t link_type : {12U, 14U, 101U}) {
    expect_found(link_type, {}, v4, false);
    expect_found(link_type, {}, v6, true);
    EXPECT_EQ(find(link_type, {}).result, HeaderResult::cut);
    EXPECT_EQ(find(link_type, {0x50, 0}).result, HeaderResult::not_ip);
  }
  expect_found(228, {}, v4, false);
  expect_found(229, {}, v6, true);
}

TEST(LinkLayer, ReadsNullAndLoopInEitherByteOrder) {
  for (const std::uint32_t link_type : {0U, 108U}) {
    expect_found(link_type, {2, 0, 0, 0}, v4, false);
    expect_found(link_type, {0, 0, 0, 2}, v4, false);
    for (const std::uint8_t family : Bytes{10, 24, 28, 30}) {
      expect_found(link_type, {family, 0, 0, 0}, v6, true);
      expect_found(link_type, {0, 0, 0, family}, v6, true);
    }
    EXPECT_EQ(find(link_type, {7, 0, 0, 0, 1}).result, HeaderResult::not_ip);
  }
}

TEST(LinkLayer, SaysWhatIsNotIpAndWhatItDoesNotRead) {
  EXPECT_EQ(find(1, ethernet(v4, {0x0806})).result, HeaderResult::not_ip);
  EXPECT_EQ(find(1, ethernet(v4, {0x8100, 0x88cc})).result, HeaderResult::not_ip);
  EXPECT_EQ(find(1, ethernet(v4, {60})).result, HeaderResult::not_ip);  // IEEE 802.3 length
  EXPECT_EQ(find(105, v4).result, HeaderResult::unsupported);           // IEEE 802.11
}

}  // namespace
}  // namespace lidard::test
