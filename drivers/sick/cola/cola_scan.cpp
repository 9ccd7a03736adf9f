// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_scan.h"

#include <string>

namespace lidard::sick {
namespace {

/// A device sends at most 7200 beams (LRS36x0, 0.05 deg); more than twice as many are an error.
constexpr std::size_t most_values = 16384;

template <class Reader>
void read_head(Reader& in, ColaScan& scan) {
  in.u16();  // version
  in.u16();  // number of the device
  scan.serial = in.u32();
  for (std::uint8_t& byte : scan.status) byte = in.u8();
  scan.telegram_counter = in.u16();
  scan.scan_counter = in.u16();
  scan.start_us = in.u32();
  scan.transmit_us = in.u32();
  for (int i = 0; i < 4; ++i) in.u8();  // digital inputs and outputs
  scan.layer = in.i16();
  scan.scan_hz = in.u32() / 100.0;
  // In 100 Hz; some firmware sends Hz, and then the number is too large for a scanner.
  constexpr std::uint32_t highest_in_100_hz = 10000;
  const std::uint32_t frequency = in.u32();
  scan.measurement_hz = frequency > highest_in_100_hz ? frequency : frequency * 100.0;
}

template <class Reader>
Reject read_encoders(Reader& in, ColaScan& scan) {
  scan.encoder_count = in.u16();
  if (scan.encoder_count > ColaScan::most_encoders) return Reject::field;
  for (std::size_t i = 0; i < scan.encoder_count; ++i) {
    scan.encoders[i].position = in.i32();
    scan.encoders[i].speed = in.i16();
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
std::string_view read_text(Reader& in) {
  return in.u16() == 0 ? std::string_view() : in.text(in.text_size());
}

/// Parses the part after the channels: position of the device, its name, a comment and the time. Only the
/// name is used. The events after them differ between devices, and old firmware does not send them.
template <class Reader>
void read_tail(Reader& in, ColaScan& scan) {
  if (in.u16() != 0) {
    for (int i = 0; i < 6; ++i) in.f32();
    in.u8();
  }
  const std::string_view name = read_text(in);
  scan.name_size = name.size() > scan.name_text.size() ? 0 : name.size();
  std::copy_n(name.begin(), scan.name_size, scan.name_text.begin());
  read_text(in);
  skip_time(in);
}

template <class Reader>
Reject read_scan(Reader in, ColaScan& scan) {
  read_head(in, scan);
  Reject reason = read_encoders(in, scan);
  if (reason == Reject::none) reason = read_channels(in, scan);
  if (reason != Reject::none) return reason;
  read_tail(in, scan);
  return in.ok() ? Reject::none : Reject::size;
}

}  // namespace

const ColaChannel* ColaScan::channel(std::string_view wanted) const {
  for (std::size_t i = 0; i < channel_count; ++i) {
    if (channels[i].name() == wanted) return &channels[i];
  }
  return nullptr;
}

std::size_t ColaScan::echo_count() const {
  return static_cast<std::size_t>(std::count_if(distance_names.begin(), distance_names.end(),
                                                [this](auto each) { return channel(each) != nullptr; }));
}

std::size_t ColaScan::echo(std::size_t k) const {
  std::size_t index = 0;
  while (index < distance_names.size() && (channel(distance_names[index]) == nullptr || k-- > 0)) ++index;
  return index;
}

const ColaChannel* ColaScan::intensity(std::size_t k) const {
  const std::size_t index = echo(k);
  const ColaChannel* const rssi = channel(intensity_names.at(index));
  return rssi == nullptr && index == 0 ? channel("REFL1") : rssi;
}

bool is_cola_scan(const ColaTelegram& telegram) {
  const std::string_view kind = telegram.kind(), name = telegram.name();
  return (kind == "sSN" || kind == "sRA") && (name == "LMDscandata" || name == monitor_scan);
}

/// An early TiM310 (uos/sick_tim, sick_tim310 parser: 592 words; unverified on a device) has two more words
/// before DIST1, and no number of channels before RSSI1.
Reject parse_cola_scan(const ColaTelegram& telegram, ColaScan& scan) {
  constexpr std::string_view early = " 1 0 0 DIST1 ";
  const std::size_t at = telegram.payload.text().substr(0, 200).find(early);
  if (at == std::string_view::npos)
    return read_arguments(telegram, [&](auto in) { return read_scan(in, scan); });
  std::string usual(telegram.payload.text());
  usual.replace(at, early.size(), " 1 DIST1 ");
  if (const std::size_t rssi = usual.find(" RSSI1 "); rssi != std::string::npos) usual.insert(rssi, " 1");
  return parse_cola_scan({ColaDialect::a, ByteView(usual)}, scan);
}

namespace {

template <class Reader>
Reject read_compensation(Reader in, bool wide, ColaAngleCompensation& out) {
  // CoLa A may print a negative number of 16 bits with eight digits.
  const auto number = [&]() -> double {
    if (wide) return in.i32() / 1e4;
    return (Reader::units(2) == 2 ? in.i16() : static_cast<std::int16_t>(in.i32())) / 1e4;
  };
  out = {number(), in.i32() / 1e4, number()};
  if (!in.ok()) return Reject::size;
  // Twenty times as much as in the examples.
  return std::max(std::abs(out.amplitude_deg), std::abs(out.offset_deg)) > 5 ? Reject::field : Reject::none;
}

/// Skips the infringed positions: 15 bytes per cut-off segment (recorded from an LMS511). Two more lists
/// follow; no entry of them was recorded.
template <class Reader>
Reject skip_infringements(Reader& in) {
  const std::size_t segments = in.u16();
  for (std::size_t i = 0; i < segments && in.ok(); ++i) {
    in.u16();
    in.u8();
    for (int k = 0; k < 6; ++k) in.u16();
  }
  for (int list = 0; list < 2; ++list) {
    if (in.u16() != 0) return Reject::field;
  }
  return in.ok() ? Reject::none : Reject::size;
}

template <class Reader>
Reject read_field(Reader& in, ColaFields& out) {
  ColaFields::Field field;
  in.u16();  // version
  field.number = in.u8();
  const std::uint32_t time = in.u32();
  in.f32();  // scale and offset of distances
  in.f32();
  in.u32();  // scale and offset of angles
  in.i32();
  field.result = in.u8();
  const Reject reason = skip_infringements(in);
  skip_time(in);
  if (reason != Reject::none) return reason;
  if (!in.ok()) return Reject::size;
  if (time != 0) out.time_us = time;
  out.fields[out.count++] = field;
  return Reject::none;
}

template <class Reader>
Reject read_fields(Reader in, ColaFields& out) {
  out.count = 0;
  out.time_us.reset();
  const std::size_t count = in.u16();
  if (!in.ok()) return Reject::size;
  if (count > ColaFields::most) return Reject::field;
  for (std::size_t i = 0; i < count; ++i) {
    const Reject reason = read_field(in, out);
    if (reason != Reject::none) return reason;
  }
  return Reject::none;
}

/// The number of pins is not sent; it follows from the remaining bytes before the time.
template <class Reader>
Reject read_pins(Reader in, bool with_counts, ColaPins& out) {
  const auto units = [](std::size_t bytes) { return Reader::units(bytes); };
  out.count = 0;
  out.time_us.reset();
  in.u16();  // version
  const std::uint32_t time = in.u32();
  if (!in.ok()) return Reject::size;
  if (time != 0) out.time_us = time;
  const std::size_t pin = units(1) + (with_counts ? units(4) : 0);
  const std::size_t flag = units(2);
  const std::size_t date = units(2) + 5 * units(1) + units(4);
  for (const std::size_t tail : {flag + date, flag}) {
    if (in.left() < tail || (in.left() - tail) % pin != 0) continue;
    const std::size_t count = (in.left() - tail) / pin;
    if (count > ColaPins::most) return Reject::field;
    Reader attempt = in;
    for (std::size_t i = 0; i < count; ++i) {
      out.pins[i].state = attempt.u8();
      out.pins[i].count = with_counts ? attempt.u32() : 0;
    }
    const bool has_date = attempt.u16() != 0;
    if (!attempt.ok() || has_date != (tail != flag)) continue;
    out.count = count;
    return Reject::none;
  }
  return Reject::size;
}

}  // namespace

SelfReport cola_self_report(std::uint32_t bits) {
  SelfReport report;
  const auto is = [bits](std::uint32_t bit) { return (bits & bit) != 0; };
  const bool is_blind = is(cola_status::blind);
  report.add(is_blind, Severity::fault,
             "the scanner is blind (contamination error): its window is too dirty to measure; clean it");
  report.add(is(cola_status::contaminated) && !is_blind, Severity::warning,
             "the scanner warns of contamination: clean its window before it becomes blind");
  report.add(is(cola_status::error) && !is_blind, Severity::fault,
             "the scanner reports a device error (status 0 1); switch its power off and on, read the error "
             "in SOPAS ET");
  report.add(is(cola_status::laser_off), Severity::warning,
             "the scanner measures with its laser off (status 1 0); check its operating mode in SOPAS ET");
  report.add(is(~0x107U), Severity::warning,
             "the scanner reports an unknown status " + std::to_string(bits >> 8U) + " " +
                 std::to_string(bits & 0xffU) + "; look for errors in SOPAS ET");
  return report;
}

Reject parse_cola_imu(const ColaTelegram& telegram, ColaImu& imu) {
  if (telegram.dialect != ColaDialect::b) return Reject::version;
  constexpr std::size_t size = 60;
  if (telegram.arguments().size() != size) return Reject::size;
  ColaBinaryReader in(telegram.arguments());
  bool finite = true;
  const auto read = [&](auto& values) {
    for (double& value : values) finite = std::isfinite(value = in.f32()) && finite;
  };
  read(imu.acceleration);
  read(imu.angular_velocity);
  for (int i = 0; i < 3; ++i) in.u32();  // unknown; 0
  read(imu.orientation);
  in.u32();  // unknown; 0
  imu.time_us = in.u32();
  return finite ? Reject::none : Reject::field;
}

Reject parse_cola_compensation(const ColaTelegram& telegram, AngleCompensation kind,
                               ColaAngleCompensation& out) {
  const std::size_t size = telegram.arguments().size();
  const bool binary = telegram.dialect == ColaDialect::b;
  if (binary && size != 8 && size != 12) return Reject::size;
  const bool wide = binary ? size == 12 : kind == AngleCompensation::subtracted;
  return read_arguments(telegram, [&](auto in) { return read_compensation(in, wide, out); });
}

Reject parse_cola_fields(const ColaTelegram& telegram, ColaFields& fields) {
  return read_arguments(telegram, [&](auto in) { return read_fields(in, fields); });
}

Reject parse_cola_outputs(const ColaTelegram& telegram, ColaPins& pins) {
  return read_arguments(telegram, [&](auto in) { return read_pins(in, true, pins); });
}

Reject parse_cola_inputs(const ColaTelegram& telegram, ColaPins& pins) {
  return read_arguments(telegram, [&](auto in) { return read_pins(in, false, pins); });
}

}  // namespace lidard::sick
