// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>

#include "core/base/device_clock.h"
#include "daemon/files/frame_writer.h"
#include "drivers/address.h"

namespace lidard {

/// What `lidard decode` was asked for.
struct DecodeOptions {
  std::string capture;
  std::string model;                ///< empty: the packets tell
  std::optional<IpAddress> source;  ///< only packets from this sender
  std::uint16_t source_port = 0;    ///< 0: any
  std::uint16_t port = 0;           ///< destination port; 0: any
  std::string calibration;          ///< file; empty: what the model or the device says
  std::string calibration_model;    ///< ros_drivers, exact or veloview; empty: what suits the file
  std::string format = "csv";       ///< csv, json or pcd
  std::string output = "-";
  std::optional<std::uint64_t> frame;  ///< only this frame
  ClockMode clock = ClockMode::arrival;
  StampColumn stamps = StampColumn::host;
};

/// Decodes one sensor's frames. Messages and a summary go to `err`. Returns the exit code: 0 ok, 1 failed
/// (what could be decoded was written), 2 wrong usage (unknown model).
int run_decode(const DecodeOptions& options, std::ostream& err);

}  // namespace lidard
