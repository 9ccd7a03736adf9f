// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/ip_packet.h"

#include <gtest/gtest.h>

#include "test/drivers/capture/pcap_testing.h"

namespace lidard::test {
namespace {

const Bytes datagram = udp({1, 2, 3, 4, 5});

Bytes copy(ByteView bytes) { return {bytes.begin(), bytes.end()}; }
Bytes head(const Bytes& bytes, std::size_t n) {
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n)};
}

TEST(IpPacket, ReadsAddressesProtocolAndTransportOfIpv4) {
  const Bytes bytes = ipv4(datagram);
  IpPacket packet;
  ASSERT_EQ(parse_ip(view(bytes), false, packet), HeaderResult::ok);
  EXPECT_EQ(packet.from.to_string(), "192.168.1.201");
  EXPECT_EQ(packet.to.to_string(), "255.255.255.255");
  EXPECT_EQ(packet.protocol, 17);
  EXPECT_EQ(copy(packet.transport), datagram);
  EXPECT_FALSE(packet.fragment.is_fragment);
  for (std::size_t n = 0; n < 20; ++n) {
    EXPECT_EQ(parse_ip(ByteView(bytes.data(), n), false, packet), HeaderResult::cut) << n;
  }
}

TEST(IpPacket, StepsOverIpv4Options) {
  V4 with_options;
  with_options.options = Bytes(40, 1);
  const Bytes bytes = ipv4(datagram, with_options);
  IpPacket packet;
  ASSERT_EQ(parse_ip(view(bytes), false, packet), HeaderResult::ok);
  EXPECT_EQ(copy(packet.transport), datagram);
  EXPECT_EQ(parse_ip(ByteView(bytes.data(), 59), false, packet), HeaderResult::cut);
}

TEST(IpPacket, KeepsPaddingOutOfTheTransport) {
  const Bytes bytes = ipv4(datagram) + Bytes(22, 0xa5);
  IpPacket packet;
  ASSERT_EQ(parse_ip(view(bytes), false, packet), HeaderResult::ok);
  EXPECT_EQ(copy(packet.transport), datagram);
  EXPECT_EQ(packet.captured.size(), datagram.size() + 22);
}

TEST(IpPacket, SaysWhenTheIpLengthPromisesMoreThanWasCaptured) {
  V4 lying;
  lying.lie = 694;
  const Bytes bytes = ipv4(datagram, lying);
  IpPacket packet;
  ASSERT_EQ(parse_ip(view(bytes), false, packet), HeaderResult::ok);
  EXPECT_TRUE(packet.shorter_than_declared);
  EXPECT_EQ(copy(packet.captured), datagram);
}

TEST(IpPacket, RefusesImpossibleHeaders) {
  Bytes bytes = ipv4(datagram);
  IpPacket packet;
  bytes[0] = 0x44;  // 16 bytes of header
  EXPECT_EQ(parse_ip(view(bytes), false, packet), HeaderResult::malformed);
  bytes[0] = 0x65;
  EXPECT_EQ(parse_ip(view(bytes), false, packet), HeaderResult::malformed);
  Bytes six = ipv6(datagram);
  six[0] = 0x45;
  EXPECT_EQ(parse_ip(view(six), true, packet), HeaderResult::malformed);
}

TEST(IpPacket, ReadsFragmentFieldsOfIpv4) {
  V4 part;
  part.id = 0xbeef, part.offset = 2960, part.more = true;
  const Bytes bytes = ipv4(Bytes(16), part);
  IpPacket packet;
  ASSERT_EQ(parse_ip(view(bytes), false, packet), HeaderResult::ok);
  EXPECT_TRUE(packet.fragment.is_fragment);
  EXPECT_TRUE(packet.fragment.more);
  EXPECT_EQ(packet.fragment.offset, 2960U);
  EXPECT_EQ(packet.fragment.id, 0xbeefU);
}

