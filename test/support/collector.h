// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "drivers/driver.h"

namespace lidard::test {

/// One return with all that is known of it.
struct Row {
  std::size_t frame;
  std::uint32_t packet;
  int block, laser, ring, echo;
  std::int64_t offset_ns, stamp_ns;
  double azimuth_deg, distance_m;
  double x, y, z, intensity, time;
};

/// Keeps everything a driver hands on.
class Collector final : public DriverOutput {
 public:
  void scan(PlanarScan& scan) override { scans.push_back(scan); }
  void cloud(Cloud& cloud) override;

  std::vector<PlanarScan> scans;
  std::vector<Cloud> clouds;
  std::vector<Row> rows;  ///< of clouds with origins
};

/// Whether the packet comes from a device that listens on the model's TCP port, or goes to a UDP port of the
/// model.
bool is_for(const Model& model, const Packet& packet);

/// What came of decoding a capture as one model.
struct Decoded {
  Collector output;
  Counters counters;
  DeviceInfo info;
  std::string capture_error;
};

/// Decodes all packets of a capture that are for the model. Fails the test if the capture cannot be opened.
Decoded decode_capture(const std::string& path, const std::string& model, DriverConfig config = {});

}  // namespace lidard::test
