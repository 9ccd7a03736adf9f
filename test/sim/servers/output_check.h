// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "drivers/driver.h"

namespace lidard::sim {

/// Looks whether what a driver hands on keeps the invariants of frames, whatever it was given: those of
/// PlanarScan, finite numbers, points that belong to columns, sizes that a device can have.
class OutputCheck final : public FrameReceiver {
 public:
  void scan(PlanarScan& scan) override;
  void cloud(Cloud& cloud) override;
  void extra_scan(std::string_view topic, PlanarScan& scan) override;
  void message(const DeviceMessage& message) override;

  /// The first thing found, in a few words; nullptr: nothing.
  const char* violation() const { return violation_; }
  std::uint64_t frames() const { return frames_; }

 private:
  void expect(bool holds, const char* otherwise) {
    if (!holds && violation_ == nullptr) violation_ = otherwise;
  }
  void check(const PlanarScan& scan);

  const char* violation_ = nullptr;
  std::uint64_t frames_ = 0;
};

}  // namespace lidard::sim
