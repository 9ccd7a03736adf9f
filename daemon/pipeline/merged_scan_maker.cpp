// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/merge/merger.h"
#include "core/mounts/mount_check.h"
#include "daemon/pipeline/maker.h"
#include "daemon/pipeline/merge_sources.h"
#include "daemon/pipeline/router.h"

namespace lidard {
namespace {

MergeSettings settings_of(const MergedScanConfig& config) {
  MergeSettings settings;
  settings.points = config.output.profile == Profile::flatten || !config.cloud_destination_topic.empty();
  for (const AlsoScanConfig& also : config.also) settings.points |= also.profile == Profile::flatten;
  settings.visibility = config.has_visibility() || !config.status_topic.empty();
  settings.how.noise = settings.source.noise = config.range_noise;
  settings.how.free_required = config.free_required;
  settings.source.echoes = config.echoes;
  settings.source.veil_filter = config.veil_filter;
  for (const std::string& name : config.laserscan_topics) {
    const auto own = config.source_settings.find(name);
    settings.each.push_back(own == config.source_settings.end() ? settings.source : own->second);
  }
  return settings;
}

/// A merged scan: takes the scans of its sources, publishes when one is due.
class MergedScanMaker final : public Maker {
 public:
  MergedScanMaker(const MergedScanConfig& config, const MakerContext& context)
      : config_(config),
        context_(context),
        poses_(context.poses),
        footprint_(context.vehicle.footprint),
        sources_(
            {config.laserscan_topics, config.schedule, config.on_missing_motion, config.destination_frame},
            context),
        mount_check_(config.laserscan_topics.size()),
        compared_(config.laserscan_topics.size(), nullptr),
        places_(config.laserscan_topics.size(), Eigen::Vector2d::Zero()) {
    const auto topic = [&](const std::string& name) {
      return name.empty() ? nullptr : &context.router.topic(name);
    };
    scan_topics_ = {topic(config.scan_destination_topic)};
    for (const AlsoScanConfig& also : config.also) scan_topics_.push_back(topic(also.topic));
    cloud_topic_ = topic(config.cloud_destination_topic);
    status_topic_ = topic(config.status_topic);
    cloud_.frame_id = config.destination_frame;
    status_.frame_id = config.destination_frame;
    set_up();
  }

  MakerId id() const override { return {MakerId::Kind::merged, config_.name}; }
  bool is_of(const MergedScanConfig& entry) const override { return config_ == entry; }
  std::vector<std::string> sources() const override { return config_.laserscan_topics; }
  void add_scan(std::size_t source, const PlanarScan& scan, Stamp now) override {
    Pose pose;
    if (!place_footprint(scan.stamp) || !poses_.find(config_.destination_frame, scan.frame_id, scan.stamp,
                                                     pose, sources_.counters.why_no_pose)) {
      ++sources_.counters.no_pose;
      return;
    }
    if (!merger_->add(source, scan, pose)) return;
    sources_.delivered(source, *merger_->times(source), static_cast<double>(scan.scan_time), now);
    advance(now);
  }
  void advance(Stamp now) override {
    if (const auto moment = sources_.due(now)) publish(*moment, now);
  }
  std::optional<Stamp> next_event() const override { return sources_.next_event(); }
  bool states_changed(Stamp now) override { return sources_.states_changed(now); }
  void set_scan(const OutputScanConfig& wanted) override {
    config_.output = wanted;
    set_up();
    mount_check_.reset();
    sources_.forget();
  }
  void restart() override {
    merger_->reset();
    mount_check_.reset();
    sources_.restart();
  }
  MakerStatus status(Stamp now) const override {
    MakerStatus status;
    status.counters = sources_.counters;
    status.merge = sources_.status(now);
    status.merge->mounts = mount_check_.pairs();
    status.merge->wrong_mount = mount_check_.wrong_source();
    for (const OutputTopic* topic : scan_topics_) status.topics.push_back(topic->name);
    for (const OutputTopic* topic : {cloud_topic_, status_topic_})
      if (topic != nullptr) status.topics.push_back(topic->name);
    if (merger_->visibility() != nullptr) {
      std::uint64_t own = 0, seen_through = 0, mixed = 0;
      for (std::size_t s = 0; s < config_.laserscan_topics.size(); ++s) {
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
    merger_.emplace(grid_of(config_.output.grid), band_of(config_.output), config_.laserscan_topics.size(),
                    settings_of(config_));
    footprint_placed_.reset();
    scans_.assign(1 + config_.also.size(), PlanarScan());
    set_encoding(config_.output, scans_[0]);
    for (PlanarScan& scan : scans_) scan.frame_id = config_.destination_frame;
    merged_ = {{config_.output.profile, &scans_[0]}};
    for (std::size_t i = 0; i < config_.also.size(); ++i)
      merged_.push_back({config_.also[i].profile, &scans_[i + 1]});
  }
  bool place_footprint(Stamp stamp) {
    if (footprint_.empty()) return true;
    Pose pose;
    if (!poses_.find(config_.destination_frame, context_.vehicle.base_frame, stamp, pose,
                     sources_.counters.why_no_pose))
      return false;
    if (footprint_placed_ && footprint_placed_->matrix() == pose.matrix()) return true;
    footprint_placed_ = pose;
    merger_->set_footprint(footprint_.transformed(pose));
    return true;
  }
  void publish(const MergeMoment& moment, Stamp now) {
    const MergeReport& report =
        merger_->merge(moment, sources_.usable(now), merged_, cloud_topic_ != nullptr ? &cloud_ : nullptr);
    sources_.published(report, now);
    compare_sources(moment.at);
    for (std::size_t i = 0; i < scans_.size(); ++i) context_.router.publish(*scan_topics_[i], scans_[i], now);
    if (cloud_topic_ != nullptr) context_.router.publish(*cloud_topic_, cloud_, now);
    if (status_topic_ == nullptr) return;
    fill_status();
    context_.router.publish(*status_topic_, status_, now);
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
      places_[s] = merger_->looks_from(s);
    }
    const auto moved = [](SourceUse use) { return use == SourceUse::static_poses; };
    mount_check_.update(
        stamp, compared_, places_,
        poses_.track() != nullptr && std::none_of(sources_.uses().begin(), sources_.uses().end(), moved));
  }

  MergedScanConfig config_;
  const MakerContext& context_;
  const FrameTree& poses_;
  Footprint footprint_;                   // in base_frame
  std::optional<Pose> footprint_placed_;  // base_frame in the output frame when it was last set
  std::optional<Merger> merger_;
  MergeSources sources_;
  MountCheck mount_check_;
  std::vector<const PlacedScan*> compared_;
  std::vector<Eigen::Vector2d> places_;
  std::vector<PlanarScan> scans_;                // the first is the entry's own, then those of `also`
  std::vector<const OutputTopic*> scan_topics_;  // of scans_, in the same order
  const OutputTopic* cloud_topic_ = nullptr;     // nullptr, as below: none
  const OutputTopic* status_topic_ = nullptr;
  std::vector<MergedScan> merged_;
  PlanarScan status_;
  Cloud cloud_;
};

}  // namespace

std::unique_ptr<Maker> make_maker(const MergedScanConfig& config, const MakerContext& context) {
  return std::make_unique<MergedScanMaker>(config, context);
}

}  // namespace lidard
