// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "test/sim/servers/simulate.h"

namespace lidard::sim {

/// The truth of one packet or scan as the file holds it.
struct TruthRecord {
  Stamp begin;                ///< first firing
  Stamp end;                  ///< last firing
  std::uint32_t record = 0;   ///< number (from 0) of the capture's record that completes it
  std::uint32_t number = 0;   ///< counts this sensor's packets or scans from 0
  Pose2 vehicle;              ///< at `begin`, m and rad
  std::vector<float> ranges;  ///< m per slot in the order of the wire, exact; +inf: nothing there
};

/// All records of one sensor.
struct SensorTruth {
  std::string name;
  std::string model;
  std::vector<TruthRecord> records;
};

/// A truth file that cannot be read: "file: what; remedy".
class TruthError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Collects what a simulation tells and writes it beside the capture. Layout in pcaps/README.md.
class TruthWriter {
 public:
  explicit TruthWriter(const Scene& scene);
  /// `record`: number of the capture's record that holds the packet.
  void add(const Measurement& measurement, std::uint32_t record);
  std::vector<std::uint8_t> bytes() const;

 private:
  std::vector<SensorTruth> sensors_;
};

/// The file's content, or throws TruthError.
std::vector<SensorTruth> parse_truth(ByteView bytes, const std::string& name);
std::vector<SensorTruth> read_truth(const std::string& path);

}  // namespace lidard::sim
