// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/ms3_reassembler.h"

#include <algorithm>

namespace lidard::sick {
namespace {

// SICK 8022708 p. 14, table 1: marker, protocol, version, then three 32-bit numbers, little endian.
constexpr std::string_view marker = "MS3 MD";
constexpr std::size_t at_version_major = 6;
constexpr std::size_t at_total = 8;
constexpr std::size_t at_identification = 12;
constexpr std::size_t at_offset = 16;
constexpr std::size_t header_size = 24;
constexpr std::uint8_t version_major = 1;
/// Of the data header inside the instance (SICK 8022708 p. 20, table 4).
constexpr std::size_t at_channel = 12;

/// Datagrams overtake each other by milliseconds; whoever uses an identification again later, counts anew.
constexpr Span memory_of_finished = std::chrono::seconds(1);
/// A datagram that is older than that by its number belongs to another channel or to a restarted device.
constexpr std::uint32_t overtaking_limit = 16;

}  // namespace

Reject read_ms3_datagram(ByteView payload, Ms3Datagram& datagram) {
  if (payload.size() < marker.size()) return Reject::size;
  if (payload.sub(0, marker.size()).text() != marker) return Reject::magic;
  if (payload.size() <= header_size) return Reject::size;
  if (payload.u8(at_version_major) != version_major) return Reject::version;
  datagram.total = payload.le32(at_total);
  datagram.identification = payload.le32(at_identification);
  datagram.offset = payload.le32(at_offset);
  datagram.data = payload.from(header_size);
  if (datagram.total == 0 || datagram.total > Ms3Reassembler::max_instance) return Reject::field;
  if (datagram.offset >= datagram.total) return Reject::field;
  if (datagram.data.size() > datagram.total - datagram.offset) return Reject::field;
  return Reject::none;
}

bool Ms3Reassembler::Slot::channel_known() const {
  return present.size() > at_channel && present[at_channel] != 0;
}

std::uint8_t Ms3Reassembler::Slot::channel() const { return bytes[at_channel]; }

Reject Ms3Reassembler::add(const Packet& packet, Instance& complete) {
  complete.bytes = ByteView();
  Ms3Datagram datagram;
  const Reject reason = read_ms3_datagram(packet.payload, datagram);
  if (reason != Reject::none) return reason;
  expire(packet.arrival);
  const Key key{packet.from, packet.to.port, datagram.identification};
  if (const Finished* done = finished(key, packet.arrival))
    return done->complete ? Reject::duplicate : Reject::stale;
  Slot* slot = find(key);
  if (slot == nullptr) slot = &take(key, datagram.total, packet.arrival);
  if (slot->bytes.size() != datagram.total) return Reject::field;
  slot->first_arrival = std::min(slot->first_arrival, packet.arrival);
  if (!place(*slot, datagram)) return Reject::duplicate;
  if (slot->covered < slot->bytes.size()) return Reject::none;
  give_up_older_than(*slot, packet.arrival);
  remember(key, true, packet.arrival);
  slot->used = false;
  complete.bytes = ByteView(slot->bytes.data(), slot->bytes.size());
  complete.first_arrival = slot->first_arrival;
  return Reject::none;
}

/// False if it brought nothing new.
bool Ms3Reassembler::place(Slot& slot, const Ms3Datagram& datagram) {
  const std::size_t before = slot.covered;
  for (std::size_t i = 0; i < datagram.data.size(); ++i) {
    const std::size_t at = datagram.offset + i;
    if (slot.present[at] != 0) continue;
    slot.present[at] = 1;
    slot.bytes[at] = datagram.data.data()[i];
    ++slot.covered;
  }
  return slot.covered > before;
}

Ms3Reassembler::Slot* Ms3Reassembler::find(const Key& key) {
  for (Slot& slot : slots_) {
    if (slot.used && slot.key == key) return &slot;
  }
  return nullptr;
}

Ms3Reassembler::Slot& Ms3Reassembler::take(const Key& key, std::uint32_t total, Stamp arrival) {
  Slot* best = &slots_[0];
  for (Slot& slot : slots_) {
    if (slot.used < best->used || (slot.used == best->used && slot.order < best->order)) best = &slot;
  }
  if (best->used) give_up(*best, arrival);
  best->used = true;
  best->key = key;
  best->first_arrival = arrival;
  best->order = ++order_;
  best->covered = 0;
  best->bytes.resize(total);
  best->present.assign(total, 0);
  return *best;
}

/// Only those of the same channel: each channel counts its identifications for itself.
void Ms3Reassembler::give_up_older_than(const Slot& done, Stamp now) {
  for (Slot& slot : slots_) {
    if (&slot == &done || !slot.used) continue;
    if (!(slot.key.from == done.key.from) || slot.key.to_port != done.key.to_port) continue;
    if (slot.channel_known() && done.channel_known() && slot.channel() != done.channel()) continue;
    const std::uint32_t behind = done.key.identification - slot.key.identification;
    if (behind <= overtaking_limit) give_up(slot, now);
  }
}

void Ms3Reassembler::give_up(Slot& slot, Stamp now) {
  slot.used = false;
  ++counters_.incomplete;
  remember(slot.key, false, now);
}

void Ms3Reassembler::give_up_all() {
  for (Slot& slot : slots_) {
    if (slot.used) give_up(slot, slot.first_arrival);
  }
}

void Ms3Reassembler::expire(Stamp now) {
  for (Slot& slot : slots_) {
    // A capture or a host clock may go back: too old in either direction.
    if (slot.used && std::chrono::abs(now - slot.first_arrival) > patience_) give_up(slot, now);
  }
}

void Ms3Reassembler::clear() {
  for (Slot& slot : slots_) slot.used = false;
  for (Finished& entry : finished_) entry.used = false;
}

std::size_t Ms3Reassembler::open() const {
  return static_cast<std::size_t>(
      std::count_if(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.used; }));
}

const Ms3Reassembler::Finished* Ms3Reassembler::finished(const Key& key, Stamp now) const {
  for (const Finished& entry : finished_) {
    if (entry.used && entry.key == key && std::chrono::abs(now - entry.at) <= memory_of_finished)
      return &entry;
  }
  return nullptr;
}

void Ms3Reassembler::remember(const Key& key, bool complete, Stamp at) {
  finished_[next_finished_] = {true, key, complete, at};
  next_finished_ = (next_finished_ + 1) % finished_.size();
}

}  // namespace lidard::sick
