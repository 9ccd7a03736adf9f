// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/base/counters.h"
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

}  // namespace lidard::sick
