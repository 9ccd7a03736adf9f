// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_scan.h"

#include <algorithm>
#include <cmath>

#include "drivers/sick/cola/cola_stream.h"

namespace lidard::sick {
namespace {

/// 7200 beams (LRS36x0, 0.05 deg) is the most that a device sends; anything beyond twice that is damage.
constexpr std::size_t most_values = 16384;

template <class Reader>
void read_head(Reader& in, ColaScan& scan) {
  scan.version = in.u16();
  scan.device = in.u16();
  scan.serial = in.u32();
  for (std::uint8_t& byte : scan.status) byte = in.u8();
  scan.telegram_counter = in.u16();
  scan.scan_counter = in.u16();
  scan.start_us = in.u32();
  scan.transmit_us = in.u32();
  // Two bytes each, the low one first: output 1 of an LMS511 is bit 0 of the first byte.
  const std::uint8_t inputs = in.u8();
  scan.inputs = static_cast<std::uint16_t>(in.u8() << 8U | inputs);
  const std::uint8_t outputs = in.u8();
  scan.outputs = static_cast<std::uint16_t>(in.u8() << 8U | outputs);
  scan.layer = in.i16();
  scan.scan_hz = in.u32() / 100.0;
  // In 100 Hz; some firmware sends Hz, which no scanner reaches as hundreds.
  constexpr std::uint32_t highest_in_100_hz = 10000;
  const std::uint32_t frequency = in.u32();
  scan.measurement_hz = frequency > highest_in_100_hz ? frequency : frequency * 100.0;
}

template <class Reader>
Reject read_encoders(Reader& in, ColaScan& scan) {
  scan.encoder_count = in.u16();
  if (scan.encoder_count > ColaScan::most_encoders) return Reject::field;
  for (std::size_t i = 0; i < scan.encoder_count; ++i) {
    scan.encoders[i].position = in.u32();
    scan.encoders[i].speed = in.u16();
  }
  return Reject::none;
}

template <class Reader>
Reject read_channel(Reader& in, bool wide, ColaChannel& channel) {
  const std::string_view letters = in.text(channel.letters.size());
  if (!in.ok()) return Reject::size;
  std::copy(letters.begin(), letters.end(), channel.letters.begin());
  channel.scale = in.f32();
  channel.offset = in.f32();
  channel.start_deg = in.i32() / 10000.0;
  channel.step_deg = in.u16() / 10000.0;
  channel.wide = wide;
  const std::size_t count = in.u16();
  if (!in.ok()) return Reject::size;
  if (count > most_values) return Reject::field;
  if (!std::isfinite(channel.scale) || !std::isfinite(channel.offset)) return Reject::field;
  in.values(count, wide, channel.values);
  return in.ok() ? Reject::none : Reject::size;
}

template <class Reader>
Reject read_channels(Reader& in, ColaScan& scan) {
  scan.channel_count = 0;
  for (const bool wide : {true, false}) {
    const std::size_t count = in.u16();
    if (!in.ok()) return Reject::size;
    if (count > ColaScan::most_channels - scan.channel_count) return Reject::field;
    for (std::size_t i = 0; i < count; ++i) {
      const Reject reason = read_channel(in, wide, scan.channels[scan.channel_count]);
      if (reason != Reject::none) return reason;
      ++scan.channel_count;
    }
  }
  return Reject::none;
}

template <class Reader>
std::size_t read_text(Reader& in, std::array<char, 256>& out) {
  if (in.u16() == 0) return 0;
  const std::string_view text = in.text(in.text_size());
  if (text.size() > out.size()) return 0;
  std::copy(text.begin(), text.end(), out.begin());
  return text.size();
}

template <class Reader>
void read_tail(Reader& in, ColaScan& scan) {
  scan.has_position = in.u16() != 0;
  if (scan.has_position) {
    for (float& value : scan.position.xyz) value = in.f32();
    for (float& value : scan.position.rotation) value = in.f32();
    scan.position.rotation_type = in.u8();
  }
  scan.name_size = read_text(in, scan.name_text);
  scan.comment_size = read_text(in, scan.comment_text);
  scan.has_time = in.u16() != 0;
  if (scan.has_time) {
    scan.time.year = in.u16();
    scan.time.month = in.u8();
    scan.time.day = in.u8();
    scan.time.hour = in.u8();
    scan.time.minute = in.u8();
    scan.time.second = in.u8();
    scan.time.microsecond = in.u32();
  }
}

template <class Reader>
Reject read_scan(Reader in, ColaScan& scan) {
  read_head(in, scan);
  Reject reason = read_encoders(in, scan);
  if (reason == Reject::none) reason = read_channels(in, scan);
  if (reason != Reject::none) return reason;
  read_tail(in, scan);
  if (!in.ok()) return Reject::size;
  // The events behind it are described differently from device to device; nobody needs them here. Old
  // firmware sends no such field at all.
  scan.has_event = in.left() > 0 && in.u16() != 0;
  return Reject::none;
}

}  // namespace

const ColaChannel* ColaScan::channel(std::string_view wanted) const {
  for (std::size_t i = 0; i < channel_count; ++i) {
    if (channels[i].name() == wanted) return &channels[i];
  }
  return nullptr;
}

std::size_t ColaScan::echo_count() const {
  std::size_t count = 0;
  while (count < distance_names.size() && channel(distance_names[count]) != nullptr) ++count;
  return count;
}

Reject parse_cola_scan(const ColaTelegram& telegram, ColaScan& scan) {
  return read_arguments(telegram, [&](auto in) { return read_scan(in, scan); });
}

}  // namespace lidard::sick
