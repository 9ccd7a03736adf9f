// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/time.h"
#include "drivers/capture/ip_packet.h"

namespace lidard {

/// What came out of a fragment.
enum class DefragResult : std::uint8_t {
  waiting,   ///< kept (or dropped: see the counter); more must come
  complete,  ///< the packet is whole
  malformed  ///< not a possible fragment; not kept
};

/// Puts IP fragments together again, in whatever order they come.
///
/// Memory is bounded: at most `max_packets` unfinished packets of at most 65 535 bytes; the oldest gives way.
/// An unfinished packet is given up after `time_out` of capture time, as Linux does (net.ipv4.ipfrag_time).
/// Fragments that overlap with other content make the whole packet worthless (RFC 5722, and Linux for IPv4).
class IpDefragmenter {
 public:
  static constexpr std::size_t max_packets = 64;
  static constexpr Span time_out = std::chrono::seconds(30);

  /// Takes a fragment. When it completes its packet, `packet` becomes the whole one, whose bytes stay valid
  /// until the next call.
  DefragResult add(IpPacket& packet, Stamp now);
  /// No more input: gives up what is unfinished.
  void flush();

  /// Fragments that came twice, contradicted others, or belong to packets given up.
  std::uint64_t dropped() const { return dropped_; }
  /// Packets begun and not finished yet.
  std::size_t pending() const;
  /// Bytes held for them.
  std::size_t memory() const;

 private:
  struct Range {
    std::uint32_t begin, end;
  };
  struct Slot {
    bool used = false;
    IpAddress from, to;
    std::uint8_t protocol = 0;
    std::uint32_t id = 0;
    Stamp since;
    std::uint64_t fragments = 0;
    std::uint32_t total = 0;  // 0: the last fragment has not come yet
    std::vector<std::uint8_t> bytes;
    std::vector<Range> ranges;  // received, sorted, disjoint, never touching

    bool matches(const IpPacket& packet) const;
    bool whole() const;
    bool has_all(Range range) const;
    bool contradicts(const IpPacket& fragment, Range range) const;
    void store(ByteView content, Range range);
    void insert(Range range);
  };

  void expire(Stamp now);
  void give_up(Slot& slot);
  Slot& find_or_begin(const IpPacket& packet, Stamp now);

  std::vector<Slot> slots_;
  std::uint64_t dropped_ = 0;
};

}  // namespace lidard
