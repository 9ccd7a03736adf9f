// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_states.h"

#include <array>
#include <string>

#include "drivers/sick/cola/cola_models.h"

namespace lidard::sick {
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
