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

/// What came of decoding a capture as one model.
struct Decoded {
  Collector output;
  Counters counters;
  DeviceInfo info;
  std::string capture_error;
};

/// Decodes all datagrams of a capture that go to the ports of the model, or all that came over TCP from its
/// port. Fails the test if it cannot be
/// opened.
Decoded decode_capture(const std::string& path, const std::string& model, DriverConfig config = {});

}  // namespace lidard::test
