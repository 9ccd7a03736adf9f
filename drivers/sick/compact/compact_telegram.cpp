// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/compact/compact_telegram.h"

#include <algorithm>
#include <boost/crc.hpp>
#include <cmath>
#include <string_view>

namespace lidard::sick {
namespace {

// Layouts: SICK KaitaiStructDescriptions (compact_frame.ksy, compact_header.ksy,
// type_1_primary_data_spherical_coordinates.ksy, type_2_imu.ksy, type_4_encoder.ksy); all little-endian.
constexpr std::uint32_t start_mark = 0x02020202;
constexpr std::size_t head_bytes = 32;
constexpr std::size_t checksum_bytes = 4;
constexpr std::size_t imu_bytes = 64;
constexpr std::size_t encoder_bytes = 88;
constexpr std::size_t msgpack_head_bytes = 8;
constexpr std::size_t module_fixed_bytes = 32;
constexpr double theta_zero = 16384;
constexpr double theta_per_rad = 5215;
constexpr unsigned has_first = 1U << 0U;   // distance of an echo, properties of a beam
constexpr unsigned has_second = 1U << 1U;  // RSSI of an echo, azimuth of a beam

double f32(ByteView bytes, std::size_t at) {
  return static_cast<double>(float_of_bits<float>(bytes.le32(at)));
}

/// Offsets in a module's head, counted from its number of lines.
struct ModuleLayout {
  std::size_t start, stop, elevation, theta_start, theta_stop, scale, next, data;

