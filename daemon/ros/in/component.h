// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <any>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/host_clock.h"
#include "daemon/config/config.h"
#include "daemon/health/diagnostics.h"
#include "daemon/live/wait_until.h"
#include "daemon/ros/in/callback_thread.h"
#include "daemon/ros/messages/raw_message.h"

namespace lidard {

class MasterClient;
class MessageReceiver;
struct Reconfigurable;

/// A part that needs the ROS connection. All calls but retire() come from the master thread.
class RosComponent {
 public:
  virtual ~RosComponent() = default;
  /// ROS runs: `ros` may be used until disconnect(). May wait for the master.
  virtual void connected(RosCallbackThread& ros) = 0;
  /// Twice a second while the master answers.
  virtual void poll(MasterClient& /*master*/) {}
  /// The master was restarted; the topics of this node are registered elsewhere. Returns the component's
  /// services, to be registered too.
  virtual std::vector<std::string> master_restarted() { return {}; }
  /// Frame topics to be advertised anew, since the shape of their frames changed.
  virtual std::vector<std::string> stale_topics() { return {}; }
  virtual std::vector<DiagnosticItem> diagnostics() { return {}; }
  /// A reload replaces the component, which still runs until the master answers: what it posts is dropped
  /// from now on. Called in the sensor thread.
  virtual void retire() {}
  /// Drops all parts kept: nothing calls the component afterwards. May wait for the master, unless `leave`.
  void disconnect(bool leave) {
    if (leave) leave_behind(std::exchange(kept_, {}));
    kept_.clear();
    disconnected();
  }

 protected:
  virtual void disconnected() {}
  /// Keeps a subscriber, publisher, server or listener until disconnect().
  template <class Part>
  void keep(Part part) {
    kept_.emplace_back(std::move(part));
  }
  /// Calls use(message pointer) for each message of a topic.
  template <class Message, class Use>
  void subscribe(RosCallbackThread& ros, const std::string& topic, std::uint32_t queue_size, Use use,
                 const MessageType& type = type_of<Message>(), const ros::TransportHints& hints = {}) {
    ros::SubscribeOptions options;
    options.init<Message>(topic, queue_size,
                          boost::function<void(const boost::shared_ptr<const Message>&)>(std::move(use)));
    options.md5sum = type.md5;
    options.datatype = type.name;
    options.transport_hints = hints;
    keep(ros.node().subscribe(options));
  }

 private:
  std::vector<std::any> kept_;
};

/// Runs a task for the pipeline that has the sensor, for all pipelines if it is empty, in their threads, with
/// the host's or the replay's time at which the task came. Called in the callback thread; must not wait.
using RosTask = std::function<void(MessageReceiver& pipeline, Stamp received)>;
using RosPost = std::function<void(const std::string& sensor, RosTask task)>;

/// Converts the stamps of messages, which are the host's, to the time of the pipelines.
using SharedClockStep = std::shared_ptr<const ClockStep>;

/// Subscribes to the topics of the vehicle's motion: nav_msgs/Odometry, or sensor_msgs/Imu with a speed
/// (geometry_msgs/TwistStamped), for all pipelines.
std::shared_ptr<RosComponent> make_ros_motion(const VehicleConfig& vehicle, RosPost post,
                                              SharedClockStep clock);
/// dynamic_reconfigure servers of the merged and virtual scans. The callback thread answers requests and
/// passes on what is accepted. The parameter server is written in the master thread, so that a hanging
/// master delays no answer; dynamic_reconfigure::Server would write it in the answering thread.
std::shared_ptr<RosComponent> make_ros_reconfigure(std::vector<Reconfigurable> outputs, const RosPost& post);

}  // namespace lidard
