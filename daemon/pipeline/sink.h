// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/base/pose.h"
#include "core/frames/cloud.h"
#include "core/frames/device_message.h"
#include "core/frames/scan.h"
#include "daemon/config/config.h"

namespace lidard {

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
  std::string hardware_id{};
  Health health = Health::ok;
  std::string message{};  ///< one sentence; says the remedy when health is not ok
  std::vector<std::pair<std::string, std::string>> values{};

  void set(Health level, std::string sentence) {
    health = level;
    message = std::move(sentence);
  }
  void add(std::string key, std::string value) { values.emplace_back(std::move(key), std::move(value)); }
  void add(std::string key, std::uint64_t number) { add(std::move(key), std::to_string(number)); }
};

/// Takes what the pipeline finished: ROS, a bag, a file, a test. Called from the sensor thread; must not
/// block. The topics are entries of output_topics() of the pipeline's configuration.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// `released`: arrival of the packet that completed the frame.
  virtual void scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) = 0;
  /// May swap out cloud.points_bytes.
  virtual void cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) = 0;
  virtual void message(const OutputTopic& /*topic*/, const DeviceMessage& /*message*/, Stamp /*released*/) {}
  virtual void transforms(const std::vector<StaticTransform>& /*transforms*/, Stamp /*released*/) {}
  virtual void diagnostics(const std::vector<DiagnosticItem>& /*items*/, Stamp /*released*/) {}
};

}  // namespace lidard
