// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/motion/frame_motion.h"
#include "core/virtual/virtualizer.h"
#include "daemon/pipeline/maker.h"
#include "daemon/pipeline/pose_gate.h"
#include "daemon/pipeline/router.h"

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
  VirtualScanMaker(const VirtualScanConfig& config, const MakerContext& context)
      : config_(config),
        context_(context),
        poses_(context.poses),
        stamps_(config.output_laser_topic.empty() ? config.virtual_laser_scan.size() : 1),
        why_unplaced_(config.virtual_laser_scan.size()) {
    for (const std::string& frame : config.virtual_laser_scan) {
      topics_.push_back({&context.router.topic(config.topic(frame))});
      for (const AlsoScanConfig& also : config.also)
        topics_.back().push_back(&context.router.topic(config.topic(frame, &also)));
    }
    set_up();
  }

  MakerId id() const override { return {MakerId::Kind::virtual_group, config_.name}; }
  bool is_of(const VirtualScanConfig& entry) const override { return config_ == entry; }
  std::vector<std::string> sources() const override { return {config_.cloud_topic}; }
  void add_cloud(std::size_t /*source*/, const Cloud& cloud, Stamp now) override {
    PlacedCloud& placed = single_[0];
    placed.cloud = &cloud;
    if (!place_vehicle(cloud, placed.vehicle_from_cloud)) {
      ++counters_.no_pose;
      for (std::string& why : why_unplaced_) why = counters_.why_no_pose;
      return;
    }
    const PoseTrack* const track = poses_.track();
    const bool moves = track != nullptr && motion_.find(cloud, placed.vehicle_from_cloud, *track);
    gate_.published(track == nullptr || moves);
    placed.motion = moves ? &motion_ : nullptr;
    add_clouds(single_, moves ? motion_.instant() : cloud.stamp, now);
  }
  void add_clouds(const std::vector<PlacedCloud>& clouds, Stamp instant, Stamp now) override {
    if (!advances(instant, last_instant_)) return void(++counters_.held_back);
    last_instant_ = instant;
    if (clouds.size() != cloud_poses_.size()) {
      cloud_poses_.resize(clouds.size());
      set_up();
    }
    virtualizer_->set_clouds(clouds);
    if (virtualizer_->why_no_surfaces()[0] != '\0') ++without_rings_;
    for (std::size_t i = 0; i < config_.virtual_laser_scan.size(); ++i) {
      if (!place_clouds(clouds, i)) continue;
      virtualizer_->project(i, cloud_poses_.data(), outputs_);
      publish(i, instant, now);
    }
  }
  void set_scan(const OutputScanConfig& wanted) override {
    config_.output = wanted;
    set_up();
  }
  void restart() override {
    last_instant_ = {};
    for (SteadyStamps& stamps : stamps_) stamps.reset();
  }
  MakerStatus status(Stamp) const override {
    MakerStatus status;
    status.counters = counters_;
    for (const auto& of_frame : topics_)
      for (const OutputTopic* topic : of_frame) status.topics.push_back(topic->name);
    status.planes = VirtualStatus{config_.virtual_laser_scan, why_unplaced_, "", std::nullopt};
    if (poses_.track() != nullptr) status.planes->gate = gate_;
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
    virtualizer_.emplace(grid_of(config_.output.grid), band_of(config_.output),
                         config_.virtual_laser_scan.size(), settings_of(config_), cloud_poses_.size());
    virtualizer_->set_footprint(Footprint(vehicle.footprint));
    scans_.assign(1 + config_.also.size(), PlanarScan());
    set_encoding(config_.output, scans_[0]);
    outputs_ = {{config_.output.profile, &scans_[0]}};
    for (std::size_t i = 0; i < config_.also.size(); ++i)
      outputs_.push_back({config_.also[i].profile, &scans_[i + 1]});
    without_rings_ = 0;
    gate_ = {};
  }
  bool place_vehicle(const Cloud& cloud, Pose& vehicle_from_cloud) {
    vehicle_from_cloud = Pose::Identity();
    if (!needs_vehicle_) return true;
    return poses_.find(context_.vehicle.base_frame, cloud.frame_id, cloud.stamp, vehicle_from_cloud,
                       counters_.why_no_pose);
  }
  /// Finds where the clouds are in a frame.
  bool place_clouds(const std::vector<PlacedCloud>& clouds, std::size_t frame) {
    why_unplaced_[frame].clear();
    for (std::size_t c = 0; c < clouds.size(); ++c) {
      const Cloud* const cloud = clouds[c].cloud;
      if (cloud == nullptr || poses_.find(config_.virtual_laser_scan[frame], cloud->frame_id, cloud->stamp,
                                          cloud_poses_[c], counters_.why_no_pose))
        continue;
      ++counters_.no_pose;
      why_unplaced_[frame] = counters_.why_no_pose;
      return false;
    }
    return true;
  }
  /// The scans of one of the frames.
  void publish(std::size_t frame, Stamp stamp, Stamp now) {
    // Several frames on one topic share the cloud's stamp; consumers want stamps that increase.
    stamp = stamps_[std::min(frame, stamps_.size() - 1)].next(stamp);
    ++counters_.published;
    counters_.last_published = now;
    for (std::size_t i = 0; i < scans_.size(); ++i) {
      scans_[i].frame_id = config_.virtual_laser_scan[frame];
      scans_[i].stamp = stamp;
      context_.router.publish(*topics_[frame][i], scans_[i], now);
    }
  }

  VirtualScanConfig config_;
  const MakerContext& context_;
  const FrameTree& poses_;
  bool needs_vehicle_ = true;  // the cloud's place on the vehicle
  std::optional<Virtualizer> virtualizer_;
  std::vector<Pose> cloud_poses_{Pose::Identity()};  // of each lidar's cloud in the frame at hand
  std::vector<PlacedCloud> single_{PlacedCloud()};
  CloudMotion motion_;             // of the cloud of a single lidar
  std::vector<PlanarScan> scans_;  // the first is the entry's own, then those of `also`
  std::vector<VirtualScan> outputs_;
  std::vector<std::vector<const OutputTopic*>> topics_;  // of scans_, for each frame
  Stamp last_instant_{};                                 // of the clouds
  std::vector<SteadyStamps> stamps_;                     // one for all where the frames share a topic
  std::vector<std::string>
      why_unplaced_;  // why the newest cloud could not be seen from a frame; empty: it could
  MakerCounters counters_;
  std::uint64_t without_rings_ = 0;  // clouds that are points alone
  PoseGate gate_;
};

}  // namespace

std::unique_ptr<Maker> make_maker(const VirtualScanConfig& config, const MakerContext& context) {
  return std::make_unique<VirtualScanMaker>(config, context);
}

}  // namespace lidard
