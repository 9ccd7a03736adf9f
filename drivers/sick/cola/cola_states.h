// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/base/counters.h"
#include "drivers/driver.h"
#include "drivers/sick/cola/cola_scan.h"
#include "drivers/sick/cola/cola_stream.h"

namespace lidard::sick {

/// LFErec: what the device's field evaluation says.
struct ColaFields {
  static constexpr std::size_t most = 48;
  struct Field {
    std::uint8_t number = 0;  ///< as configured in the device
    std::uint8_t result = 0;  ///< 0 invalid, 1 free, 2 infringed; an LMS511 also said 3
  };
  std::array<Field, most> fields{};
  std::size_t count = 0;
  std::optional<std::uint32_t> time_us;  ///< device clock, of the last field
};

/// LIDoutputstate or LIDinputstate: the digital outputs or inputs.
struct ColaPins {
  static constexpr std::size_t most = 32;
  struct Pin {
    std::uint8_t state = 0;   ///< 0 inactive, 1 active, 2 not used
    std::uint32_t count = 0;  ///< changes so far; outputs only
  };
  std::array<Pin, most> pins{};
  std::size_t count = 0;
  std::optional<std::uint32_t> time_us;  ///< device clock; some devices send 0
};

/// Layouts: sick_scan_xd (sick_scan_messages.cpp), compared with recorded telegrams of LMS111, LMS511 and
/// TiM781S. What is wrong, or Reject::none.
Reject parse_cola_fields(const ColaTelegram& telegram, ColaFields& fields);
Reject parse_cola_outputs(const ColaTelegram& telegram, ColaPins& pins);
Reject parse_cola_inputs(const ColaTelegram& telegram, ColaPins& pins);

/// Turns what the device tells beside its scans into states on topics of their own: `lferec` (field_1 ...: 0
/// invalid, 1 free, 2 infringed), `lidoutputstate` (output_1 ..., output_1_count ...), `lidinputstate`
/// (input_1 ...: 0 inactive, 1 active, 2 not used) and `encoder` (position_1 in ticks, speed_1 in ticks/mm).
class ColaStates {
 public:
  explicit ColaStates(const DriverConfig& config);

  /// True if the telegram is one of those; `reason` says whether it could be read.
  bool take(const ColaTelegram& telegram, Stamp arrival, const ColaClock& clock, DriverOutput& out,
            Reject& reason);
  /// The encoders of a scan, if it has any.
  void encoders(const ColaScan& scan, Stamp stamp, DriverOutput& out);

 private:
  void send(std::string_view topic, Stamp stamp, DriverOutput& out);
  Stamp stamp_of(const std::optional<std::uint32_t>& time_us, Stamp arrival, const ColaClock& clock) const;
  Reject take_fields(const ColaTelegram& telegram, Stamp arrival, const ColaClock& clock, DriverOutput& out);
  Reject take_pins(const ColaTelegram& telegram, bool output, Stamp arrival, const ColaClock& clock,
                   DriverOutput& out);

  Span time_offset_;
  ReusedMessage<DeviceState> state_;
  ColaFields fields_;
  ColaPins pins_;
};

}  // namespace lidard::sick
