// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

class MasterClient;
class MessageReceiver;
struct ChangeableOutput;
class RosCallbackThread;

/// Something else that needs the ROS connection. All calls come from the master thread.
class RosComponent {
 public:
  virtual ~RosComponent() = default;
  /// ROS runs: handles of `ros` may be used until disconnected(). May wait for the master.
  virtual void connected(RosCallbackThread& ros) = 0;
  /// ROS ends, and `ros` next: nobody is called back any more, and handles must be given up now.
  virtual void disconnected() {}
  /// Twice a second while the master answers.
  virtual void poll(MasterClient& /*master*/) {}
  /// The master was restarted, and is told the topics of this node by others. Returns the services of the
  /// component, which it is to be told too.
  virtual std::vector<std::string> master_restarted() { return {}; }
  /// Frame topics that are to be advertised anew, since what they carry changed its shape.
  virtual std::vector<std::string> stale_topics() { return {}; }
  virtual std::vector<DiagnosticItem> diagnostics() { return {}; }
};

/// Has a task done in the thread of the pipeline, with the time of the host, or of the replay, at which the
/// task came. Called in the callback thread; must not wait.
using RosPost = std::function<void(std::function<void(Stamp received)> task)>;

/// Subscribes to the topics that tell how the vehicle moves: nav_msgs/Odometry, or sensor_msgs/Imu with a
/// speed (geometry_msgs/TwistStamped).
std::shared_ptr<RosComponent> make_ros_motion(const VehicleConfig& vehicle, RosPost post,
                                              MessageReceiver& receiver);
/// dynamic_reconfigure servers of the merged and virtual scans. The callback thread answers requests and
/// hands on what is accepted. The parameter server is written in the master thread, so that a master that
/// hangs holds up nobody; dynamic_reconfigure::Server would write it in the answering thread.
std::shared_ptr<RosComponent> make_ros_reconfigure(std::vector<ChangeableOutput> outputs, const RosPost& post,
                                                   MessageReceiver& receiver);

}  // namespace lidard
