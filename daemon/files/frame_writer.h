// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/frames/cloud.h"
#include "core/frames/scan.h"

namespace lidard {

/// Content of the column stamp_ns.
enum class StampColumn : std::uint8_t {
  host,   ///< since the Unix epoch
  device  ///< since the packet's own stamp (clouds), since the first ray (planar scans)
};

/// True if a writer has a row for this echo of a beam: always for the first, for further ones if there is a
/// return. Most beams have one echo.
inline bool is_written(const PlanarScan& scan, std::size_t beam, std::size_t echo) {
  const BeamStatus status = scan.statuses[scan.index(beam, echo)];
  return echo == 0 || status == BeamStatus::hit || status == BeamStatus::near;
}

/// Writes decoded frames to a file. Formats are those of `lidard decode --format`.
class FrameWriter {
 public:
  virtual ~FrameWriter() = default;
  /// Clouds need Cloud::origins.
  virtual void cloud(std::uint64_t frame, const Cloud& cloud) = 0;
  virtual void scan(std::uint64_t frame, const PlanarScan& scan) = 0;
  /// The device's own flags of the beams of the scan that comes next; only where it sends some.
  virtual void beam_flags(const std::vector<float>& flags) { static_cast<void>(flags); }
  /// Completes the file; throws std::runtime_error if it could not be written completely.
  virtual void finish() = 0;
};

/// The path of a file of many, whose number stands where printf() would put it: DIR/%06d.pcd. Nothing if the
/// path has no such placeholder.
std::optional<std::string> numbered_path(const std::string& path, std::uint64_t number);

/// `path` "-" is standard output. Throws std::runtime_error naming the path if it cannot be opened.
std::unique_ptr<FrameWriter> make_csv_writer(const std::string& path, StampColumn stamps);
std::unique_ptr<FrameWriter> make_json_writer(const std::string& path, StampColumn stamps);
/// One PCD file (fields x y z intensity ring time) with the points of all frames: binary_compressed or, of
/// more than 500,000 points, binary. With a path like DIR/%06d.pcd a compressed file for each frame.
std::unique_ptr<FrameWriter> make_pcd_writer(const std::string& path);

}  // namespace lidard
