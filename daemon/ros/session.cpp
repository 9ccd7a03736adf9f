// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/session.h"

#include <algorithm>
#include <utility>

#include "daemon/ros/in/inputs.h"
#include "daemon/ros/in/output_items.h"
#include "daemon/ros/in/tf_poses.h"
#include "daemon/ros/out/publisher_thread.h"

namespace lidard {
namespace {

bool has_output(const Config& config, const ChangeableOutput& output) {
  const OutputId& id = output.id;
  if (output.sensor) return config.find_sensor(id.entry) != nullptr;
  const auto named = [&](const auto& entry) { return entry.name == id.entry; };
  return id.kind == OutputId::Kind::merged
             ? std::any_of(config.merged_scans.begin(), config.merged_scans.end(), named)
             : std::any_of(config.virtual_scans.begin(), config.virtual_scans.end(), named);
}

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

/// The components of one pipeline, with their configuration.
struct RosSession::Fed {
  Fed(MessageReceiver& pipeline, Post how) : receiver(pipeline), post(std::move(how)) {}
  MessageReceiver& receiver;
  const Post post;
  std::shared_ptr<RosComponent> inputs, motion, reconfigure, outline;
  std::vector<TopicSource> sources;
  std::array<std::string, 3> motion_topics;
  std::pair<std::string, std::vector<Eigen::Vector2d>> shape;
};

RosSession::RosSession(const Config& planes, const Config& clouds, const RosOptions& options)
    : RosConnection(options, output_topics(planes), output_topics(clouds)),
      reconfigure_(options.reconfigure),
      poses_(std::make_shared<TfPoses>(step())) {
  add(poses_);
}
RosSession::~RosSession() = default;

TransformSource& RosSession::poses() { return *poses_; }

void RosSession::feed(const Config& config, const Config& whole, MessageReceiver& pipeline, Post post) {
  fed_.push_back(std::make_unique<Fed>(pipeline, std::move(post)));
  renew(*fed_.back(), config, whole);
}

void RosSession::change(const Config& whole, const std::array<Config, 2>& parts) {
  check_ros_names(output_topics(whole));
  for (std::size_t i = 0; i < fed_.size(); ++i) renew(*fed_[i], parts.at(i), whole);
}

/// Replaces the components whose configuration changed. The servers of dynamic_reconfigure are always new: a
/// change by hand ends with the next configuration.
void RosSession::renew(Fed& fed, const Config& config, const Config& whole) {
  const auto replace = [this](std::shared_ptr<RosComponent>& place, std::shared_ptr<RosComponent> next) {
    const auto former = std::exchange(place, next);
    add(std::move(next), former);
  };
  const VehicleConfig& vehicle = config.vehicle;
  auto sources = topic_sources(config);
  if (fed.inputs == nullptr || !(sources == fed.sources)) {
    replace(fed.inputs, std::make_shared<RosInputs>(sources, fed.post, fed.receiver, step()));
    fed.sources = std::move(sources);
  }
  const std::array topics{vehicle.odometry_topic, vehicle.imu_topic, vehicle.speed_topic};
  if (fed.motion == nullptr || topics != fed.motion_topics)
    replace(fed.motion, make_ros_motion(vehicle, fed.post, fed.receiver, step()));
  fed.motion_topics = topics;
  auto outputs = changeable_outputs(whole, reconfigure_);
  const auto is_foreign = [&](const ChangeableOutput& output) { return !has_output(config, output); };
  outputs.erase(std::remove_if(outputs.begin(), outputs.end(), is_foreign), outputs.end());
  replace(fed.reconfigure, make_ros_reconfigure(std::move(outputs), fed.post, fed.receiver));
  const std::pair shape{vehicle.base_frame, vehicle.footprint};
  if (&fed == fed_.front().get() && shape != fed.shape)
    replace(fed.outline, std::make_shared<Outline>(vehicle));
  fed.shape = shape;
}

}  // namespace lidard
