// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "test/sim/world/sensor_model.h"

namespace lidard::sim {

/// How a picoScan100 or multiScan100 is set up. Angles count counter-clockwise from the front.
struct SickSegmentsOptions {
  enum class Format { compact3, compact4, msgpack };

  bool several_layers = false;  ///< 16 layers of a multiScan100 instead of one
  Format format = Format::compact4;
  double start_deg = -138, end_deg = 138;  ///< of a single layer; several go all around
  double resolution_deg = 0.5;             ///< of a single layer
  double segment_deg = 30;
  Span turn{50'000'000};
  std::size_t echoes = 1;
  std::uint32_t serial = 23370016;
  std::uint64_t first_frame = 100;
  double imu_hz = 100;  ///< 0: none
  /// The device's angle filter, deg: what is outside is zero, and what is hidden as a whole is not sent.
  std::optional<std::pair<double, double>> keep_deg;
};

/// picoScan120, picoScan150, multiScan136, multiScan165, multiScan166.
ModelMaker make_sick_segments(const SickSegmentsOptions& options);

}  // namespace lidard::sim
