// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/ms3_telegram.h"

#include <algorithm>

namespace lidard::sick {
namespace {

// All offsets: SICK 8022708 (2019-04-15), appendix A, p. 19-27. Little endian.
constexpr std::size_t header_size = 76;
constexpr std::uint8_t version_major = 2;
/// Offset and size of each block, 16 bit each, from here on (p. 20).
constexpr std::size_t at_serial = 4, at_state = 32, at_derived = 36, at_measurement = 40, at_intrusion = 44,
                      at_application = 48, at_local_io = 52;
constexpr std::size_t state_size = 16, derived_size = 20, application_size = 260;

constexpr double angle_unit = 1.0 / 4194304;  // deg, p. 23
constexpr double turn = 360;                  // deg; angles are within +-360, p. 53

bool bit(std::uint32_t value, unsigned n) { return (value >> n & 1U) != 0; }

std::uint32_t le24(ByteView b, std::size_t o) {
  return b.le16(o) | static_cast<std::uint32_t>(b.u8(o + 2)) << 16U;
}

/// The block whose offset and size stand at `entry`; empty if it is switched off. False if the offsets are
/// wrong.
bool find_block(ByteView instance, std::size_t entry, ByteView& block) {
  const std::size_t offset = instance.le16(entry);
  const std::size_t size = instance.le16(entry + 2);
  block = ByteView();
  if (offset == 0 && size == 0) return true;
  if (offset < header_size || size == 0 || !instance.has(offset, size)) return false;
  block = instance.sub(offset, size);
  return true;
}

/// The same bits as in the process data of the field bus variants (SICK 8021219 p. 184).
Ms3State read_state(ByteView b) {
  const std::uint32_t flags = b.u8(0);
  const std::uint32_t errors = b.u8(15);
  return {
      bit(flags, 0),  bit(flags, 1), bit(flags, 2), bit(flags, 3), bit(flags, 4),
      bit(flags, 5),  le24(b, 1),    le24(b, 4),    le24(b, 7),    {b.u8(10), b.u8(11), b.u8(12), b.u8(13)},
      bit(errors, 0), bit(errors, 1)};
}

/// p. 23. The period is in us (p. 53 prints ms: 43 with 30 ms a turn and 0.513 deg a beam can only be us).
Ms3Derived read_derived(ByteView b) {
  Ms3Derived d{};
  d.factor = b.le16(0);
  d.beams = b.le16(2);
  d.scan_time_ms = b.le16(4);
  d.raw_start = b.le32s(8);
  d.raw_step = b.le32s(12);
  d.start_deg = d.raw_start * angle_unit;
  d.step_deg = d.raw_step * angle_unit;
  d.beam_period_us = b.le32(16);
  return d;
}

/// A scan takes 20 to 50 ms; a longer time times a scan number must not overflow.
constexpr unsigned longest_scan_ms = 1000;

bool is_possible(const Ms3Derived& d) {
  if (d.factor == 0 || d.scan_time_ms == 0 || d.scan_time_ms > longest_scan_ms || d.beams == 0) return false;
  const double gaps = d.beams - 1;
  if (std::abs(d.start_deg) > turn || std::abs(d.step_deg) * gaps > turn) return false;
  if (d.step_deg == 0 && d.beams > 1) return false;
  // The period is rounded to us: up to half of one for each beam.
  return (d.beam_period_us - 0.5) * gaps <= d.scan_time_ms * 1000.0;
}

bool read_measurement(ByteView b, Ms3Telegram& t) {
  if (b.empty()) return true;
  if (!b.has(0, 4)) return false;
  const std::size_t count = b.le32(0);
  if (count > (b.size() - 4) / 4) return false;
  t.has_measurement = count > 0;
  t.beam_bytes = b.sub(4, count * 4);
  return true;
}

/// 24 times: a length in bytes, then the bits in so many bytes.
bool read_intrusion(ByteView b, std::array<ByteView, 24>& paths) {
  std::array<ByteView, 24> found;
  std::size_t at = 0;
  for (ByteView& path : found) {
    if (!b.has(at, 4)) return false;
    const std::size_t length = b.le32(at);
    if (!b.has(at + 4, length)) return false;
    path = b.sub(at + 4, length);
    at += 4 + length;
  }
  paths = found;
  return true;
}

/// p. 25-27; the inputs stand before. Everything from 197 on is unverified.
Ms3Application read_application(ByteView b) {
  Ms3Application a{};
  a.evaluation_paths = b.le32(140);
  a.evaluation_safe = b.le32(144);
  a.evaluation_valid = b.le32(148);
  for (std::size_t i = 0; i < a.cases.size(); ++i) a.cases[i] = b.le16(152 + 2 * i);
  a.standby_state = b.u8(196);
  a.valid_flags = b.u8(259);
  return a;
}

void read_header(ByteView b, Ms3Telegram& t) {
  t.version_minor = b.u8(2);
  t.version_release = b.u8(3);
  t.serial = b.le32(at_serial);
  t.plug_serial = b.le32(8);
  t.channel = b.u8(12);
  t.sequence = b.le32(16);
  t.scan = b.le32(20);
}

/// Parses the optional blocks; one that is too short is left out.
void read_status_blocks(ByteView state, ByteView intrusion, ByteView application, Ms3Telegram& t) {
  const auto is_short = [&](ByteView block, std::size_t size) {
    const bool too_short = !block.empty() && block.size() < size;
    t.has_unreadable_block |= too_short;
    return block.empty() || too_short;
  };
  if (!is_short(state, state_size)) t.state = read_state(state);
  if (!is_short(application, application_size)) t.application = read_application(application);
  if (!intrusion.empty() && !read_intrusion(intrusion, t.intrusion)) t.has_unreadable_block = true;
}

}  // namespace

bool Ms3Telegram::is_intruded(std::size_t path) const {
  const ByteView& bits = intrusion.at(path);
  return std::any_of(bits.begin(), bits.end(), [](std::uint8_t b) { return b != 0; });
}

Reject parse_ms3_telegram(ByteView instance, Ms3Telegram& t) {
  t = Ms3Telegram{};
  if (instance.size() < header_size) return Reject::size;
  constexpr std::uint8_t invalid = 0;  // p. 20: any other value of the first byte is valid
  if (instance.u8(0) == invalid) return Reject::field;
  t.version_major = instance.u8(1);
  if (t.version_major != version_major) return Reject::version;
  read_header(instance, t);
  ByteView state, derived, measurement, intrusion, application;
  ByteView local_io;  // not described in SICK 8022708 (2019)
  if (!find_block(instance, at_state, state) || !find_block(instance, at_derived, derived) ||
      !find_block(instance, at_measurement, measurement) || !find_block(instance, at_intrusion, intrusion) ||
      !find_block(instance, at_application, application) || !find_block(instance, at_local_io, local_io))
    return Reject::field;
  if (!derived.empty()) {
    if (derived.size() < derived_size) return Reject::field;
    t.derived = read_derived(derived);
    if (!is_possible(*t.derived)) return Reject::field;
  }
  if (!read_measurement(measurement, t)) return Reject::field;
  if (t.has_measurement && t.derived && t.beams() != t.derived->beams) return Reject::field;
  read_status_blocks(state, intrusion, application, t);
  return Reject::none;
}

namespace {

// SICK 8022708 p. 14, table 1: marker, protocol, version, then three 32-bit numbers, little endian.
constexpr std::string_view marker = "MS3 MD";
constexpr std::size_t at_version_major = 6;
constexpr std::size_t at_total = 8;
constexpr std::size_t at_identification = 12;
constexpr std::size_t at_offset = 16;
constexpr std::size_t datagram_header_size = 24;
constexpr std::uint8_t datagram_version = 1;
/// Of the data header inside the instance (SICK 8022708 p. 20, table 4).
constexpr std::size_t at_channel = 12;

/// Datagrams overtake each other by milliseconds; an identification that comes again later is a new one.
constexpr Span memory_of_finished = std::chrono::seconds(1);
/// A datagram that is older than that by its number belongs to another channel or to a restarted device.
constexpr std::uint32_t overtaken_datagrams = 16;

}  // namespace

Reject read_ms3_datagram(ByteView payload, Ms3Datagram& datagram) {
  if (payload.size() < marker.size()) return Reject::size;
  if (payload.sub(0, marker.size()).text() != marker) return Reject::magic;
  if (payload.size() <= datagram_header_size) return Reject::size;
  if (payload.u8(at_version_major) != datagram_version) return Reject::version;
  datagram.total = payload.le32(at_total);
  datagram.identification = payload.le32(at_identification);
  datagram.offset = payload.le32(at_offset);
  datagram.data = payload.from(datagram_header_size);
  if (datagram.total == 0 || datagram.total > Ms3Reassembler::max_instance) return Reject::field;
  if (datagram.offset >= datagram.total) return Reject::field;
  if (datagram.data.size() > datagram.total - datagram.offset) return Reject::field;
  return Reject::none;
}

std::uint32_t serial_in(ByteView payload) {
  Ms3Datagram first;
  const bool has =
      read_ms3_datagram(payload, first) == Reject::none && first.offset == 0 && first.data.has(at_serial, 4);
  return has ? first.data.le32(at_serial) : 0;
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
  if (slot == nullptr) slot = &claim(key, datagram.total, packet.arrival);
  if (slot->bytes.size() != datagram.total) return Reject::field;
  slot->first_arrival = std::min(slot->first_arrival, packet.arrival);
  if (!store(*slot, datagram)) return Reject::duplicate;
  if (slot->covered < slot->bytes.size()) return Reject::none;
  give_up_older_than(*slot, packet.arrival);
  remember(key, true, packet.arrival);
  slot->used = false;
  complete.bytes = ByteView(slot->bytes.data(), slot->bytes.size());
  complete.first_arrival = slot->first_arrival;
  return Reject::none;
}

/// Stores a datagram's bytes; false if none was new.
bool Ms3Reassembler::store(Slot& slot, const Ms3Datagram& datagram) {
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

Ms3Reassembler::Slot& Ms3Reassembler::claim(const Key& key, std::uint32_t total, Stamp arrival) {
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

/// Gives up those of the same channel: each channel has its own identifications.
void Ms3Reassembler::give_up_older_than(const Slot& done, Stamp now) {
  for (Slot& slot : slots_) {
    if (&slot == &done || !slot.used) continue;
    if (!(slot.key.from == done.key.from) || slot.key.to_port != done.key.to_port) continue;
    if (slot.channel_known() && done.channel_known() && slot.channel() != done.channel()) continue;
    const std::uint32_t behind = done.key.identification - slot.key.identification;
    if (behind <= overtaken_datagrams) give_up(slot, now);
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
    // A capture or a host clock may go back: check both directions.
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
