// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <iterator>
#include <memory>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/ros/output_items.h"
#include "daemon/ros/ros_connection.h"
#include "daemon/ros/ros_inputs.h"
#include "daemon/ros/ros_outline.h"
#include "daemon/ros/tf_poses.h"

namespace lidard {

/// All that pipelines have to do with ROS: sinks for what they produce, poses from tf, and, once feed() is
/// called, what other nodes publish for them and change of them. The same live, in replay and in the
/// drop-ins.
class RosSession : public RosConnection {
 public:
  /// One pipeline does everything. Throws RosError.
  RosSession(const Config& config, const RosOptions& options) : RosSession(config, Config(), options) {}
  /// Two pipelines share the work: `clouds` as part_of() gives it.
  RosSession(const Config& planes, const Config& clouds, const RosOptions& options)
      : RosConnection(options, output_topics(planes), output_topics(clouds)),
        reconfigure_(options.reconfigure),
        poses_(std::make_shared<TfPoses>()) {
    add(poses_);
  }

  /// tf; must not be used after the session ended.
  TransformSource& poses() { return *poses_; }
  /// Lets messages of `topic:` and `packet_topic:` sensors, of the vehicle's motion and of
  /// dynamic_reconfigure reach the pipeline, which must outlive the session's use. `config` is that of the
  /// pipeline. To be called before start().
  /// `whole`: the configuration that `config` is a part of.
  void feed(const Config& config, const Config& whole, MessageReceiver& pipeline, RosPost post) {
    fed_.push_back(std::make_unique<Fed>(pipeline, std::move(post)));
    for (auto& [former, next] : renewed(*fed_.back(), config, whole)) add(next);
  }
  /// What another configuration changes; `parts` by lane, for the pipelines in the order of feed().
  RosChange change_to(const Config& whole, const std::array<Config, 2>& parts) {
    RosChange change{output_topics(parts[0]), output_topics(parts[1]), {}, {}};
    check_ros_names(change.topics);
    check_ros_names(change.clouds);
    for (std::size_t i = 0; i < fed_.size(); ++i) {
      auto components = renewed(*fed_[i], parts.at(i), whole);
      std::move(components.begin(), components.end(), std::back_inserter(change.components));
    }
    return change;
  }
  /// By how much the host's clock was set since the beginning. Pipelines reckon without steps, ROS with the
  /// host's clock.
  void set_step(Span step) {
    for (const auto& fed : fed_) fed->receiver.step = step;
    poses_->set_step(step);
    RosConnection::set_step(step);
  }

 private:
  static bool has_output(const Config& config, const ChangeableOutput& output) {
    const OutputId& id = output.id;
    if (output.sensor) {
      const SensorConfig* const sensor = config.find_sensor(id.entry);
      return sensor != nullptr && !sensor->handed_over;
    }
    const auto named = [&](const auto& entry) { return entry.name == id.entry; };
    return id.kind == OutputId::Kind::merged
               ? std::any_of(config.merged_scans.begin(), config.merged_scans.end(), named)
               : std::any_of(config.virtual_scans.begin(), config.virtual_scans.end(), named);
  }
  /// What comes in is stamped with the host's clock.
  struct WithoutSteps final : MessageReceiver {
    explicit WithoutSteps(MessageReceiver& receiver) : to(receiver) {}
    void packet_message(const std::string& sensor, const Packet& packet, Stamp received) override {
      Packet same = packet;
      same.arrival = packet.arrival - step.load();
      to.packet_message(sensor, same, received);
    }
    void scan_message(const std::string& sensor, PlanarScan& scan, Stamp received) override {
      scan.stamp = scan.stamp - step.load();
      to.scan_message(sensor, scan, received);
    }
    void cloud_message(const std::string& sensor, Cloud& cloud, Stamp received) override {
      cloud.stamp = cloud.stamp - step.load();
      to.cloud_message(sensor, cloud, received);
    }
    void pose_message(Stamp stamp, const Pose& pose, const std::string& child, Stamp received) override {
      to.pose_message(stamp - step.load(), pose, child, received);
    }
    void turn_message(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame,
                      Stamp received) override {
      to.turn_message(stamp - step.load(), rates, frame, received);
    }
    void speed_message(double speed) override { to.speed_message(speed); }
    std::string set_output(const OutputId& output, const OutputScanConfig& wanted) override {
      set_by_hand = true;
      return to.set_output(output, wanted);
    }
    std::string set_sensor(const SensorConfig& wanted) override { return to.set_sensor(wanted); }

    MessageReceiver& to;
    std::atomic<Span> step{Span(0)};
    std::atomic<bool> set_by_hand{false};  // an output is no longer what the configuration says
  };
  /// What comes in for one pipeline, with the words of the configuration that it follows from.
  struct Fed {
    Fed(MessageReceiver& pipeline, RosPost how) : receiver(pipeline), post(std::move(how)) {}
    WithoutSteps receiver;
    RosPost post;
    std::array<std::string, 4> texts;
    std::array<std::shared_ptr<RosComponent>, 4> components;
  };
  using Renewed = std::vector<std::pair<std::shared_ptr<RosComponent>, std::shared_ptr<RosComponent>>>;
  /// Makes the components that follow from other words than before; each with the one that it replaces.
  Renewed renewed(Fed& fed, const Config& config, const Config& whole) const {
    std::array<std::string, 4> texts = texts_of(config);
    Renewed all;
    for (std::size_t i = 0; i < texts.size(); ++i) {
      const bool by_hand = i == 2 && fed.receiver.set_by_hand.exchange(false);
      if (fed.components[i] != nullptr && texts[i] == fed.texts[i] && !by_hand) continue;
      all.emplace_back(fed.components[i], make(i, fed, config, whole));
      fed.components[i] = all.back().second;
    }
    fed.texts = std::move(texts);
    return all;
  }
  static std::array<std::string, 4> texts_of(const Config& config) {
    std::string sources, outputs;
    for (const TopicSource& source : topic_sources(config))
      sources += fmt::format("{} {} {} {}\n", source.sensor, source.topic, source.packets,
                             source.kind ? static_cast<int>(*source.kind) : -1);
    for (const auto& merged : config.merged_scans) outputs += to_yaml(merged);
    for (const auto& group : config.virtual_scans) outputs += to_yaml(group);
    const std::string vehicle = to_yaml(config.vehicle);
    return {sources, vehicle, outputs, vehicle};
  }
  std::shared_ptr<RosComponent> make(std::size_t which, Fed& fed, const Config& config,
                                     const Config& whole) const {
    if (which == 0) return std::make_shared<RosInputs>(topic_sources(config), fed.post, fed.receiver);
    if (which == 1) return make_ros_motion(config.vehicle, fed.post, fed.receiver);
    const bool is_first = &fed == fed_.front().get();
    if (which == 3) return std::make_shared<RosOutline>(is_first ? config.vehicle : VehicleConfig());
    auto outputs = changeable_outputs(whole, reconfigure_);
    const auto is_foreign = [&](const ChangeableOutput& output) { return !has_output(config, output); };
    outputs.erase(std::remove_if(outputs.begin(), outputs.end(), is_foreign), outputs.end());
    return make_ros_reconfigure(std::move(outputs), fed.post, fed.receiver);
  }

  const ReconfigureNames reconfigure_;
  const std::shared_ptr<TfPoses> poses_;
  std::vector<std::unique_ptr<Fed>> fed_;  // one for each pipeline
};

}  // namespace lidard
