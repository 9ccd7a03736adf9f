// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/ip_defrag.h"

#include <algorithm>

namespace lidard {
namespace {
constexpr std::size_t max_packet_bytes = 65535;  // RFC 791 and RFC 8200: 16-bit lengths
}  // namespace

bool IpDefragmenter::Slot::matches(const IpPacket& packet) const {
  return used && id == packet.fragment.id && protocol == packet.protocol && from == packet.from &&
         to == packet.to;
}

bool IpDefragmenter::Slot::whole() const {
  return total != 0 && ranges.size() == 1 && ranges[0].begin == 0 && ranges[0].end == total;
}

bool IpDefragmenter::Slot::has_all(Range range) const {
  return std::any_of(ranges.begin(), ranges.end(),
                     [&](const Range& r) { return r.begin <= range.begin && range.end <= r.end; });
}

bool IpDefragmenter::Slot::contradicts(const IpPacket& fragment, Range range) const {
  if (total != 0 && (range.end > total || (!fragment.fragment.more && range.end != total))) return true;
  if (!fragment.fragment.more && !ranges.empty() && ranges.back().end > range.end) return true;
  return std::any_of(ranges.begin(), ranges.end(), [&](const Range& r) {
    const std::uint32_t begin = std::max(r.begin, range.begin);
    const std::uint32_t end = std::min(r.end, range.end);
    return begin < end && !std::equal(bytes.begin() + begin, bytes.begin() + end,
                                      fragment.transport.begin() + (begin - range.begin));
  });
}

void IpDefragmenter::Slot::store(ByteView content, Range range) {
  if (bytes.size() < range.end) bytes.resize(range.end);
  std::copy(content.begin(), content.end(), bytes.begin() + range.begin);
  insert(range);
}

void IpDefragmenter::Slot::insert(Range range) {
  const auto first =
      std::find_if(ranges.begin(), ranges.end(), [&](const Range& r) { return r.end >= range.begin; });
  auto last = first;
  for (; last != ranges.end() && last->begin <= range.end; ++last) {
    range.begin = std::min(range.begin, last->begin);
    range.end = std::max(range.end, last->end);
  }
  ranges.insert(ranges.erase(first, last), range);
}

void IpDefragmenter::give_up(Slot& slot) {
  dropped_ += slot.fragments;
  slot.used = false;
}

void IpDefragmenter::expire(Stamp now) {
  for (Slot& slot : slots_) {
    if (slot.used && now - slot.since > time_out) give_up(slot);
  }
}

IpDefragmenter::Slot& IpDefragmenter::find_or_begin(const IpPacket& packet, Stamp now) {
  const auto known =
      std::find_if(slots_.begin(), slots_.end(), [&](const Slot& s) { return s.matches(packet); });
  if (known != slots_.end()) return *known;
  auto slot = std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return !s.used; });
  if (slot == slots_.end() && slots_.size() < max_packets) slot = slots_.emplace(slots_.end());
  if (slot == slots_.end()) {
    slot = std::min_element(slots_.begin(), slots_.end(),
                            [](const Slot& a, const Slot& b) { return a.since < b.since; });
    give_up(*slot);
  }
  slot->used = true;
  slot->from = packet.from;
  slot->to = packet.to;
  slot->protocol = packet.protocol;
  slot->id = packet.fragment.id;
  slot->since = now;
  slot->fragments = 0;
  slot->total = 0;
  slot->bytes.clear();
  slot->ranges.clear();
  return *slot;
}

DefragResult IpDefragmenter::add(IpPacket& packet, Stamp now) {
  const std::size_t length = packet.transport.size();
  const std::size_t end = packet.fragment.offset + length;
  const bool odd_middle = packet.fragment.more && length % 8 != 0;
  if (length == 0 || odd_middle || end > max_packet_bytes) return DefragResult::malformed;
  expire(now);
  Slot& slot = find_or_begin(packet, now);
  const Range range{packet.fragment.offset, static_cast<std::uint32_t>(end)};
  ++slot.fragments;
  if (slot.contradicts(packet, range)) {
    give_up(slot);
    return DefragResult::waiting;
  }
  if (!packet.fragment.more) slot.total = range.end;
  if (slot.has_all(range)) {
    --slot.fragments;
    ++dropped_;
  } else {
    slot.store(packet.transport, range);
  }
  if (!slot.whole()) return DefragResult::waiting;
  slot.used = false;
  packet.transport = packet.captured = ByteView(slot.bytes.data(), slot.total);
  return DefragResult::complete;
}

void IpDefragmenter::flush() {
  for (Slot& slot : slots_) {
    if (slot.used) give_up(slot);
  }
}

std::size_t IpDefragmenter::pending() const {
  return static_cast<std::size_t>(
      std::count_if(slots_.begin(), slots_.end(), [](const Slot& s) { return s.used; }));
}

std::size_t IpDefragmenter::memory() const {
  std::size_t sum = 0;
  for (const Slot& slot : slots_) sum += slot.bytes.capacity() + slot.ranges.capacity() * sizeof(Range);
  return sum;
}

}  // namespace lidard
