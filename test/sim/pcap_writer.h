// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/bytes.h"
#include "core/time.h"
#include "drivers/address.h"

struct pcap;
struct pcap_dumper;

namespace lidard::sim {

/// The Ethernet frame of a UDP datagram over IPv4, all checksums right. Hardware addresses are made from the
/// IP addresses.
std::vector<std::uint8_t> ethernet_frame(const Endpoint& from, const Endpoint& to, ByteView payload,
                                         std::uint16_t identification);

/// Writes UDP datagrams to a pcap file with nanoseconds.
class PcapWriter {
 public:
  /// Creates or empties the file; throws std::runtime_error.
  explicit PcapWriter(const std::string& path);
  ~PcapWriter();
  PcapWriter(const PcapWriter&) = delete;
  PcapWriter& operator=(const PcapWriter&) = delete;

  void write(Stamp time, const Endpoint& from, const Endpoint& to, ByteView payload);
  /// Records written so far.
  std::uint32_t records() const { return records_; }
  /// Flushes and closes; throws std::runtime_error if the disk did not take everything.
  void close();

 private:
  std::string path_;
  pcap* pcap_ = nullptr;
  pcap_dumper* dumper_ = nullptr;
  std::uint32_t records_ = 0;
  std::map<IpAddress, std::uint16_t> identification_;  // counts the datagrams of each sender
};

}  // namespace lidard::sim
