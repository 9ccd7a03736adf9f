// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/evidence/height_band.h"
#include "core/frames/scan.h"
#include "core/frames/scan_grid.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// What one output did since the start.
struct OutputCounters {
  std::uint64_t published = 0;
  std::uint64_t no_pose = 0;  ///< inputs not used because the pose of a frame was not known
  std::string why_no_pose;    ///< the newest reason
  Stamp last_published{};
};

/// The grid of a specification that the configuration has accepted.
ScanGrid grid_of(const ScanGridSpec& spec);
HeightBand band_of(const OutputScanConfig& config);
/// What a message holds for `beam` of an output.
float value_of(EmptyBeam beam, const OutputScanConfig& config);
/// How an entry's own scan (the first) and those of `also` hold what is not there and what is not known.
void set_encodings(const OutputScanConfig& output, const std::vector<AlsoScanConfig>& also,
                   std::vector<PlanarScan>& scans);
/// Whether an output publishes, and if not, why. While all are `starting`, waiting for input is no error.
DiagnosticItem health_of(const std::string& name, const OutputCounters& counters, Stamp now, bool starting);

}  // namespace lidard
