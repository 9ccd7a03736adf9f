// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/base/pose.h"
#include "core/frames/cloud.h"
#include "core/frames/device_state.h"
#include "core/frames/gnss.h"
#include "core/frames/imu.h"
#include "core/frames/scan.h"

namespace lidard {

/// What travels on a topic. A scan with several echoes goes to a topic of its own (MultiEchoLaserScan).
enum class TopicKind : std::uint8_t { scan, echoes, cloud, fix, time_reference, imu, state };

/// One output topic; `name` as ROS has it (relative names are resolved by the sink).
struct TopicInfo {
  std::string name;
  TopicKind kind;
};

/// A fixed transform for /tf_static.
struct StaticTransform {
  std::string parent;
  std::string child;
  Pose pose;  ///< of child in parent
};

enum class Health : std::uint8_t { ok, warn, error, stale };

/// One status of /diagnostics. Keys as in REP 138 where it has one; `hardware_id` is the serial number (REP
/// 107).
struct DiagnosticItem {
  std::string name;
  std::string hardware_id;
  Health health = Health::ok;
  std::string message;  ///< one sentence; says the remedy when health is not ok
  std::vector<std::pair<std::string, std::string>> values;
};

/// Takes what the pipeline finished: ROS, a bag, a file, a test. Called from the sensor thread; must not
/// block. Topic kinds are known beforehand from pipeline_topics().
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// `released`: arrival of the packet that completed the frame.
  virtual void scan(const std::string& topic, const PlanarScan& scan, Stamp released) = 0;
  /// May swap out cloud.points_bytes.
  virtual void cloud(const std::string& topic, Cloud& cloud, Stamp released) = 0;
  virtual void fix(const std::string& topic, const GnssFix& fix, Stamp released) {
    static_cast<void>(topic), static_cast<void>(fix), static_cast<void>(released);
  }
  virtual void time_reference(const std::string& topic, const TimeReference& reference, Stamp released) {
    static_cast<void>(topic), static_cast<void>(reference), static_cast<void>(released);
  }
  virtual void imu(const std::string& topic, const ImuSample& sample, Stamp released) {
    static_cast<void>(topic), static_cast<void>(sample), static_cast<void>(released);
  }
  virtual void state(const std::string& topic, const DeviceState& state, Stamp released) {
    static_cast<void>(topic), static_cast<void>(state), static_cast<void>(released);
  }
  virtual void transforms(const std::vector<StaticTransform>& transforms, Stamp released) = 0;
  virtual void diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) = 0;
};

/// Where something was at a time.
struct StampedPose {
  Stamp stamp;
  Pose pose;
};

/// Poses that the configuration does not hold (tf). Must answer at once.
class PoseLookup {
 public:
  virtual ~PoseLookup() = default;
  /// Pose of `child` in `parent` at `stamp`; false and a reason when it is not known.
  virtual bool lookup(const std::string& parent, const std::string& child, Stamp stamp, Pose& pose,
                      std::string& why_not) = 0;
  /// Appends the poses of `child` in `parent` after `after` (of a restart: whatever is known) and not after
  /// `until`, oldest first, in steps of about 10 ms.
  virtual void history(const std::string& parent, const std::string& child, Stamp after, Stamp until,
                       std::vector<StampedPose>& poses) {
    static_cast<void>(parent), static_cast<void>(child), static_cast<void>(after);
    static_cast<void>(until), static_cast<void>(poses);
  }
};

}  // namespace lidard
