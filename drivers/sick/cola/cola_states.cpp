// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_states.h"

#include <string>

#include "drivers/sick/cola/cola_models.h"

namespace lidard::sick {
namespace {

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

namespace {

/// "output_1" ... for as long as the program runs.
template <std::size_t Count>
class Names {
 public:
  Names(const char* before, const char* after) {
    for (std::size_t i = 0; i < Count; ++i) texts_[i] = before + std::to_string(i + 1) + after;
  }
  std::string_view operator[](std::size_t i) const { return texts_.at(i); }

 private:
  std::array<std::string, Count> texts_;
};

std::string_view field_name(std::uint8_t number) {
  static const Names<256> names("field_", "");
  return names[number == 0 ? 255 : number - 1U];
}

std::string_view pin_name(bool output, bool count, std::size_t i) {
  static const Names<ColaPins::most> outputs("output_", "");
  static const Names<ColaPins::most> counts("output_", "_count");
  static const Names<ColaPins::most> inputs("input_", "");
  if (!output) return inputs[i];
  return count ? counts[i] : outputs[i];
}

std::string_view encoder_name(bool speed, std::size_t i) {
  static const Names<ColaScan::most_encoders> positions("position_", "");
  static const Names<ColaScan::most_encoders> speeds("speed_", "");
  return speed ? speeds[i] : positions[i];
}

}  // namespace

ColaStates::ColaStates(const DriverConfig& config) : time_offset_(config.time_offset) {
  state_->frame_id = config.frame_id;
}

bool ColaStates::take(const ColaTelegram& telegram, Stamp arrival, const ColaClock& clock, DriverOutput& out,
                      Reject& reason) {
  const std::string_view kind = telegram.kind();
  if (kind != "sSN" && kind != "sRA") return false;
  const std::string_view name = telegram.name();
  if (name == "LFErec") {
    reason = take_fields(telegram, arrival, clock, out);
  } else if (name == "LIDoutputstate" || name == "LIDinputstate") {
    reason = take_pins(telegram, name == "LIDoutputstate", arrival, clock, out);
  } else {
    return false;
  }
  return true;
}

void ColaStates::send(std::string_view topic, Stamp stamp, DriverOutput& out) {
  state_->topic = topic;
  state_->stamp = stamp;
  out.message(state_);
}

Stamp ColaStates::stamp_of(const std::optional<std::uint32_t>& time_us, Stamp arrival,
                           const ColaClock& clock) const {
  // The pins of some devices are not stamped, and old times are told when a subscription begins.
  const bool use = time_us && clock.ready();
  return (use ? clock.to_host(clock.near_last(*time_us)) : arrival) + time_offset_;
}

Reject ColaStates::take_fields(const ColaTelegram& telegram, Stamp arrival, const ColaClock& clock,
                               DriverOutput& out) {
  const Reject reason = parse_cola_fields(telegram, fields_);
  if (reason != Reject::none) return reason;
  state_->values.clear();
  for (std::size_t i = 0; i < fields_.count; ++i) {
    const ColaFields::Field& field = fields_.fields[i];
    state_->values.push_back({field_name(field.number), static_cast<double>(field.result)});
  }
  send(topic_fields, stamp_of(fields_.time_us, arrival, clock), out);
  return Reject::none;
}

Reject ColaStates::take_pins(const ColaTelegram& telegram, bool output, Stamp arrival, const ColaClock& clock,
                             DriverOutput& out) {
  const Reject reason = output ? parse_cola_outputs(telegram, pins_) : parse_cola_inputs(telegram, pins_);
  if (reason != Reject::none) return reason;
  state_->values.clear();
  for (std::size_t i = 0; i < pins_.count; ++i) {
    state_->values.push_back({pin_name(output, false, i), static_cast<double>(pins_.pins[i].state)});
  }
  for (std::size_t i = 0; output && i < pins_.count; ++i) {
    state_->values.push_back({pin_name(output, true, i), static_cast<double>(pins_.pins[i].count)});
  }
  send(output ? topic_outputs : topic_inputs, stamp_of(pins_.time_us, arrival, clock), out);
  return Reject::none;
}

void ColaStates::encoders(const ColaScan& scan, Stamp stamp, DriverOutput& out) {
  if (scan.encoder_count == 0) return;
  state_->values.clear();
  for (std::size_t i = 0; i < scan.encoder_count; ++i) {
    state_->values.push_back({encoder_name(false, i), static_cast<double>(scan.encoders[i].position)});
    state_->values.push_back({encoder_name(true, i), static_cast<double>(scan.encoders[i].speed)});
  }
  send(topic_encoder, stamp, out);
}

}  // namespace lidard::sick