TEST(IpPacket, StepsOverEveryIpv6ExtensionHeader) {
  // Hop-by-hop (16 bytes), destination options, routing, mobility, HIP, shim6, authentication (24 bytes),
  // then UDP.
  const Bytes extensions = Bytes{60, 1} + Bytes(14) + Bytes{43, 0} + Bytes(6) + Bytes{135, 0} + Bytes(6) +
                           Bytes{139, 0} + Bytes(6) + Bytes{140, 0} + Bytes(6) + Bytes{51, 0} + Bytes(6) +
                           Bytes{17, 4} + Bytes(22);
  const Bytes bytes = ipv6(extensions + datagram, 0) + Bytes(9, 0xa5);
  IpPacket packet;
  ASSERT_EQ(parse_ip(view(bytes), true, packet), HeaderResult::ok);
  EXPECT_EQ(packet.protocol, 17);
  EXPECT_EQ(copy(packet.transport), datagram);
  EXPECT_EQ(packet.from.to_string(), "fe80::1");
  EXPECT_EQ(packet.to.to_string(), "ff02::2");
  for (std::size_t n = 0; n < 40 + extensions.size(); ++n) {
    EXPECT_EQ(parse_ip(ByteView(bytes.data(), n), true, packet), HeaderResult::cut) << n;
  }
}

TEST(IpPacket, StopsAtIpv6HeadersThatNothingLeadsPast) {
  IpPacket packet;
  for (const std::uint8_t next : Bytes{50, 59, 6, 58}) {
    ASSERT_EQ(parse_ip(view(ipv6(datagram, next)), true, packet), HeaderResult::ok);
    EXPECT_EQ(packet.protocol, next);
  }
}

TEST(IpPacket, ReadsFragmentFieldsOfIpv6AndTakesAnAtomicFragmentForAWholePacket) {
  IpPacket packet;
  const Bytes part = ipv6_fragment(Bytes(8), 0xdeadbeef, 1448, true);
  ASSERT_EQ(parse_ip(view(part), true, packet), HeaderResult::ok);
  EXPECT_TRUE(packet.fragment.is_fragment);
  EXPECT_EQ(packet.fragment.id, 0xdeadbeefU);
  EXPECT_EQ(packet.fragment.offset, 1448U);
  EXPECT_EQ(packet.transport.size(), 8U);
  const Bytes atomic = ipv6_fragment(datagram, 1, 0, false);
  ASSERT_EQ(parse_ip(view(atomic), true, packet), HeaderResult::ok);
  EXPECT_FALSE(packet.fragment.is_fragment);
  EXPECT_EQ(copy(packet.transport), datagram);
}

TEST(UdpDatagram, TrustsItsOwnLengthAndTheBytesAtHand) {
  UdpDatagram out;
  const Bytes padded = datagram + Bytes(10);
  ASSERT_EQ(parse_udp(view(padded), out), HeaderResult::ok);
  EXPECT_EQ(copy(out.payload), (Bytes{1, 2, 3, 4, 5}));
  EXPECT_EQ(out.from_port, 2368);
  EXPECT_EQ(out.to_port, 2369);
  for (std::size_t n = 0; n < datagram.size(); ++n) {
    EXPECT_EQ(parse_udp(view(head(datagram, n)), out), HeaderResult::cut) << n;
  }
  ASSERT_EQ(parse_udp(view(udp({})), out), HeaderResult::ok);
  EXPECT_TRUE(out.payload.empty());
  Bytes lying = datagram;
  lying[4] = 0, lying[5] = 7;
  EXPECT_EQ(parse_udp(view(lying), out), HeaderResult::malformed);
}

TEST(Ports, NoSocketHasPortZero) {
  UdpDatagram datagram_read;
  Bytes without_source = datagram, to_nobody = datagram;
  without_source[0] = without_source[1] = to_nobody[2] = to_nobody[3] = 0;
  EXPECT_EQ(parse_udp(view(without_source), datagram_read), HeaderResult::ok);
  EXPECT_EQ(parse_udp(view(to_nobody), datagram_read), HeaderResult::malformed);
  for (const std::size_t end : {0U, 2U}) {
    Bytes segment(20);
    segment[1] = segment[3] = 80, segment[12] = 0x50;
    IpPacket packet;
    packet.transport = packet.captured = view(segment);
    packet.declared = segment.size();
    TcpSegment read;
    EXPECT_EQ(parse_tcp(packet, read), HeaderResult::ok);
    segment[end + 1] = 0;
    EXPECT_EQ(parse_tcp(packet, read), HeaderResult::malformed);
  }
}

}  // namespace
}  // namespace lidard::test
