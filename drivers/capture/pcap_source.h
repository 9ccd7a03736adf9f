// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "drivers/capture/capture_reader.h"
#include "drivers/capture/ip_packet.h"
#include "drivers/capture/tcp_reassembler.h"
#include "drivers/driver.h"
#include "drivers/file_descriptor.h"

namespace lidard {

/// Counters of a capture. Every frame is counted in exactly one of datagrams, tcp_segments, not_ip, other_ip,
/// truncated, malformed, unsupported_link and fragments; a packet put together from fragments is counted in
/// `reassembled` and then once more like a frame. So frames + reassembled is the sum of those eight.
struct CaptureCounters {
  std::uint64_t frames = 0;        ///< records read
  std::uint64_t datagrams = 0;     ///< UDP datagrams handed on, put together from fragments or not
  std::uint64_t not_ip = 0;        ///< ARP, LLDP, ...
  std::uint64_t tcp_segments = 0;  ///< TCP segments, with or without payload
  std::uint64_t other_ip = 0;      ///< neither UDP nor TCP: ICMP, IGMP, ...
  /// Cut by the capture's snapshot length: record again with `tcpdump -s 0`. The captured part of a TCP
  /// segment is used.
  std::uint64_t truncated = 0;
  std::uint64_t malformed = 0;          ///< headers that contradict themselves
  std::uint64_t unsupported_link = 0;   ///< link-layer type we do not read
  std::uint64_t fragments = 0;          ///< IP fragments
  std::uint64_t reassembled = 0;        ///< datagrams put together from fragments
  std::uint64_t fragments_dropped = 0;  ///< fragments of datagrams that stayed incomplete, or came twice
  TcpCounters tcp;                      ///< of the streams that the segments make
};

/// The counters apart from losses.
constexpr NamedCounter<CaptureCounters> capture_counts[] = {
    {&CaptureCounters::frames, "frames", "frames"},
    {&CaptureCounters::datagrams, "datagrams", "datagrams"},
    {&CaptureCounters::tcp_segments, "tcp_segments", "TCP segments"},
    {&CaptureCounters::reassembled, "reassembled", "datagrams put together from fragments"}};
/// The counters of losses.
constexpr NamedCounter<CaptureCounters> capture_losses[] = {
    {&CaptureCounters::not_ip, "not_ip", "not IP"},
    {&CaptureCounters::other_ip, "other_ip", "neither UDP nor TCP (ICMP, IGMP)"},
    {&CaptureCounters::truncated, "truncated", "cut by the snapshot length (record with tcpdump -s 0)"},
    {&CaptureCounters::malformed, "malformed", "malformed"},
    {&CaptureCounters::unsupported_link, "unsupported_link", "of an unsupported link type"},
    {&CaptureCounters::fragments, "fragments", "fragments"},
    {&CaptureCounters::fragments_dropped, "fragments_dropped", "fragments without use"}};

/// Reads UDP datagrams, and TCP streams in both directions, from a capture file: pcap and pcapng, both byte
/// orders, us and ns, as they are or packed (gzip, zstd); Ethernet, VLAN, QinQ, Linux cooked v1 and v2,
/// raw IP, null and loop; IPv4 (options, fragments) and IPv6.
class PcapSource {
 public:
  /// Opens the file; "-" is standard input. A pipe is read to its end first, into a temporary file that all
  /// sources of the process share. Throws CaptureError.
  explicit PcapSource(const std::string& path);

  /// The next datagram or chunk of a TCP stream (Packet::transport says which), or false at the end. The
  /// payload stays valid until the next call. A broken record ends the capture: the call returns false, and
  /// `error()` says what and where.
  bool next(Packet& packet);
  /// Why the capture ended early; empty if it did not.
  const std::string& error() const { return error_; }
  /// True if error() is more than an unfinished last record, as of a recording that was stopped.
  bool is_damaged() const { return !error_.empty() && (records_ == 0 || !reader_->ends_in_record()); }
  CaptureCounters counters() const {
    CaptureCounters all = counters_;
    all.tcp = tcp_.counters();
    return all;
  }
  /// Bytes of the file read and in all, for a progress display.
  std::uint64_t position() const { return reader_->position(); }
  std::uint64_t size() const { return size_; }
  /// Starts again from the first record; counters go on.
  void rewind();

 private:
  bool decode(const CaptureRecord& record, Packet& packet);
  bool add_fragment(IpPacket& ip, bool snapped, Packet& packet);
  bool decode_transport(const IpPacket& ip, bool snapped, Packet& packet);
  void add_segment(const IpPacket& ip, bool snapped, Stamp stamp);
  bool count(HeaderResult result, bool snapped);
  void end();

  std::string name_;
  FileDescriptor file_;  // kept, so that a rewind finds the same file even where its name is gone
  std::uint64_t size_ = 0;
  std::unique_ptr<CaptureReader> reader_;
  IpDefragmenter defragmenter_;
  TcpReassembler tcp_;
  CaptureCounters counters_;
  std::uint64_t records_ = 0;  // since the last rewind
  bool ended_ = false;
  std::string error_;
};

/// Several captures read as one, in the order of their stamps: one file per sensor, or one recording in
/// pieces.
class MergedCapture {
 public:
  /// Throws CaptureError.
  explicit MergedCapture(const std::vector<std::string>& paths);

  /// The next datagram of all files; its payload stays valid until the next call.
  bool next(Packet& packet);
  void rewind();
  /// Messages of files that ended early.
  std::vector<std::string> errors() const;
  /// True if one of them is damaged: more is missing than an unfinished last record.
  bool is_damaged() const;
  /// Sum over the files.
  CaptureCounters counters() const;
  /// Part of the bytes read, 0 ... 1.
  double progress() const;

 private:
  struct File {
    PcapSource source;
    Packet packet;
    bool ready = false;
  };
  void fill(File& file) { file.ready = file.source.next(file.packet); }

  std::vector<File> files_;
  File* given_ = nullptr;  // whose packet the caller holds
};

/// Picks the chunks of the newest of a device's connections, or of an older one while that is silent. A
/// capture may hold several (a configuration tool beside the driver, or one after the other), whose telegrams
/// must not be mixed.
class ConnectionPicker {
 public:
  /// True if the chunk, which the device sent, is of the connection that counts; the first one of a
  /// connection is marked as the start of its stream.
  bool pick(Packet& packet) {
    const auto is_silent = [&](Stamp last) {
      return std::chrono::abs(packet.arrival - last) > std::chrono::seconds(1);
    };
    if (!newest_ || packet.stream_start) newest_ = packet.to;
    const bool is_newest = *newest_ == packet.to;
    const bool goes_on = peer_ && *peer_ == packet.to;
    if (!is_newest && (!is_silent(newest_at_) || !(goes_on || is_silent(last_)))) return false;
    packet.stream_start = packet.stream_start || !goes_on;
    peer_ = packet.to;
    last_ = packet.arrival;
    if (is_newest) newest_at_ = packet.arrival;
    return true;
  }
  /// The capture starts again.
  void restart() { *this = {}; }

 private:
  std::optional<Endpoint> newest_;
  std::optional<Endpoint> peer_;  // whose chunks are picked
  Stamp newest_at_{}, last_{};    // of their last chunks
};

}  // namespace lidard
