// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/driver.h"
#include "drivers/sick/cola/cola_clock.h"
#include "drivers/sick/cola/cola_events.h"
#include "drivers/sick/cola/cola_scan.h"

namespace lidard::sick {

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
