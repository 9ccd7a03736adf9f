// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/driver.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/cola/cola_scan.h"

namespace lidard::sick {

/// "output_1" ..., with static storage.
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

/// Names of the values in the messages beside the scans.
inline std::string_view field_name(std::uint8_t number) {
  static const Names<256> names("field_", "");
  return names[number == 0 ? 255 : number - 1U];
}

inline std::string_view pin_name(bool output, bool count, std::size_t i) {
  static const Names<ColaPins::most> outputs("output_", "");
  static const Names<ColaPins::most> counts("output_", "_count");
  static const Names<ColaPins::most> inputs("input_", "");
  if (!output) return inputs[i];
  return count ? counts[i] : outputs[i];
}

inline std::string_view encoder_name(bool speed, std::size_t i) {
  static const Names<ColaScan::most_encoders> positions("position_", "");
  static const Names<ColaScan::most_encoders> speeds("speed_", "");
  return speed ? speeds[i] : positions[i];
}

/// Publishes the device's messages beside its scans as states on topics of their own: `lferec` (field_1 ...:
/// 0 invalid, 1 free, 2 infringed), `lidoutputstate` (output_1 ..., output_1_count ...), `lidinputstate`
/// (input_1 ...: 0 inactive, 1 active, 2 not used), `encoder` (position_1 in ticks, speed_1 in ticks/mm) and
/// `imu`.
class ColaStates {
 public:
  explicit ColaStates(const DriverConfig& config) : time_offset_(config.time_offset) {
    state_->frame_id = imu_->frame_id = config.frame_id;
  }

  /// Publishes the telegram if it is one of these messages. Returns why it cannot be parsed.
  Reject read(const ColaTelegram& telegram, Stamp arrival, const ColaClock& clock, FrameReceiver& out) {
    const std::string_view kind = telegram.kind(), name = telegram.name();
    if (kind != "sSN" && kind != "sRA") return Reject::none;
    if (name == "LFErec") return read_fields(telegram, arrival, clock, out);
    if (name == "LIDoutputstate") return read_pins(telegram, true, arrival, clock, out);
    if (name == "LIDinputstate") return read_pins(telegram, false, arrival, clock, out);
    if (name == "InertialMeasurementUnit") return read_imu(telegram, arrival, clock, out);
    return Reject::none;
  }

  /// The encoders of a scan, if it has any.
  void encoders(const ColaScan& scan, Stamp stamp, FrameReceiver& out) {
    if (scan.encoder_count == 0) return;
    state_->values.clear();
    for (std::size_t i = 0; i < scan.encoder_count; ++i) {
      state_->values.push_back({encoder_name(false, i), static_cast<double>(scan.encoders[i].position)});
      state_->values.push_back({encoder_name(true, i), static_cast<double>(scan.encoders[i].speed)});
    }
    send(topic_encoder, stamp, out);
  }

 private:
  void send(std::string_view topic, Stamp stamp, FrameReceiver& out) {
    state_->topic = topic;
    state_->stamp = stamp;
    out.message(state_);
  }

  Stamp stamp_of(const std::optional<std::uint32_t>& time_us, Stamp arrival, const ColaClock& clock) const {
    // The pins of some devices have no stamp, and a new subscription begins with old times, perhaps of before
    // the counter's overflow.
    const bool use = time_us && clock.ready();
    if (!use) return arrival + time_offset_;
    const Stamp stamp = clock.to_host(clock.near_last(*time_us));
    return (clock.clock().is_held() ? stamp : std::min(stamp, arrival)) + time_offset_;
  }

  Reject read_fields(const ColaTelegram& telegram, Stamp arrival, const ColaClock& clock,
                     FrameReceiver& out) {
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

  Reject read_pins(const ColaTelegram& telegram, bool output, Stamp arrival, const ColaClock& clock,
                   FrameReceiver& out) {
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

  Reject read_imu(const ColaTelegram& telegram, Stamp arrival, const ColaClock& clock, FrameReceiver& out) {
    ColaImu read;
    const Reject reason = parse_cola_imu(telegram, read);
    if (reason != Reject::none) return reason;
    if (std::exchange(imu_us_, read.time_us) == read.time_us) return Reject::duplicate;
    imu_->stamp = stamp_of(read.time_us, arrival, clock);
    set_imu(read.acceleration, read.angular_velocity, read.orientation, imu_);
    out.message(imu_);
    return Reject::none;
  }

  Span time_offset_;
  ReusedMessage<DeviceState> state_;
  ReusedMessage<ImuSample> imu_;
  std::optional<std::uint32_t> imu_us_;  // time of the last sample
  ColaFields fields_;
  ColaPins pins_;
};

}  // namespace lidard::sick
