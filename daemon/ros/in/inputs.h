// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/health/diagnostics.h"
#include "daemon/ros/in/component.h"
#include "drivers/model.h"

namespace lidard {

/// A sensor whose data another node publishes: its name in the configuration and the topic.
struct TopicSource {
  std::string sensor;
  std::string topic;
  bool packets = false;                ///< the topic carries velodyne_msgs/VelodyneScan for a driver of ours
  std::optional<FrameKind> kind = {};  ///< needed by the outputs; unset: any
  friend bool operator==(const TopicSource& a, const TopicSource& b) {
    return a.sensor == b.sensor && a.topic == b.topic && a.packets == b.packets && a.kind == b.kind;
  }
};

std::vector<TopicSource> topic_sources(const Config& config);

/// Counters of one topic source since the start.
struct SourceReport : TopicSource {
  std::string type;                       ///< ROS type; empty while nobody publishes
  std::uint64_t messages = 0;             ///< received, good or bad
  std::uint64_t rejected = 0;             ///< unusable messages
  std::uint64_t dropped = 0;              ///< messages dropped because the sensor thread was behind
  std::uint64_t points_dropped = 0;       ///< points whose coordinates are not finite
  std::uint64_t without_times = 0;        ///< clouds that count as measured at one instant
  std::uint64_t intensities_ignored = 0;  ///< scans whose intensities are not as many as their ranges
  std::string last_reason;                ///< why the last unusable one was not used
  std::chrono::steady_clock::time_point rejected_at{};  ///< when that was
  std::string wrong_type;  ///< why the topic is not subscribed: its type, and the one expected
};

/// Reads a message of a source, and counts in its report what is left out. Returns nullptr, or the fault.
const char* read_message(const sensor_msgs::LaserScan& message, const ClockStep& clock, PlanarScan& scan,
                         SourceReport& report);
const char* read_message(const sensor_msgs::PointCloud2& message, const ClockStep& clock, Cloud& cloud,
                         SourceReport& report);

/// Subscribes LaserScan, PointCloud2 and VelodyneScan topics of other nodes. The type comes from the master,
/// asked in the master thread; the callback thread converts and hands the result on.
class RosInputs : public RosComponent {
 public:
  RosInputs(const std::vector<TopicSource>& sources, RosPost post,
            SharedClockStep clock = std::make_shared<ClockStep>());
  ~RosInputs() override;

  void connected(RosCallbackThread& ros) override {
    ros_ = &ros;
    connected_at_ = std::chrono::steady_clock::now();
  }
  void poll(MasterClient& master) override;
  std::vector<DiagnosticItem> diagnostics() override;
  std::vector<SourceReport> report() const;

 protected:
  void disconnected() override;

 private:
  struct Source;
  void subscribe(const std::shared_ptr<Source>& source, const std::string& type);
  template <typename Message, typename Read>
  void subscribe_as(const MessageType& type, const std::shared_ptr<Source>& source, Read read);

  const RosPost post_;
  const SharedClockStep clock_;
  std::vector<std::shared_ptr<Source>> sources_;
  RosCallbackThread* ros_ = nullptr;  // while ROS runs
  std::chrono::steady_clock::time_point connected_at_{};
};

}  // namespace lidard
