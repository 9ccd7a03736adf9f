// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/tcp_reassembler.h"

#include <algorithm>

namespace lidard {
namespace {

/// Keeps every position above zero.
constexpr std::uint64_t first_wrap = std::uint64_t{1} << 32U;

/// Signed distance of sequence numbers, which wrap (RFC 9293 section 3.4).
std::int32_t distance(std::uint32_t from, std::uint64_t to) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(to) - from);
}

}  // namespace

TcpReassembler::Position TcpReassembler::Stream::position(std::uint32_t sequence) const {
  return next - static_cast<Position>(static_cast<std::int64_t>(distance(sequence, next)));
}

bool TcpReassembler::Stream::is_within_window(std::uint32_t sequence) const {
  const std::int32_t off = distance(sequence, next);
  return off > -window && off < window;
}

void TcpReassembler::add(const TcpSegment& segment, const IpAddress& from, const IpAddress& to, Stamp now) {
  const Key key{{from, segment.from_port}, {to, segment.to_port}};
  if (waiting_streams_ > 0) {
    if (segment.ack) note_acknowledgement(segment, {key.second, key.first}, now);
    expire(now);
  }
  auto at = streams_.find(key);
  if (at == streams_.end()) {
    if (!segment.syn && segment.length == 0) return;
    at = find_or_begin(key, segment.sequence + (segment.syn ? 1U : 0U), now);
  }
  at->second.used = now;
  apply_flags(segment, at);
  if (segment.length > 0) add_bytes(segment, at, now);
  if (segment.fin && at->second.is_within_window(segment.sequence))
    at->second.end = at->second.position(segment.sequence + segment.length);
}

TcpReassembler::Streams::iterator TcpReassembler::find_or_begin(const Key& key, std::uint32_t sequence,
                                                                Stamp now) {
  if (streams_.size() >= max_streams) make_room();
  const auto at = streams_.emplace(key, Stream{}).first;
  at->second.used = now;
  begin_again(at, sequence);
  return at;
}

void TcpReassembler::make_room() {
  const auto oldest = std::min_element(streams_.begin(), streams_.end(), [](const auto& a, const auto& b) {
    return a.second.used < b.second.used;
  });
  give_up(oldest);
  streams_.erase(oldest);
}

void TcpReassembler::begin_again(Streams::iterator at, std::uint32_t sequence) {
  give_up(at);
  Stream& stream = at->second;
  stream.begin = stream.next = first_wrap + sequence;
  stream.end = nowhere;
  stream.fresh = true;
  stream.missing = 0;
  ++counters_.streams;
}

void TcpReassembler::apply_flags(const TcpSegment& segment, Streams::iterator at) {
  Stream& stream = at->second;
  if (segment.syn) {
    // The same SYN sent again begins nothing.
    if (static_cast<std::uint32_t>(stream.begin) != segment.sequence + 1U)
      begin_again(at, segment.sequence + 1U);
  } else if (segment.rst && stream.is_within_window(segment.sequence)) {
    give_up(at);
    stream.end = stream.next;
    const auto other = streams_.find({at->first.second, at->first.first});
    if (other == streams_.end()) return;
    give_up(other);
    other->second.end = other->second.next;
  }
}

void TcpReassembler::add_bytes(const TcpSegment& segment, Streams::iterator at, Stamp now) {
  const std::uint32_t sequence = segment.sequence + (segment.syn ? 1U : 0U);
  Stream& stream = at->second;
  if (!stream.is_within_window(sequence) || stream.position(sequence) > stream.end) begin_again(at, sequence);
  const Position begin = stream.position(sequence);
  const Position end = begin + segment.length;
  if (end <= stream.next) {
    ++counters_.duplicates;
    return;
  }
  if (begin > stream.next) {
    keep(segment, begin, stream, now);
    give_up_hopeless(at, now);
    return;
  }
  const std::size_t known = stream.next - begin;
  Chunk chunk;
  chunk.view = segment.payload.from(std::min(known, segment.payload.size()));
  chunk.stamp = now;
  advance(at, segment.length - known, std::move(chunk));
  release(at, now);
}

void TcpReassembler::keep(const TcpSegment& segment, Position begin, Stream& stream, Stamp now) {
  const auto [place, is_new] = stream.waiting.try_emplace(begin);
  Waiting& entry = place->second;
  if (!is_new && segment.payload.size() <= entry.bytes.size()) {
    ++counters_.duplicates;
    return;
  }
  ++counters_.out_of_order;
  if (stream.waiting.size() == 1 && is_new) {
    ++waiting_streams_;
    stream.hole_since = now;
    stream.hole_acknowledged = false;
  }
  const std::size_t more = segment.payload.size() - entry.bytes.size();
  stream.waiting_bytes += more;
  waiting_bytes_ += more;
  entry.bytes.assign(segment.payload.begin(), segment.payload.end());
  entry.length = std::max(segment.length, entry.length);
  entry.stamp = now;
}

