// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/merge/merger.h"
#include "core/mounts/mount_check.h"
#include "daemon/pipeline/merging_maker.h"

namespace lidard {
namespace {

MergeSettings settings_of(const MergedScanConfig& config) {
  MergeSettings settings;
  settings.points = config.output.profile == Profile::flatten || !config.cloud_destination_topic.empty();
  for (const AlsoScanConfig& also : config.also) settings.points |= also.profile == Profile::flatten;
  settings.visibility = config.has_visibility() || !config.status_topic.empty();
  settings.source = config.source;
  settings.how.noise = config.source.noise;
  settings.how.free_required = config.free_required;
  for (const std::string& name : config.laserscan_topics) settings.each.push_back(config.settings_of(name));
  return settings;
}

/// A merged scan: of the scans of its sources, published when one is due.
class MergedScanMaker final : public MergingMaker {
 public:
  MergedScanMaker(const MergedScanConfig& config, const PipelineContext& context)
      : MergingMaker({MakerId::Kind::merged, config.name}, config.laserscan_topics,
                     {config.schedule, config.on_missing_motion, config.destination_frame}, context),
        config_(config),
        footprint_(context.vehicle.footprint),
        mount_check_(sources.size()),
        compared_(sources.size(), nullptr),
        viewpoints_(sources.size(), Eigen::Vector2d::Zero()),
        scan_topics_{topic(config.scan_destination_topic)} {
    for (const AlsoScanConfig& also : config.also) scan_topics_.push_back(topic(also.topic));
    cloud_topic_ = topic(config.cloud_destination_topic);
    status_topic_ = topic(config.status_topic);
    cloud_.frame_id = config.destination_frame;
    status_.frame_id = config.destination_frame;
    set_up();
  }

  bool is_of(const MergedScanConfig& entry) const override { return config_ == entry; }
  void add(std::size_t source, const Frame& frame, Stamp now) override {
    const PlanarScan* const scan = frame.scan();
    if (scan == nullptr) return;
    Pose pose;
    if (!follow_footprint(scan->stamp) ||
        !find_pose(config_.destination_frame, scan->frame_id, scan->stamp, pose))
      return counters_.count_no_pose(now);
    if (merger_->add(source, *scan, pose))
      delivered(source, *merger_->times(source), static_cast<double>(scan->scan_time), now);
  }
  void set_scan(const OutputScanConfig& wanted) override {
    config_.output = wanted;
    set_up();
    mount_check_.reset();
    forget();
  }
  void restart() override {
    merger_->reset();
    mount_check_.reset();
    MergingMaker::restart();
  }
  MakerStatus status(Stamp now) const override {
    MakerStatus status = MergingMaker::status(now);
    status.merge->mounts = mount_check_.pairs();
    status.merge->wrong_mount = mount_check_.wrong_source();
    if (merger_->visibility() != nullptr) {
      std::uint64_t own = 0, seen_through = 0, mixed = 0;
      for (std::size_t s = 0; s < sources.size(); ++s) {
        const PlacedScan& sweep = merger_->last_sweep(s);
        own += sweep.own_returns;
        seen_through += sweep.seen_through;
        mixed += sweep.mixed_pixels;
      }
      status.figures = {{"Returns on the vehicle", own},
                        {"Returns from behind the vehicle", seen_through},
                        {"Mixed pixels", mixed}};
    }
    status.figures.insert(status.figures.end(), {{"Sweeps replaced before use", merger_->superseded()},
                                                 {"Sweeps out of order", merger_->out_of_order()},
                                                 {"Sweeps with impossible times", merger_->bad_times()}});
    return status;
  }

 private:
  /// Makes what depends on the grid and the profiles.
  void set_up() {
    merger_.emplace(make_grid(config_.output.grid).value(), config_.output.heights(), sources.size(),
                    settings_of(config_));
    footprint_pose_.reset();
    make_scans(config_.output, config_.also, scans_, merged_);
    for (PlanarScan& scan : scans_) scan.frame_id = config_.destination_frame;
  }
  /// Keeps the footprint in the output frame; false if its pose there is unknown.
  bool follow_footprint(Stamp stamp) {
    if (footprint_.empty()) return true;
    Pose pose;
    if (!find_pose(config_.destination_frame, context_.vehicle.base_frame, stamp, pose)) return false;
    if (footprint_pose_ && footprint_pose_->matrix() == pose.matrix()) return true;
    footprint_pose_ = pose;
    merger_->set_footprint(footprint_.transformed(pose));
    return true;
  }
  void publish(MergeMoment moment, Stamp now) override {
    published(merger_->merge(moment, usable(now), merged_, cloud_topic_ != nullptr ? &cloud_ : nullptr), now);
    compare_sources(moment.at);
    for (std::size_t i = 0; i < scans_.size(); ++i) scan_topics_[i]->deliver(scans_[i], now);
    if (cloud_topic_ != nullptr) cloud_topic_->deliver(cloud_, now);
    if (status_topic_ == nullptr) return;
    fill_status();
    status_topic_->deliver(status_, now);
  }
  void fill_status() {
    const Visibility& visibility = *merger_->visibility();
    const PlanarScan& scan = scans_[0];
    status_.reset(scan.beams);
    status_.set_angles(scan.angle_min, scan.angle_increment);
    status_.stamp = scan.stamp;
    status_.scan_time = scan.scan_time;
    status_.range_max = scan.range_max;
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      status_.set_hit(beam, std::min(visibility.covered(beam), scan.range_max));
      status_.intensities[beam] = static_cast<float>(visibility.state(beam));
    }
  }
  /// Compares what the sources of the output just made see of the same surfaces.
  void compare_sources(Stamp stamp) {
    if (merger_->visibility() == nullptr || !mount_check_.is_due(stamp)) return;
    for (std::size_t s = 0; s < compared_.size(); ++s) {
      compared_[s] = merger_->sweep(s);
      viewpoints_[s] = merger_->looks_from(s);
    }
    const auto moved = [](SourceUse use) { return use == SourceUse::static_poses; };
    mount_check_.update(
        stamp, compared_, viewpoints_,
        context_.motion.track() != nullptr && std::none_of(uses().begin(), uses().end(), moved));
  }

  MergedScanConfig config_;
  Footprint footprint_;                 // in base_frame
  std::optional<Pose> footprint_pose_;  // base_frame in the output frame when it was last set
  std::optional<Merger> merger_;
  MountCheck mount_check_;
  std::vector<const PlacedScan*> compared_;
  std::vector<Eigen::Vector2d> viewpoints_;
  std::vector<PlanarScan> scans_;    // the first is the entry's own, then those of `also`
  std::vector<Route*> scan_topics_;  // of scans_, in the same order
  Route* cloud_topic_ = nullptr;     // nullptr, as below: none
  Route* status_topic_ = nullptr;
  std::vector<MergedScan> merged_;
  PlanarScan status_;
  Cloud cloud_;
};

}  // namespace

std::unique_ptr<Maker> make_maker(const MergedScanConfig& config, const PipelineContext& context) {
  return std::make_unique<MergedScanMaker>(config, context);
}

}  // namespace lidard
