// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/time.h"
#include "drivers/address.h"

struct pcap;
struct pcap_dumper;

namespace lidard {

/// The Ethernet frame of a UDP datagram over IPv4, all checksums right. Hardware addresses are made from the
/// IP addresses.
std::vector<std::uint8_t> ethernet_frame(const Endpoint& from, const Endpoint& to, ByteView payload,
                                         std::uint16_t identification);

/// Where a segment stands in both directions of its connection.
struct TcpMark {
  std::uint32_t sequence = 0, acknowledged = 0;
  std::uint8_t flags = 0;
};
/// The Ethernet frame of a TCP segment over IPv4, all checksums right.
std::vector<std::uint8_t> ethernet_tcp_frame(const Endpoint& from, const Endpoint& to, ByteView payload,
                                             std::uint16_t identification, TcpMark mark);

/// Writes frames as they were captured, or those of UDP datagrams and TCP segments, to a pcap file with
/// nanoseconds.
class PcapWriter {
 public:
  /// Creates or empties the file; throws std::runtime_error. `link_type` is the DLT_ number of the frames, 1:
  /// Ethernet, as write() and write_tcp() make them.
  explicit PcapWriter(const std::string& path, int link_type = 1, int snapshot_length = 65535);
  ~PcapWriter();
  PcapWriter(const PcapWriter&) = delete;
  PcapWriter& operator=(const PcapWriter&) = delete;

  /// `length` is the frame's on the wire, of which `frame` may hold less.
  void write_frame(Stamp time, ByteView frame, std::uint32_t length);
  void write(Stamp time, const Endpoint& from, const Endpoint& to, ByteView payload);
  /// The handshake of a connection; without it a capture is joined in the middle of one.
  void open_tcp(Stamp time, const Endpoint& client, const Endpoint& server);
  /// Bytes of a connection, cut into segments, each `per_byte` of those before it later.
  void write_tcp(Stamp time, const Endpoint& from, const Endpoint& to, ByteView payload,
                 Span per_byte = Span(0));
  /// Records written so far.
  std::uint64_t records() const { return records_; }
  /// True if the disk did not accept everything; close() gives the reason.
  bool has_failed() const;
  /// Flushes and closes; throws std::runtime_error if the disk did not accept everything.
  void close();

 private:
  void put(Stamp time, const std::vector<std::uint8_t>& frame);
  void put_segment(Stamp time, const Endpoint& from, const Endpoint& to, ByteView payload,
                   std::uint8_t flags);

  std::string path_;
  pcap* pcap_ = nullptr;
  pcap_dumper* dumper_ = nullptr;
  std::uint64_t records_ = 0;
  std::map<IpAddress, std::uint16_t> identification_;                 // counts the datagrams of each sender
  std::map<std::pair<Endpoint, Endpoint>, std::uint32_t> sequences_;  // of the next byte from, to
};

}  // namespace lidard
