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
constexpr std::size_t at_state = 32, at_derived = 36, at_measurement = 40, at_intrusion = 44,
                      at_application = 48, at_local_io = 52;
constexpr std::size_t state_size = 16, derived_size = 20, application_size = 260;

constexpr double angle_unit = 1.0 / 4194304;  // deg, p. 23
constexpr double turn = 360;                  // deg; angles are within +-360, p. 53

bool bit(std::uint32_t value, unsigned n) { return (value >> n & 1U) != 0; }

std::uint32_t le24(ByteView b, std::size_t o) {
  return b.le16(o) | static_cast<std::uint32_t>(b.u8(o + 2)) << 16U;
}

/// The block whose offset and size stand at `entry`; empty if it is switched off. False if it lies.
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

bool is_possible(const Ms3Derived& d) {
  if (d.factor == 0 || d.scan_time_ms == 0 || d.beams == 0) return false;
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

/// 24 times a length in bytes and so many bytes of bits.
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

/// p. 25-27; what stands before are inputs. Everything from 197 on is unverified.
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
  t.serial = b.le32(4);
  t.plug_serial = b.le32(8);
  t.channel = b.u8(12);
  t.sequence = b.le32(16);
  t.scan = b.le32(20);
  t.date = b.le16(24);
  t.time_ms = b.le32(28);
}

/// Blocks without which there still is a scan: one that is too short for us is left out.
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
  if (!find_block(instance, at_state, state) || !find_block(instance, at_derived, derived) ||
      !find_block(instance, at_measurement, measurement) || !find_block(instance, at_intrusion, intrusion) ||
      !find_block(instance, at_application, application) || !find_block(instance, at_local_io, t.local_io))
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

}  // namespace lidard::sick
