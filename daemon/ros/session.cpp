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

}  // namespace

/// The components of one worker, with their configuration.
struct RosSession::Fed {
  std::shared_ptr<RosComponent> inputs, motion;
  std::vector<TopicSource> sources;
  std::array<std::string, 3> motion_topics;
};

RosSession::RosSession(const Config& config, const RosOptions& options)
    : RosConnection(options, output_topics(config)),
      names_(options.reconfigure),
      poses_(std::make_shared<TfPoses>(step())) {
  add(poses_);
  for (auto& fed : fed_) fed = std::make_unique<Fed>();
}
RosSession::~RosSession() = default;

TransformSource& RosSession::poses() { return *poses_; }

void RosSession::feed(const Config& config, Post post) {
  post_ = std::move(post);
  renew(config);
}

void RosSession::change(const Config& config) {
  check_ros_names(output_topics(config));
  renew(config);
}

void RosSession::replace(std::shared_ptr<RosComponent>& place, std::shared_ptr<RosComponent> next) {
  const auto former = std::exchange(place, next);
  add(std::move(next), former);
}

/// Replaces the components whose configuration changed. The servers of dynamic_reconfigure are always new: a
/// change by hand ends with the next configuration.
void RosSession::renew(const Config& config) {
  for (const Worker worker : {Worker::sensors, Worker::clouds})
    renew(*fed_[static_cast<std::size_t>(worker)], config, worker);
  replace(reconfigure_, make_ros_reconfigure(changeable_outputs(config, names_), post_));
  const std::pair shape{config.vehicle.base_frame, config.vehicle.footprint};
  if (shape != shape_) replace(outline_, std::make_shared<Outline>(config.vehicle));
  shape_ = shape;
}

void RosSession::renew(Fed& fed, const Config& config, Worker worker) {
  auto sources = topic_sources(config, worker);
  if (fed.inputs == nullptr || !(sources == fed.sources))
    replace(fed.inputs, std::make_shared<RosInputs>(sources, worker, post_, step()));
  fed.sources = std::move(sources);
  const VehicleConfig vehicle = vehicle_for(config, worker);
  const std::array topics{vehicle.odometry_topic, vehicle.imu_topic, vehicle.speed_topic};
  if (fed.motion == nullptr || topics != fed.motion_topics)
    replace(fed.motion, make_ros_motion(vehicle, worker, post_, step()));
  fed.motion_topics = topics;
}

}  // namespace lidard
