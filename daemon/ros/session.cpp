// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/session.h"

#include <utility>

#include "daemon/config/workers.h"
#include "daemon/ros/in/inputs.h"
#include "daemon/ros/in/output_items.h"
#include "daemon/ros/in/tf_poses.h"
#include "daemon/ros/out/publisher_thread.h"

namespace lidard {
namespace {

/// Publishes the outline of the vehicle, latched.
class Outline final : public RosComponent {
 public:
  explicit Outline(const VehicleConfig& vehicle)
      : exists_(!vehicle.footprint.empty()), outline_(outline_of(vehicle)) {}
  void connected(RosCallbackThread&) override {
    if (!exists_) return;
    auto publisher = make_publisher(outline_topic, *outline_.type, 1, true);
    publisher.publish(outline_);
    keep(publisher);
  }

 private:
  const bool exists_;
  const RawMessage outline_;
};

std::array<std::string, 3> motion_topics(const VehicleConfig& vehicle) {
  return {vehicle.odometry_topic, vehicle.imu_topic, vehicle.speed_topic};
}

}  // namespace

RosSession::RosSession(const Config& config, const RosOptions& options)
    : RosConnection(options, output_topics(config)),
      names_(options.reconfigure),
      clock_step_(options.clock_step),
      poses_(std::make_shared<TfPoses>(clock_step_)) {
  add(poses_);
}

TransformSource& RosSession::poses() { return *poses_; }

void RosSession::feed(const Config& config, Post post) {
  post_ = std::move(post);
  renew(nullptr, config);
}

void RosSession::change(const Config& before, const Config& config) {
  check_ros_names(output_topics(config));
  renew(&before, config);
}

/// Replaces the components whose configuration changed. The servers of dynamic_reconfigure are always new: a
/// change by hand ends with the next configuration.
void RosSession::renew(const Config* before, const Config& config) {
  const auto replace = [this](std::shared_ptr<RosComponent>& place, std::shared_ptr<RosComponent> next) {
    const auto former = std::exchange(place, next);
    add(std::move(next), former);
  };
  for (const Worker worker : {Worker::sensors, Worker::clouds}) {
    auto& [inputs, motion] = fed_[static_cast<std::size_t>(worker)];
    const auto sources = topic_sources(config, worker);
    if (before == nullptr || !(sources == topic_sources(*before, worker)))
      replace(inputs, std::make_shared<RosInputs>(sources, worker, post_, clock_step_));
    const VehicleConfig vehicle = vehicle_for(config, worker);
    if (before == nullptr || motion_topics(vehicle) != motion_topics(vehicle_for(*before, worker)))
      replace(motion, make_ros_motion(vehicle, worker, post_, clock_step_));
  }
  replace(reconfigure_, make_ros_reconfigure(changeable_outputs(config, names_), post_));
  const VehicleConfig& vehicle = config.vehicle;
  if (before == nullptr || vehicle.base_frame != before->vehicle.base_frame ||
      vehicle.footprint != before->vehicle.footprint)
    replace(outline_, std::make_shared<Outline>(vehicle));
}

}  // namespace lidard
