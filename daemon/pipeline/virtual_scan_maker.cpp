// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/motion/frame_motion.h"
#include "core/motion/pose_gate.h"
#include "core/virtual/virtualizer.h"
#include "daemon/pipeline/maker.h"

namespace lidard {
namespace {

VirtualSettings settings_of(const VirtualScanConfig& config) {
  VirtualSettings settings;
  settings.visibility = config.has_visibility();
  settings.mode = config.mode;
  settings.ground = config.ground;
  settings.beams.no_return_free_range = config.no_return_free_range;
  settings.beams.early_returns = config.early_returns;
  return settings;
}

/// The virtual scans of one cloud, or of a merged cloud.
class VirtualScanMaker final : public Maker {
 public:
  VirtualScanMaker(const VirtualScanConfig& config, const PipelineContext& context)
      : Maker({MakerId::Kind::virtual_group, config.name}, {config.cloud_topic}, context),
        config_(config),
        stamps_(config.output_laser_topic.empty() ? config.virtual_laser_scan.size() : 1),
        why_unplaced_(config.virtual_laser_scan.size()) {
    for (const std::string& frame : config.virtual_laser_scan) {
      routes_.push_back({topic(config.topic(frame))});
      for (const AlsoScanConfig& also : config.also)
        routes_.back().push_back(topic(config.topic(frame, &also)));
    }
    set_up();
  }

  bool is_of(const VirtualScanConfig& entry) const override { return config_ == entry; }
  void add(std::size_t /*source*/, const Frame& frame, Stamp now) override {
    if (!frame.has_points) return;
    if (frame.merged_of != nullptr) project(*frame.merged_of, frame.merged_cloud()->stamp, now);
    if (const Cloud* const cloud = frame.cloud()) add_cloud(*cloud, now);
  }
  void set_scan(const OutputScanConfig& wanted) override {
    config_.output = wanted;
    set_up();
  }
  void restart() override {
    last_instant_ = {};
    for (SteadyStamps& stamps : stamps_) stamps.reset();
  }
  MakerStatus status(Stamp now) const override {
    MakerStatus status = Maker::status(now);
    status.planes = VirtualStatus{config_.virtual_laser_scan, why_unplaced_, "", std::nullopt};
    if (context_.motion.track() != nullptr) status.planes->gate = gate_;
    if (!config_.has_visibility()) return status;
    status.planes->why_no_surfaces = virtualizer_->why_no_surfaces();
    status.figures = {{"Clouds without rings", without_rings_},
                      {"Returns on the vehicle", virtualizer_->own_returns()}};
    return status;
  }

 private:
  /// Makes what depends on the grid and the profiles.
  void set_up() {
    const VehicleConfig& vehicle = context_.vehicle;
    needs_vehicle_ = config_.has_visibility() || !vehicle.footprint.empty() || vehicle.has_motion();
    virtualizer_.emplace(make_grid(config_.output.grid).value(), config_.output.heights(),
                         config_.virtual_laser_scan.size(), settings_of(config_), cloud_poses_.size());
    virtualizer_->set_footprint(Footprint(vehicle.footprint));
    make_scans(config_.output, config_.also, scans_, cut_);
    without_rings_ = 0;
    gate_ = {};
  }
  void add_cloud(const Cloud& cloud, Stamp now) {
    PlacedCloud& placed = single_[0];
    placed.cloud = &cloud;
    placed.vehicle_from_cloud = Pose::Identity();
    if (needs_vehicle_ &&
        !find_pose(context_.vehicle.base_frame, cloud.frame_id, cloud.stamp, placed.vehicle_from_cloud)) {
      counters_.count_no_pose(now);
      for (std::string& why : why_unplaced_) why = counters_.why_no_pose;
      return;
    }
    const PoseTrack* const track = context_.motion.track();
    const bool moves = track != nullptr && motion_.find(cloud, placed.vehicle_from_cloud, *track);
    gate_.published(track == nullptr || moves);
    placed.motion = moves ? &motion_ : nullptr;
    project(single_, moves ? motion_.instant() : cloud.stamp, now);
  }
  /// Makes the scans of clouds that are brought to `instant`.
  void project(const std::vector<PlacedCloud>& clouds, Stamp instant, Stamp now) {
    if (!advances(instant, last_instant_)) return void(++counters_.held_back);
    last_instant_ = instant;
    if (clouds.size() != cloud_poses_.size()) {
      cloud_poses_.resize(clouds.size());
      set_up();
    }
    virtualizer_->set_clouds(clouds);
    if (virtualizer_->why_no_surfaces()[0] != '\0') ++without_rings_;
    for (std::size_t i = 0; i < config_.virtual_laser_scan.size(); ++i) {
      if (!find_clouds(clouds, i, now)) continue;
      virtualizer_->project(i, cloud_poses_.data(), cut_);
      publish(i, instant, now);
    }
  }
  /// Finds where the clouds are in a frame.
  bool find_clouds(const std::vector<PlacedCloud>& clouds, std::size_t frame, Stamp now) {
    why_unplaced_[frame].clear();
    for (std::size_t c = 0; c < clouds.size(); ++c) {
      const Cloud* const cloud = clouds[c].cloud;
      if (cloud == nullptr ||
          find_pose(config_.virtual_laser_scan[frame], cloud->frame_id, cloud->stamp, cloud_poses_[c]))
        continue;
      counters_.count_no_pose(now);
      why_unplaced_[frame] = counters_.why_no_pose;
      return false;
    }
    return true;
  }
  /// The scans of one of the frames.
  void publish(std::size_t frame, Stamp stamp, Stamp now) {
    // Several frames on one topic share the cloud's stamp; consumers want stamps that increase.
    stamp = stamps_[std::min(frame, stamps_.size() - 1)].next(stamp);
    count_published(now);
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      scans_[i].frame_id = config_.virtual_laser_scan[frame];
      scans_[i].stamp = stamp;
      routes_[frame][i]->deliver(scans_[i], now);
    }
  }

  VirtualScanConfig config_;
  bool needs_vehicle_ = true;  // the cloud's pose on the vehicle
  std::optional<Virtualizer> virtualizer_;
  std::vector<Pose> cloud_poses_{Pose::Identity()};  // of each lidar's cloud in the frame at hand
  std::vector<PlacedCloud> single_{PlacedCloud()};
  CloudMotion motion_;             // of the cloud of a single lidar
  std::vector<PlanarScan> scans_;  // the first is the entry's own, then those of `also`
  std::vector<VirtualScan> cut_;
  std::vector<std::vector<Route*>> routes_;  // of scans_, for each frame
  Stamp last_instant_{};                     // of the clouds
  std::vector<SteadyStamps> stamps_;         // one for all where the frames share a topic
  std::vector<std::string> why_unplaced_;    // by frame; empty: the newest cloud was seen from there
  std::uint64_t without_rings_ = 0;          // clouds that are points alone
  PoseGate gate_;
};

}  // namespace

std::unique_ptr<Maker> make_maker(const VirtualScanConfig& config, const PipelineContext& context) {
  return std::make_unique<VirtualScanMaker>(config, context);
}

}  // namespace lidard
