// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/frames/scan_grid.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/frame_tree.h"
#include "daemon/pipeline/status.h"

namespace lidard {

class Router;

/// What the outputs of a pipeline share; it must outlive them.
struct MakerContext {
  const VehicleConfig& vehicle;
  const FrameTree& poses;
  Router& router;
};

/// Something made of the frames of sources: an entry of merged_scans:, merged_clouds: or virtual_scans:.
class Maker {
 public:
  virtual ~Maker() = default;
  virtual MakerId id() const = 0;
  /// True if it is just what the entry asks for.
  virtual bool is_of(const MergedScanConfig& /*entry*/) const { return false; }
  virtual bool is_of(const MergedCloudConfig& /*entry*/) const { return false; }
  virtual bool is_of(const VirtualScanConfig& /*entry*/) const { return false; }
  /// Names of the sensors, merged clouds and virtual scans that it is made of.
  virtual std::vector<std::string> sources() const = 0;
  /// False while nobody would get what it makes.
  virtual bool is_wanted() const { return true; }
  /// A scan of one of them, `source` being its index there.
  virtual void add_scan(std::size_t /*source*/, const PlanarScan& /*scan*/, Stamp /*now*/) {}
  virtual void add_cloud(std::size_t /*source*/, const Cloud& /*cloud*/, Stamp /*now*/) {}
  /// A cloud without points, since nobody wanted them when it began.
  virtual void pass_by(std::size_t /*source*/, const Cloud& /*cloud*/, Stamp /*now*/) {}
  /// The clouds of a merged cloud, brought to `instant`.
  virtual void add_clouds(const std::vector<PlacedCloud>& /*clouds*/, Stamp /*instant*/, Stamp /*now*/) {}
  /// Time passed, or the vehicle's poses went on: publishes what is due.
  virtual void advance(Stamp /*now*/) {}
  /// When advance() is worth a call if nothing else happens.
  virtual std::optional<Stamp> next_event() const { return std::nullopt; }
  /// True if a source has come, gone stale or was lost since the last call.
  virtual bool states_changed(Stamp /*now*/) { return false; }
  /// Takes another grid, profile or encoding from its next input on.
  virtual void set_scan(const OutputScanConfig& /*wanted*/) {}
  /// The input starts again.
  virtual void restart() {}

  virtual MakerStatus status(Stamp now) const = 0;

  Stamp begun{};  ///< when the configuration asked for it first
};

/// The output of an entry.
std::unique_ptr<Maker> make_maker(const MergedScanConfig& config, const MakerContext& context);
std::unique_ptr<Maker> make_maker(const MergedCloudConfig& config, const MakerContext& context);
std::unique_ptr<Maker> make_maker(const VirtualScanConfig& config, const MakerContext& context);

/// False for an output of an instant that would show what the last one did. Stamps that stand still are 1 ns
/// apart (SteadyStamps); after a jump back the input has begun again.
inline bool advances(Stamp instant, Stamp last) {
  return instant > last + std::chrono::microseconds(1) || last - instant >= restart_limit;
}

/// The grid of a specification that the configuration has accepted.
ScanGrid grid_of(const ScanGridSpec& spec);
HeightBand band_of(const OutputScanConfig& config);
/// What a message holds for `beam` of an output.
float value_of(EmptyBeam beam, const OutputScanConfig& config);
/// How an entry's own scan holds what is not there and what is not known.
void set_encoding(const OutputScanConfig& output, PlanarScan& scan);

}  // namespace lidard
