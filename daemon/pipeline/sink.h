// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/pose.h"
#include "core/frames/cloud.h"
#include "core/frames/device_message.h"
#include "core/frames/scan.h"
#include "daemon/config/config.h"

namespace lidard {

enum class Health : std::uint8_t { ok, warn, error, stale };

/// One status of /diagnostics. Keys as in REP 138 where it has one; `hardware_id` is the serial number (REP
/// 107).
struct DiagnosticItem {
  std::string name;
  std::string hardware_id{};
  Health health = Health::ok;
  std::string message{};  ///< one sentence; says the remedy when health is not ok
  std::vector<std::pair<std::string, std::string>> values{};
  bool logged = false;          ///< its source logs changes
  bool awaited = false;         ///< it has not come yet since the start, so nothing of it broke
  std::optional<bool> is_up{};  ///< of a lidar, a port or a connection that data need: counted in one line

  void set(Health level, std::string sentence) {
    health = level;
    message = std::move(sentence);
  }
  void add(std::string key, std::string value) { values.emplace_back(std::move(key), std::move(value)); }
  void add(std::string key, std::uint64_t number) { add(std::move(key), std::to_string(number)); }
};

/// The items of both workers. Items with one name are joined, with the worse message and the values of both.
inline std::vector<DiagnosticItem> joined(const std::vector<DiagnosticItem>& items,
                                          std::vector<DiagnosticItem> more) {
  std::vector<DiagnosticItem> all = items;
  for (DiagnosticItem& item : more) {
    const auto known = std::find_if(all.begin(), all.end(),
                                    [&](const DiagnosticItem& one) { return one.name == item.name; });
    if (known == all.end()) {
      all.push_back(std::move(item));
      continue;
    }
    if (item.health > known->health) known->set(item.health, item.message);
    known->values.insert(known->values.end(), item.values.begin(), item.values.end());
  }
  return all;
}

/// What travels on a topic. Refers to what the caller holds.
struct Payload : std::variant<const PlanarScan*, Cloud*, MergedCloud*, const DeviceMessage*,
                              const std::vector<StaticTransform>*, const Stamp*> {
  Payload(const PlanarScan& scan) : variant(&scan) {}
  /// The receiver of a cloud may swap out its points_bytes.
  Payload(Cloud& cloud) : variant(&cloud) {}
  Payload(MergedCloud& cloud) : variant(&cloud) {}
  Payload(const DeviceMessage& message) : variant(&message) {}
  Payload(const std::vector<StaticTransform>& transforms) : variant(&transforms) {}
  /// The time of a replay.
  Payload(const Stamp& now) : variant(&now) {}
};

/// Gets what the pipeline finished: ROS, a bag, a file, a test. Called from the sensor thread; must not
/// block. The topics are entries of output_topics() of the pipeline's configuration.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// False while the topic has no consumer, so that its frames need not be made.
  virtual bool wants(const OutputTopic& /*topic*/) const { return true; }
  /// Called in place of publish() for a frame that was not made, since no sink wants it.
  virtual void skip(const OutputTopic& /*topic*/, Stamp /*released*/) {}
  /// `released`: arrival of the packet that completed the frame.
  virtual void publish(const OutputTopic& topic, const Payload& payload, Stamp released) = 0;
  virtual void transforms(const std::vector<StaticTransform>& /*transforms*/, Stamp /*released*/) {}
  /// The newest items of the pipeline of a worker.
  virtual void diagnostics(const std::vector<DiagnosticItem>& /*items*/, Stamp /*released*/,
                           Worker /*worker*/) {}
};

}  // namespace lidard
