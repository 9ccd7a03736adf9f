// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/angle.h"
#include "core/evidence/placed_scan.h"
#include "core/frames/empty_beam.h"
#include "core/frames/scan_grid.h"
#include "daemon/config/topic.h"
#include "drivers/key.h"

namespace lidard {

class Mapping;
struct Reading;
struct Source;

/// Keys that merged and virtual scans share.
struct OutputScanConfig {
  Profile profile = Profile::flatten;
  ScanGridSpec grid;
  EmptyBeam empty = EmptyBeam::inf;       ///< nothing there
  EmptyBeam unobserved = EmptyBeam::nan;  ///< not known
  std::optional<double> min_height,
      max_height;  ///< m, in the output frame; unset: the default of the kind of output

  HeightBand heights() const {
    const HeightBand all;
    return {min_height.value_or(all.min), max_height.value_or(all.max)};
  }
};

/// One more scan of the same merge: `also:` of an entry of `merged_scans:`.
struct AlsoScanConfig {
  std::string topic;
  Profile profile = Profile::safety;
};

/// The largest length that a key of an output takes, m.
constexpr double farthest_m = 10000;

Keys output_keys(OutputScanConfig& output);
/// What the keys of an output have to fulfil together; fills in what follows from them.
void check_output(const Mapping& yaml, OutputScanConfig& output, Reading& reading);
/// Rejects an angle_min and angle_max between which nothing lies.
void check_sector(const Mapping& yaml, const Sector& sector);

/// The ranges of a scan of these sources, unless the file says others.
void default_ranges(const std::vector<Source>& sources, ScanGridSpec& grid);

Key also_key(std::vector<AlsoScanConfig>& also);
/// True if some of these scans is more than points.
bool knows_free_space(const OutputScanConfig& output, const std::vector<AlsoScanConfig>& also);

}  // namespace lidard