/// Applies an acknowledgement: if it lies behind a hole, only the capture lost the bytes.
void TcpReassembler::note_acknowledgement(const TcpSegment& segment, const Key& answered, Stamp now) {
  const auto at = streams_.find(answered);
  if (at == streams_.end()) return;
  Stream& stream = at->second;
  if (stream.waiting.empty() || stream.hole_acknowledged) return;
  if (!stream.is_within_window(segment.acknowledgement)) return;
  if (stream.position(segment.acknowledgement) < stream.waiting.begin()->first) return;
  stream.hole_acknowledged = true;
  stream.acknowledged_since = now;
}

bool TcpReassembler::is_hopeless(const Stream& stream, Stamp now) const {
  return stream.waiting_bytes > max_waiting_bytes || stream.waiting.size() > max_waiting_segments ||
         waiting_bytes_ > max_waiting_total || now - stream.hole_since > patience ||
         (stream.hole_acknowledged && now - stream.acknowledged_since > acknowledged);
}

void TcpReassembler::give_up_hopeless(Streams::iterator at, Stamp now) {
  while (!at->second.waiting.empty() && is_hopeless(at->second, now)) skip_hole(at);
}

void TcpReassembler::expire(Stamp now) {
  if (waiting_streams_ == 0) return;
  for (auto at = streams_.begin(); at != streams_.end(); ++at) give_up_hopeless(at, now);
}

void TcpReassembler::give_up(Streams::iterator at) {
  while (!at->second.waiting.empty()) skip_hole(at);
}

void TcpReassembler::flush() {
  for (auto at = streams_.begin(); at != streams_.end(); ++at) give_up(at);
}

void TcpReassembler::restart() {
  flush();
  streams_.clear();
  ready_.clear();
  ready_next_ = 0;
}

/// Continues behind the first hole. The bytes that waited there were received when they were captured.
void TcpReassembler::skip_hole(Streams::iterator at) {
  Stream& stream = at->second;
  const Position behind = stream.waiting.begin()->first;
  ++counters_.holes;
  counters_.missing += behind - stream.next;
  stream.missing += behind - stream.next;
  stream.next = behind;
  release(at, stream.waiting.begin()->second.stamp);
}

/// Hands on the chunks that now continue the stream. A receiver could not read them before `not_before`.
void TcpReassembler::release(Streams::iterator at, Stamp not_before) {
  Stream& stream = at->second;
  if (stream.waiting.empty()) return;
  const Position before = stream.waiting.begin()->first;
  while (!stream.waiting.empty() && stream.waiting.begin()->first <= stream.next) {
    const Position begin = stream.waiting.begin()->first;
    Waiting entry = std::move(stream.waiting.begin()->second);
    stream.waiting.erase(stream.waiting.begin());
    stream.waiting_bytes -= entry.bytes.size();
    waiting_bytes_ -= entry.bytes.size();
    const std::size_t known = stream.next - begin;
    if (known >= entry.length) {
      ++counters_.duplicates;
      continue;
    }
    Chunk chunk;
    chunk.bytes = std::move(entry.bytes);
    chunk.view = ByteView(chunk.bytes.data(), chunk.bytes.size()).from(std::min(known, chunk.bytes.size()));
    chunk.stamp = not_before = std::max(entry.stamp, not_before);
    advance(at, entry.length - known, std::move(chunk));
  }
  if (stream.waiting.empty()) {
    --waiting_streams_;
  } else if (stream.waiting.begin()->first != before) {
    stream.hole_since = stream.waiting.begin()->second.stamp;
    stream.hole_acknowledged = false;
  }
}

/// The stream goes on by `length` bytes, of which the snapshot length may have left fewer in `chunk`.
void TcpReassembler::advance(Streams::iterator at, std::size_t length, Chunk chunk) {
  Stream& stream = at->second;
  const std::size_t got = chunk.view.size();
  if (got > 0) {
    counters_.bytes += got;
    chunk.key = at->first;
    chunk.missing = std::exchange(stream.missing, 0);
    chunk.fresh = std::exchange(stream.fresh, false);
    ready_.push_back(std::move(chunk));
  }
  if (got < length) {
    ++counters_.holes;
    counters_.missing += length - got;
    stream.missing += length - got;
  }
  stream.next += length;
}

bool TcpReassembler::next(Packet& packet) {
  if (ready_next_ == ready_.size()) {
    ready_.clear();
    ready_next_ = 0;
    return false;
  }
  const Chunk& chunk = ready_[ready_next_++];
  packet.payload = chunk.view;
  packet.arrival = chunk.stamp;
  packet.from = chunk.key.first;
  packet.to = chunk.key.second;
  packet.transport = Transport::tcp;
  packet.stream_start = chunk.fresh;
  packet.missing = chunk.missing;
  return true;
}

}  // namespace lidard
