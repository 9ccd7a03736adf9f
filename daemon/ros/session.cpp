// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/session.h"

#include <ros/time.h>

#include <utility>

#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/in/inputs.h"
#include "daemon/ros/in/output_items.h"
#include "daemon/ros/in/tf_poses.h"
#include "daemon/ros/messages/convert.h"
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

RosSession::RosSession(const Config& config, const RosOptions& options)
    : RosConnection(options, output_topics(config)),
      names_(options.reconfigure),
      clock_step_(options.clock_step),
      poses_(std::make_shared<TfPoses>(clock_step_)) {
  add(poses_);
}

TransformSource& RosSession::poses() { return *poses_; }

void RosSession::feed(const Config& config, RosPost post) {
  post_ = [post = std::move(post), clock = clock_step_](const std::string& sensor, const RosTask& task) {
    // In a simulation (/use_sim_time) messages are stamped by /clock, which may not have come yet.
    const ros::Time simulated = ros::Time::isSimTime() ? ros::Time::now() : ros::Time();
    post(sensor, [=](MessageReceiver& to, Stamp received) {
      const Stamp now = simulated.isZero() ? received : clock->steady(from_ros(simulated));
      to.set_message_clock(now - received);
      task(to, received);
    });
  };
  renew(nullptr, config);
}

void RosSession::change(const Config& before, const Config& config) {
  check_ros_names(output_topics(config));
  renew(&before, config);
}

/// Replaces the components whose configuration changed. The servers of dynamic_reconfigure are always new: a
/// change by hand ends with the next configuration.
void RosSession::renew(const Config* before, const Config& config) {
  const auto replace = [this](std::shared_ptr<RosComponent>& component, std::shared_ptr<RosComponent> next) {
    const auto former = std::exchange(component, next);
    if (former != nullptr) former->retire();
    add(std::move(next), former);
  };
  const auto sources = topic_sources(config);
  if (before == nullptr || !(sources == topic_sources(*before)))
    replace(inputs_, std::make_shared<RosInputs>(sources, post_, clock_step_));
  if (before == nullptr || !(config.vehicle == before->vehicle)) {
    replace(motion_, make_ros_motion(config.vehicle, post_, clock_step_));
    replace(outline_, std::make_shared<Outline>(config.vehicle));
  }
  replace(reconfigure_, make_ros_reconfigure(changeable_outputs(config, names_), post_));
}

}  // namespace lidard
