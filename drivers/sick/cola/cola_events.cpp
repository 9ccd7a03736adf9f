// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_events.h"

#include "drivers/sick/cola/cola_reader.h"

namespace lidard::sick {
namespace {

/// A flag, then the device's date and time if it is set.
template <class Reader>
void skip_time(Reader& in) {
  if (in.u16() == 0) return;
  in.u16();                             // year
  for (int i = 0; i < 5; ++i) in.u8();  // month ... second
  in.u32();                             // us
}

/// Where a field is infringed. One entry for every cut-off segment: 15 bytes (recorded from an LMS511),
/// of which nothing is needed here. Two more lists follow, whose entries nobody has seen.
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

/// The number of pins is not told: it follows from what is left before the time at the end.
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
