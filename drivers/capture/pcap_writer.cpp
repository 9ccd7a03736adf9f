// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/pcap_writer.h"

#include <pcap/pcap.h>

#include <algorithm>
#include <stdexcept>

namespace lidard {
namespace {

// IEEE 802.3, RFC 791, RFC 768.
constexpr std::size_t ethernet_bytes = 14;
constexpr std::size_t ip_bytes = 20;
constexpr std::size_t udp_bytes = 8;
constexpr std::size_t ip_at = ethernet_bytes;
constexpr std::size_t udp_at = ip_at + ip_bytes;
constexpr std::size_t payload_at = udp_at + udp_bytes;
constexpr unsigned udp_protocol = 17;
// RFC 793.
constexpr unsigned tcp_protocol = 6;
constexpr std::size_t tcp_bytes = 20;
constexpr std::uint8_t tcp_syn = 2, tcp_push = 8, tcp_ack = 16;
constexpr std::size_t largest_segment = 1448;

using Bytes = std::vector<std::uint8_t>;

/// Network byte order.
void put16(Bytes& bytes, std::size_t at, std::size_t value) {
  bytes[at] = static_cast<std::uint8_t>(value >> 8U & 0xffU);
  bytes[at + 1] = static_cast<std::uint8_t>(value & 0xffU);
}
void put(Bytes& bytes, std::size_t at, const std::uint8_t* data, std::size_t size) {
  std::copy(data, data + size, bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

// Sum of big-endian words (RFC 1071), not folded yet.
std::uint32_t word_sum(const Bytes& bytes, std::size_t from, std::size_t to) {
  std::uint32_t sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += (i - from) % 2 == 0 ? bytes[i] * 256U : bytes[i];
  return sum;
}

std::uint16_t checksum(std::uint32_t sum) {
  while (sum > 0xffff) sum = (sum & 0xffffU) + (sum >> 16U);
  return static_cast<std::uint16_t>(~sum & 0xffffU);
}

void put_hardware_address(Bytes& bytes, std::size_t at, const IpAddress& address) {
  const bool broadcast = address == IpAddress::v4(255, 255, 255, 255);
  const bool multicast = address.is_multicast();
  // Local addresses (IEEE 802, second bit of the first byte), multicast as in RFC 1112.
  const std::uint8_t prefix[2][3] = {{0x02, 0x00, 0x00}, {0x01, 0x00, 0x5e}};
  for (std::size_t i = 0; i < 6; ++i) {
    std::uint8_t byte = i < 3 ? prefix[multicast ? 1 : 0][i] : address.bytes[i - 2];
    if (multicast && i == 3) byte = static_cast<std::uint8_t>(byte & 0x7fU);
    if (!multicast && i == 2) byte = address.bytes[0];
    bytes[at + i] = static_cast<std::uint8_t>(broadcast ? 0xffU : byte);
  }
}

void put_ip(Bytes& bytes, const Endpoint& from, const Endpoint& to, std::size_t length, std::uint16_t id,
            unsigned protocol) {
  bytes[ip_at] = 0x45;
  put16(bytes, ip_at + 2, ip_bytes + length);
  put16(bytes, ip_at + 4, id);
  put16(bytes, ip_at + 6, 0x4000);  // do not fragment
  bytes[ip_at + 8] = 64;
  bytes[ip_at + 9] = static_cast<std::uint8_t>(protocol);
  put(bytes, ip_at + 12, from.address.bytes.data(), 4);
  put(bytes, ip_at + 16, to.address.bytes.data(), 4);
  put16(bytes, ip_at + 10, checksum(word_sum(bytes, ip_at, udp_at)));
}

void put_udp(Bytes& bytes, const Endpoint& from, const Endpoint& to, std::size_t length) {
  put16(bytes, udp_at, from.port);
  put16(bytes, udp_at + 2, to.port);
  put16(bytes, udp_at + 4, length);
  const std::uint32_t pseudo_header =
      word_sum(bytes, ip_at + 12, udp_at) + udp_protocol + static_cast<std::uint32_t>(length);
  const std::uint16_t sum = checksum(pseudo_header + word_sum(bytes, udp_at, bytes.size()));
  put16(bytes, udp_at + 6, sum == 0 ? 0xffffU : sum);
}

void put_tcp(Bytes& bytes, const Endpoint& from, const Endpoint& to, std::size_t length, TcpMark mark) {
  put16(bytes, udp_at, from.port);
  put16(bytes, udp_at + 2, to.port);
  put16(bytes, udp_at + 4, mark.sequence >> 16U);
  put16(bytes, udp_at + 6, mark.sequence & 0xffffU);
  put16(bytes, udp_at + 8, mark.acknowledged >> 16U);
  put16(bytes, udp_at + 10, mark.acknowledged & 0xffffU);
  bytes[udp_at + 12] = tcp_bytes / 4 << 4U;
  bytes[udp_at + 13] = mark.flags;
  put16(bytes, udp_at + 14, 0xffff);  // window
  const std::uint32_t pseudo_header =
      word_sum(bytes, ip_at + 12, udp_at) + tcp_protocol + static_cast<std::uint32_t>(length);
  put16(bytes, udp_at + 16, checksum(pseudo_header + word_sum(bytes, udp_at, bytes.size())));
}

}  // namespace

Bytes ethernet_tcp_frame(const Endpoint& from, const Endpoint& to, ByteView payload,
                         std::uint16_t identification, TcpMark mark) {
  Bytes bytes(udp_at + tcp_bytes + payload.size());
  put_hardware_address(bytes, 0, to.address);
  put_hardware_address(bytes, 6, from.address);
  put16(bytes, 12, 0x0800);
  put(bytes, udp_at + tcp_bytes, payload.data(), payload.size());
  const std::size_t length = tcp_bytes + payload.size();
  put_ip(bytes, from, to, length, identification, tcp_protocol);
  put_tcp(bytes, from, to, length, mark);
  return bytes;
}

Bytes ethernet_frame(const Endpoint& from, const Endpoint& to, ByteView payload,
                     std::uint16_t identification) {
  Bytes bytes(payload_at + payload.size());
  put_hardware_address(bytes, 0, to.address);
  put_hardware_address(bytes, 6, from.address);
  put16(bytes, 12, 0x0800);
  put(bytes, payload_at, payload.data(), payload.size());
  const std::size_t length = udp_bytes + payload.size();
  put_ip(bytes, from, to, length, identification, udp_protocol);
  put_udp(bytes, from, to, length);
  return bytes;
}

PcapWriter::PcapWriter(const std::string& path, int link_type, int snapshot_length)
    : path_(path),
      pcap_(pcap_open_dead_with_tstamp_precision(link_type, snapshot_length, PCAP_TSTAMP_PRECISION_NANO)) {
  if (pcap_ != nullptr) dumper_ = pcap_dump_open(pcap_, path.c_str());
  if (dumper_ != nullptr) return;
  const std::string reason = pcap_ != nullptr ? pcap_geterr(pcap_) : "out of memory";
  if (pcap_ != nullptr) pcap_close(pcap_);
  throw std::runtime_error(reason + "; name a file in a folder that exists and can be written");
}

PcapWriter::~PcapWriter() {
  if (dumper_ != nullptr) pcap_dump_close(dumper_);
  pcap_close(pcap_);
}

void PcapWriter::put(Stamp time, const std::vector<std::uint8_t>& frame) {
  write_frame(time, {frame.data(), frame.size()}, static_cast<std::uint32_t>(frame.size()));
}

void PcapWriter::write_frame(Stamp time, ByteView frame, std::uint32_t length) {
  pcap_pkthdr header{};
  header.ts.tv_sec = static_cast<decltype(header.ts.tv_sec)>(time.ns / 1'000'000'000);
  header.ts.tv_usec = static_cast<decltype(header.ts.tv_usec)>(time.ns % 1'000'000'000);
  header.caplen = static_cast<bpf_u_int32>(frame.size());
  header.len = length;
  pcap_dump(reinterpret_cast<u_char*>(dumper_), &header, frame.data());
  ++records_;
}

void PcapWriter::write(Stamp time, const Endpoint& from, const Endpoint& to, ByteView payload) {
  put(time, ethernet_frame(from, to, payload, identification_[from.address]++));
}

void PcapWriter::put_segment(Stamp time, const Endpoint& from, const Endpoint& to, ByteView payload,
                             std::uint8_t flags) {
  std::uint32_t& sequence = sequences_[{from, to}];
  const std::uint32_t acknowledged = (flags & tcp_ack) != 0 ? sequences_[{to, from}] : 0;
  put(time, ethernet_tcp_frame(from, to, payload, identification_[from.address]++,
                               {sequence, acknowledged, flags}));
  sequence += static_cast<std::uint32_t>(payload.size()) + ((flags & tcp_syn) != 0 ? 1U : 0U);
}

void PcapWriter::open_tcp(Stamp time, const Endpoint& client, const Endpoint& server) {
  put_segment(time, client, server, {}, tcp_syn);
  put_segment(time, server, client, {}, tcp_syn | tcp_ack);
  put_segment(time, client, server, {}, tcp_ack);
}

void PcapWriter::write_tcp(Stamp time, const Endpoint& from, const Endpoint& to, ByteView payload,
                           Span per_byte) {
  for (std::size_t at = 0; at < payload.size(); at += largest_segment) {
    const ByteView segment = payload.sub(at, std::min(largest_segment, payload.size() - at));
    put_segment(time + per_byte * static_cast<std::int64_t>(at), from, to, segment, tcp_push | tcp_ack);
  }
}

bool PcapWriter::has_failed() const { return std::ferror(pcap_dump_file(dumper_)) != 0; }

void PcapWriter::close() {
  const bool complete = pcap_dump_flush(dumper_) == 0 && !has_failed();
  pcap_dump_close(dumper_);
  dumper_ = nullptr;
  if (!complete) throw std::runtime_error(path_ + ": not everything could be written; make room on the disk");
}

}  // namespace lidard