  ModuleLayout(std::size_t lines, std::uint32_t version)
      : start(module_fixed_bytes),
        stop(start + 8 * lines),
        elevation(stop + 8 * lines),
        theta_start(elevation + 4 * lines),
        theta_stop(theta_start + 4 * lines),
        scale(theta_stop + 4 * lines),
        next(scale + (version >= 4 ? 4U : 0U)),
        data(next + 8) {}
};

/// Adds the lengths of a scan telegram's modules, as far as the bytes reach.
TelegramHead head_of_scan(ByteView bytes) {
  TelegramHead head;
  if (!bytes.has(0, head_bytes)) return head;
  const std::uint32_t version = bytes.le32(24);
  if (version != 3 && version != 4) return {Reject::version, TelegramType::scan, 0};
  const TelegramHead broken{Reject::field, TelegramType::scan, 0};
  std::size_t at = head_bytes;
  for (std::size_t size = bytes.le32(28); size != 0;) {
    if (size > max_telegram || at + size + checksum_bytes > max_telegram) return broken;
    if (size < module_fixed_bytes) return broken;
    if (!bytes.has(at, module_fixed_bytes)) return head;
    const std::size_t lines = bytes.le32(at + 20);
    if (lines < 1 || lines > max_lines) return broken;
    const ModuleLayout layout(lines, version);
    if (size < layout.data) return broken;
    if (!bytes.has(at, layout.data)) return head;
    const std::size_t next = bytes.le32(at + layout.next);
    at += size;
    size = next;
  }
  if (at == head_bytes) return broken;
  head.length = at + checksum_bytes;
  return head;
}

/// Types 3 to 7: the common head, then the number of bytes that it states; version 1 includes the sender's
/// number in it (compact_header.ksy). Unverified except for type 4, the only one with public telegrams.
TelegramHead head_of_other(ByteView bytes, TelegramType type) {
  if (!bytes.has(0, head_bytes)) return {Reject::none, type, 0};
  const std::size_t sender_bytes = bytes.le32(24) < 2 ? 0 : 4;
  const std::size_t length = head_bytes + sender_bytes + bytes.le32(28) + checksum_bytes;
  if (length > max_telegram) return {Reject::field, type, 0};
  return {Reject::none, type, length};
}

struct ModuleCounts {
  std::size_t lines, beams, echoes;
  unsigned echo_content, beam_content;
  std::size_t echo_bytes() const {
    return ((echo_content & has_first) != 0 ? 2U : 0U) + ((echo_content & has_second) != 0 ? 2U : 0U);
  }
  std::size_t beam_bytes() const {
    return echoes * echo_bytes() + ((beam_content & has_first) != 0 ? 1U : 0U) +
           ((beam_content & has_second) != 0 ? 2U : 0U);
  }
};

/// Locates the values of a line: for every beam and line first the echoes, then the beam's own values.
void place_columns(const std::uint8_t* data, std::size_t line, const ModuleCounts& counts,
                   std::uint32_t version, SegmentLine& out) {
  const auto stride = static_cast<std::uint32_t>(counts.lines * counts.beam_bytes());
  const std::uint8_t* at = data + line * counts.beam_bytes();
  const bool with_distance = (counts.echo_content & has_first) != 0;
  const bool with_rssi = (counts.echo_content & has_second) != 0;
  for (std::size_t e = 0; e < counts.echoes; ++e) {
    out.distance[e] = with_distance ? Column{at, stride, Element::u16} : Column{};
    if (with_distance) at += 2;
    out.rssi[e] = with_rssi ? Column{at, stride, Element::u16} : Column{};
    if (with_rssi) at += 2;
  }
  const bool with_properties = (counts.beam_content & has_first) != 0;
  const bool with_theta = (counts.beam_content & has_second) != 0;
  // Version 3 has the azimuth first, version 4 the properties.
  const std::size_t before_properties = version < 4 && with_theta ? 2 : 0;
  const std::size_t before_theta = version >= 4 && with_properties ? 1 : 0;
  out.properties = with_properties ? Column{at + before_properties, stride, Element::u8} : Column{};
  out.theta = with_theta ? Column{at + before_theta, stride, Element::u16} : Column{};
  out.theta_zero = theta_zero;
  out.theta_step = 1 / theta_per_rad;
}

Reject parse_module(ByteView module, std::uint32_t version, bool first, Segment& out) {
  ModuleCounts counts{module.le32(20), module.le32(24), module.le32(28), 0, 0};
  if (counts.beams < 1 || counts.beams > max_beams) return Reject::field;
  if (counts.echoes < 1 || counts.echoes > max_echoes) return Reject::field;
  if (out.line_count + counts.lines > max_lines) return Reject::field;
  const ModuleLayout layout(counts.lines, version);
  counts.echo_content = module.u8(layout.next + 5);
  counts.beam_content = module.u8(layout.next + 6);
  if ((counts.echo_content & has_first) == 0) return Reject::field;
  if (module.size() != layout.data + counts.beams * counts.lines * counts.beam_bytes()) return Reject::size;
  const std::uint64_t index = module.le64(0), frame = module.le64(8);
  const std::uint32_t sender = module.le32(16);
  if (!first && (index != out.index || frame != out.frame || sender != out.sender)) return Reject::field;
  out.index = index;
  out.frame = frame;
  out.sender = sender;
  const double scale = version >= 4 ? f32(module, layout.scale) : 1;
  for (std::size_t i = 0; i < counts.lines; ++i) {
    SegmentLine& line = out.lines[out.line_count];
    line.start_us = module.le64(layout.start + 8 * i);
    line.stop_us = module.le64(layout.stop + 8 * i);
    line.elevation = f32(module, layout.elevation + 4 * i);
    line.theta_start = f32(module, layout.theta_start + 4 * i);
    line.theta_stop = f32(module, layout.theta_stop + 4 * i);
    line.beams = counts.beams;
    line.echoes = counts.echoes;
    line.metres = scale * 0.001;
    if (!is_plausible(line)) return Reject::field;
    place_columns(module.data() + layout.data, i, counts, version, line);
    ++out.line_count;
  }
  return Reject::none;
}

}  // namespace

TelegramHead read_head(ByteView bytes) {
  constexpr std::size_t mark_and_type = 8;
  if (!bytes.has(0, mark_and_type)) return {};
  if (bytes.le32(0) != start_mark) return {Reject::magic, TelegramType::scan, 0};
  const std::uint32_t type = bytes.le32(4);
  if (type == 1) return head_of_scan(bytes);
  if (type == 2) return {Reject::none, TelegramType::imu, imu_bytes};
  if (type >= 3 && type <= 7) return head_of_other(bytes, static_cast<TelegramType>(type));
  // MSGPACK has the length of its payload here, followed by a map.
  if (type > max_telegram) return {Reject::magic, TelegramType::scan, 0};
  if (type < msgpack_head_bytes) return {Reject::magic, TelegramType::scan, 0};
  if (bytes.has(msgpack_head_bytes, 1)) {
    const std::uint8_t marker = bytes.u8(msgpack_head_bytes);
    if (marker >> 4U != 8 && marker != 0xde) return {Reject::magic, TelegramType::scan, 0};
  }
  return {Reject::none, TelegramType::msgpack, msgpack_head_bytes + type + checksum_bytes};
}

bool checksum_is_right(ByteView telegram, TelegramType type) {
  // Compact's checksum covers all bytes before it, MSGPACK's only the payload.
  const std::size_t skipped = type == TelegramType::msgpack ? msgpack_head_bytes : 0;
  if (telegram.size() < skipped + checksum_bytes) return false;
  const std::size_t end = telegram.size() - checksum_bytes;
  boost::crc_32_type crc;
  crc.process_bytes(telegram.data() + skipped, end - skipped);
  return crc.checksum() == telegram.le32(end);
}

Reject parse_compact_scan(ByteView telegram, Segment& out) {
  const TelegramHead head = read_head(telegram);
  if (head.reject != Reject::none) return head.reject;
  if (head.type != TelegramType::scan) return Reject::magic;
  if (head.length == 0 || head.length != telegram.size()) return Reject::size;
  out.line_count = 0;
  out.counter = telegram.le64(8);
  out.version = telegram.le32(24);
  std::size_t at = head_bytes;
  for (std::size_t size = telegram.le32(28); size != 0;) {
    const ByteView module = telegram.sub(at, size);
    const Reject reason = parse_module(module, out.version, at == head_bytes, out);
    if (reason != Reject::none) return reason;
    at += size;
    size = module.le32(ModuleLayout(module.le32(20), out.version).next);
  }
  return Reject::none;
}

Reject parse_imu(ByteView telegram, ImuTelegram& out) {
  if (telegram.size() != imu_bytes) return Reject::size;
  if (telegram.le32(8) != 1) return Reject::version;
  bool finite = true;
  const auto read = [&](std::size_t at) {
    const double value = f32(telegram, at);
    finite = finite && std::isfinite(value);
    return value;
  };
  for (std::size_t i = 0; i < 3; ++i) out.acceleration[i] = read(12 + 4 * i);
  for (std::size_t i = 0; i < 3; ++i) out.angular_velocity[i] = read(24 + 4 * i);
  for (std::size_t i = 0; i < 4; ++i) out.orientation[i] = read(36 + 4 * i);
  out.time_us = telegram.le64(52);
  return finite ? Reject::none : Reject::field;
}

Reject parse_encoder(ByteView telegram, EncoderTelegram& out) {
  if (telegram.size() != encoder_bytes) return Reject::size;
  if (telegram.le32(24) != 1) return Reject::version;
  out.transmit_us = telegram.le64(16);
  out.frame = telegram.le64(36);
  out.ticks = telegram.le32(44);
  out.reference_ticks = {telegram.le32(48), telegram.le32(52)};
  out.speed = f32(telegram, 56);
  out.tick_us = telegram.le64(60);
  return std::isfinite(out.speed) ? Reject::none : Reject::field;
}

namespace {

constexpr char mark_byte = 0x02;

}  // namespace

bool TelegramStream::next(Telegram& telegram) {
  for (;;) {
    const ByteView rest = buffer_.rest();
    const TelegramHead head = read_head(rest);
    Reject reason = head.reject;
    if (reason == Reject::none) {
      if (head.length == 0 || head.length > rest.size()) return false;
      telegram = {rest.sub(0, head.length), head.type};
      if (checksum_is_right(telegram.bytes, head.type)) {
        buffer_.drop(head.length);
        return in_step_ = true;
      }
      reason = Reject::checksum;
    }
    // Before the first telegram and after a hole, other bytes are no error.
    if (in_step_) counters_.reject(reason);
    in_step_ = false;
    skip_to_mark();
  }
}

/// Skips at least one byte, up to the next possible start mark.
void TelegramStream::skip_to_mark() {
  const std::string_view rest = buffer_.rest().text();
  buffer_.drop(std::min(rest.find(mark_byte, 1), rest.size()));
}

void TelegramStream::interrupt() {
  if (in_step_ && !buffer_.rest().empty()) ++counters_.incomplete;
  buffer_.clear();
  in_step_ = false;
}

}  // namespace lidard::sick
