// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/pose.h"
#include "core/base/time.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/output_id.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

class MasterClient;
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
  virtual void poll(MasterClient& master) { static_cast<void>(master); }
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

/// Where goes what comes in from ROS; called in the thread of the pipeline. `received` is when it came.
struct RosHandlers {
  std::function<void(const std::string& sensor, PlanarScan& scan, Stamp received)> scan;
  std::function<void(const std::string& sensor, Cloud& cloud, Stamp received)> cloud;
  /// `arrival` is when the node that sends the message received the packet.
  std::function<void(const std::string& sensor, ByteView packet, Stamp arrival, Stamp received)> packet = {};
  /// Pose of the message's child frame in the frame of the odometry.
  std::function<void(Stamp stamp, const Pose& pose, const std::string& child, Stamp received)> pose = {};
  /// Turn rates, rad/s, in `frame`.
  std::function<void(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame, Stamp received)>
      turn = {};
  /// Speed ahead, m/s.
  std::function<void(double speed)> speed = {};
  /// A change that dynamic_reconfigure has accepted.
  std::function<void(const OutputId& output, const OutputScanConfig& wanted)> change = {};
};

}  // namespace lidard
