// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/pipeline/context.h"
#include "daemon/pipeline/status.h"

namespace lidard {

/// Something made of the frames of sources: an entry of merged_scans:, merged_clouds: or virtual_scans:.
class Maker : public FrameUser {
 public:
  /// `made_of`: names of the sensors, merged clouds and virtual scans that it is made of.
  Maker(MakerId made, std::vector<std::string> made_of, const PipelineContext& context)
      : id(std::move(made)), sources(std::move(made_of)), context_(context) {}
  /// True if it is just what the entry asks for.
  virtual bool is_of(const MergedScanConfig& /*entry*/) const { return false; }
  virtual bool is_of(const MergedCloudConfig& /*entry*/) const { return false; }
  virtual bool is_of(const VirtualScanConfig& /*entry*/) const { return false; }
  /// Time passed, or the vehicle's poses went on: publishes what is due.
  virtual void advance(Stamp /*now*/) {}
  /// When advance() is worth a call if nothing else happens.
  virtual std::optional<Stamp> next_event() const { return std::nullopt; }
  /// True if a source has come, gone stale or was lost since the last call.
  virtual bool states_changed(Stamp /*now*/) { return false; }
  /// Applies another grid, profile or encoding from its next input on.
  virtual void set_scan(const OutputScanConfig& /*wanted*/) {}
  /// The input starts again.
  virtual void restart() {}
  virtual MakerStatus status(Stamp now) const;

  const MakerId id;
  const std::vector<std::string> sources;
  Stamp begun{};  ///< when the configuration asked for it first

 protected:
  /// A topic that it publishes on; nullptr: no name is given.
  Route* topic(const std::string& name);
  /// Pose of `child` in `parent`; false if it is unknown, which the status reports.
  bool find_pose(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose) {
    return context_.frames.find(parent, child, stamp, pose, counters_.why_no_pose);
  }
  void count_published(Stamp now) {
    ++counters_.published;
    counters_.last_published = now;
  }

  const PipelineContext& context_;
  MakerCounters counters_;

 private:
  std::vector<const Route*> topics_;
};

/// The maker of an entry.
std::unique_ptr<Maker> make_maker(const MergedScanConfig& config, const PipelineContext& context);
std::unique_ptr<Maker> make_maker(const MergedCloudConfig& config, const PipelineContext& context);
std::unique_ptr<Maker> make_maker(const VirtualScanConfig& config, const PipelineContext& context);

/// False for an output of an instant that would show what the last one did. Stamps that stand still are 1 ns
/// apart (SteadyStamps); after a jump back the input has begun again.
inline bool advances(Stamp instant, Stamp last) {
  return instant > last + std::chrono::microseconds(1) || last - instant >= restart_limit;
}

/// Makes the scans of an entry, its own and those of `also:`, and lists them with their profiles.
template <class Wanted>
void make_scans(const OutputScanConfig& own, const std::vector<AlsoScanConfig>& also,
                std::vector<PlanarScan>& scans, std::vector<Wanted>& wanted) {
  scans.assign(1 + also.size(), PlanarScan());
  scans[0].none_as = value_of(own.empty, own.grid.range_max);
  scans[0].invalid_as = value_of(own.unobserved, own.grid.range_max);
  wanted = {{own.profile, &scans[0]}};
  for (std::size_t i = 0; i < also.size(); ++i) wanted.push_back({also[i].profile, &scans[i + 1]});
}

}  // namespace lidard
