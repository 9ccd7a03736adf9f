// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "drivers/capture/ip_packet.h"
#include "drivers/driver.h"

namespace lidard {

/// Counters of the TCP segments of a capture.
struct TcpCounters {
  std::uint64_t streams = 0;       ///< directions of connections, from their begin or joined in the middle
  std::uint64_t bytes = 0;         ///< handed on
  std::uint64_t duplicates = 0;    ///< segments that brought nothing new: sent again, keep-alives
  std::uint64_t out_of_order = 0;  ///< segments that waited for an earlier one
  std::uint64_t holes = 0;         ///< places where bytes never came
  std::uint64_t missing = 0;       ///< those bytes
};

/// The counters apart from losses.
constexpr NamedCounter<TcpCounters> tcp_counts[] = {
    {&TcpCounters::streams, "tcp_streams", "TCP streams"},
    {&TcpCounters::bytes, "tcp_bytes", "bytes of TCP streams"},
    {&TcpCounters::duplicates, "tcp_duplicates", "TCP segments that brought nothing new"},
    {&TcpCounters::out_of_order, "tcp_out_of_order", "TCP segments that waited for an earlier one"}};
constexpr NamedCounter<TcpCounters> tcp_losses[] = {
    {&TcpCounters::holes, "tcp_holes", "holes in TCP streams"},
    {&TcpCounters::missing, "tcp_missing", "bytes missing in TCP streams"}};

/// Makes streams of TCP segments, one per connection and direction.
///
/// A stream waits at a hole for its bytes, as the receiver had to. The hole is given up when the receiver
/// acknowledged the missing bytes (only the capture lost them), when too much waits behind it, or after
/// `patience` of capture time.
///
/// Use: add() a segment, then call next() until it returns false.
class TcpReassembler {
 public:
  static constexpr std::size_t max_streams = 1024;  ///< the one silent for longest gives way
  static constexpr std::size_t max_waiting_bytes = std::size_t{512} * 1024;  ///< behind the holes of a stream
  static constexpr std::size_t max_waiting_segments = 1024;                  ///< behind the holes of a stream
  static constexpr std::size_t max_waiting_total = 16'777'216;               ///< bytes, of all streams
  static constexpr std::int32_t window = 4 * 1024 * 1024;    ///< bytes; farther off: another connection
  static constexpr Span patience = std::chrono::seconds(3);  ///< with holes
  static constexpr Span acknowledged =
      std::chrono::milliseconds(10);  ///< with holes the receiver does not have

  /// The segment's bytes must stay valid until next() returned false.
  void add(const TcpSegment& segment, const IpAddress& from, const IpAddress& to, Stamp now);
  /// Time passed: gives up holes that are too old.
  void expire(Stamp now);
  /// No more segments: gives up all holes.
  void flush();
  /// Forgets all streams; counters go on.
  void restart();
  /// The next chunk, whose payload is valid until the next call. `arrival` is when a receiver could read it.
  bool next(Packet& packet);

  const TcpCounters& counters() const { return counters_; }
  /// Bytes that wait behind holes.
  std::size_t waiting() const { return waiting_bytes_; }
  /// Streams that are remembered.
  std::size_t streams() const { return streams_.size(); }

 private:
  using Key = std::pair<Endpoint, Endpoint>;
  /// A position in a stream: the sequence number with its wraps.
  using Position = std::uint64_t;
  static constexpr Position nowhere = std::numeric_limits<Position>::max();

  struct Waiting {
    std::vector<std::uint8_t> bytes;
    std::uint32_t length = 0;  // as sent; more than bytes.size() where the snapshot length cut
    Stamp stamp;
  };
  struct Stream {
    Position begin = 0;
    Position next = 0;       // first byte not handed on
    Position end = nowhere;  // behind it only another connection can go on
    bool fresh = true;       // nothing was handed on yet
    std::uint64_t missing = 0;
    std::map<Position, Waiting> waiting;
    std::size_t waiting_bytes = 0;
    Stamp hole_since{};
    bool hole_acknowledged = false;
    Stamp acknowledged_since{};
    Stamp used{};

    /// Where `sequence` is, the nearest to `next`.
    Position position(std::uint32_t sequence) const;
    bool is_within_window(std::uint32_t sequence) const;
  };
  using Streams = std::map<Key, Stream>;
  struct Chunk {
    Key key;
    ByteView view;                    // of the segment being added, or of `bytes`
    std::vector<std::uint8_t> bytes;  // where the segment had to wait
    Stamp stamp;
    std::uint64_t missing = 0;
    bool fresh = false;
  };

  Streams::iterator find_or_begin(const Key& key, std::uint32_t sequence, Stamp now);
  void make_room();
  void begin_again(Streams::iterator at, std::uint32_t sequence);
  void apply_flags(const TcpSegment& segment, Streams::iterator at);
  void add_bytes(const TcpSegment& segment, Streams::iterator at, Stamp now);
  void keep(const TcpSegment& segment, Position begin, Stream& stream, Stamp now);
  void note_acknowledgement(const TcpSegment& segment, const Key& answered, Stamp now);
  void release(Streams::iterator at, Stamp not_before);
  void skip_hole(Streams::iterator at);
  void give_up(Streams::iterator at);
  bool is_hopeless(const Stream& stream, Stamp now) const;
  void give_up_hopeless(Streams::iterator at, Stamp now);
  void advance(Streams::iterator at, std::size_t length, Chunk chunk);

  Streams streams_;
  std::vector<Chunk> ready_;
  std::size_t ready_next_ = 0;
  std::size_t waiting_bytes_ = 0;
  std::size_t waiting_streams_ = 0;
  TcpCounters counters_;
};

}  // namespace lidard
