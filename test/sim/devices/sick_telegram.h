// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace lidard::sim {

/// One echo of a beam on the wire.
struct SickEcho {
  double mm = 0;  ///< 0: none
  std::uint16_t rssi = 0;
};

/// One beam of a line.
struct SickBeam {
  std::vector<SickEcho> echoes;
  bool reflector = false;
  double theta = 0;  ///< rad, counter-clockwise from the front
};

/// One layer's part of a segment.
struct SickLine {
  std::uint64_t start_us = 0, stop_us = 0;
  double elevation = 0;  ///< rad, upwards
  double theta_start = 0, theta_stop = 0;
  std::vector<SickBeam> beams;
};

/// What one scan telegram carries. Lines of a module have equally many beams and echoes.
struct SickSegment {
  std::uint64_t counter = 1;
  std::uint64_t transmit_us = 0;
  std::uint64_t index = 0;
  std::uint64_t frame = 0;
  std::uint32_t sender = 0;
  std::vector<std::vector<SickLine>> modules;
  double scale = 1;  ///< mm of a step (Compact version 4)
  bool with_rssi = true;
  bool with_properties = true;
  bool with_theta = true;
};

using SickBytes = std::vector<std::uint8_t>;

/// Compact telegrams (SICK KaitaiStructDescriptions); `version` 3 or 4. Version 4 was compared with telegrams
/// of a picoScan150, a multiScan136 and an LRS4581 (sick_perception_sdk), version 3 with none.
SickBytes compact_scan(const SickSegment& segment, std::uint32_t version);
SickBytes compact_imu(std::uint64_t time_us, const std::array<float, 3>& acceleration,
                      const std::array<float, 3>& rate, const std::array<float, 4>& wxyz);
/// The content of compact_scan() as a MSGPACK telegram (SICKAG/ScanSegmentAPI, whose samples hold one content
/// in both formats).
SickBytes msgpack_scan(const SickSegment& segment);

}  // namespace lidard::sim
