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

#include "core/base/time.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/sink.h"
#include "daemon/ros/in/callback_thread.h"
#include "daemon/ros/master/wait_until.h"
#include "daemon/ros/messages/raw_message.h"

namespace lidard {

class MasterClient;
class MessageReceiver;
struct ChangeableOutput;

/// Something that lives by the ROS connection. All calls come from the master thread.
class RosComponent {
 public:
  virtual ~RosComponent() = default;
  /// ROS runs: `ros` may be used until disconnect(). May wait for the master.
  virtual void connected(RosCallbackThread& ros) = 0;
  /// Twice a second while the master answers.
  virtual void poll(MasterClient& /*master*/) {}
  /// The master was restarted, and gets the topics of this node from others. Returns the services of the
  /// component, which it has to get too.
  virtual std::vector<std::string> master_restarted() { return {}; }
  /// Frame topics that are to be advertised anew, since what they carry changed its shape.
  virtual std::vector<std::string> stale_topics() { return {}; }
  virtual std::vector<DiagnosticItem> diagnostics() { return {}; }
  /// Gives up what was kept: from now on nothing calls the component. May wait for the master, unless
  /// `leave`.
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

/// Has a task done in the thread of the pipeline, with the time of the host, or of the replay, at which the
/// task came. Called in the callback thread; must not wait.
using RosPost = std::function<void(std::function<void(Stamp received)> task)>;

/// By how much the host's clock was set since the beginning: messages are stamped with the host's clock,
/// pipelines count time without steps.
using HostStep = std::shared_ptr<const std::atomic<Span>>;
inline HostStep no_step() { return std::make_shared<const std::atomic<Span>>(Span(0)); }

/// The master is asked every half second, then a connection is made: until then nobody is missing.
inline bool may_still_come(std::chrono::steady_clock::time_point connected_at) {
  return std::chrono::steady_clock::now() - connected_at < std::chrono::seconds(2);
}

/// Subscribes to the topics of the vehicle's motion: nav_msgs/Odometry, or sensor_msgs/Imu with a speed
/// (geometry_msgs/TwistStamped).
std::shared_ptr<RosComponent> make_ros_motion(const VehicleConfig& vehicle, RosPost post,
                                              MessageReceiver& receiver, HostStep step);
/// dynamic_reconfigure servers of the merged and virtual scans. The callback thread answers requests and
/// passes on what is accepted. The parameter server is written in the master thread, so that a master that
/// hangs holds up nobody; dynamic_reconfigure::Server would write it in the answering thread.
std::shared_ptr<RosComponent> make_ros_reconfigure(std::vector<ChangeableOutput> outputs, const RosPost& post,
                                                   MessageReceiver& receiver);

}  // namespace lidard
