// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "daemon/ros/ros_link.h"
#include "drivers/model.h"

namespace lidard {

struct RosReception;

/// A sensor whose data another node publishes: its name in the configuration and the topic.
struct TopicSource {
  std::string sensor;
  std::string topic;
  bool packets = false;                ///< the topic carries velodyne_msgs/VelodyneScan for a driver of ours
  std::optional<FrameKind> kind = {};  ///< what it is taken for; unset: nobody minds
};

/// Where the messages of topic sources go; called in the sensor thread. `received` is the host's time of
/// arrival.
struct TopicHandlers {
  std::function<void(const std::string& sensor, PlanarScan& scan, Stamp received)> scan;
  std::function<void(const std::string& sensor, Cloud& cloud, Stamp received)> cloud;
  /// `arrival` is when the node that sends the message received the packet.
  std::function<void(const std::string& sensor, ByteView packet, Stamp arrival, Stamp received)> packet = {};
};

/// What happened to one topic source since the start.
struct TopicReport {
  std::string sensor;
  std::string topic;
  std::string type;                       ///< ROS type; empty while nobody publishes
  std::uint64_t messages = 0;             ///< received, good or bad
  std::uint64_t rejected = 0;             ///< unusable messages
  std::uint64_t dropped = 0;              ///< messages dropped because the sensor thread was behind
  std::uint64_t points_dropped = 0;       ///< points whose coordinates are not finite
  std::uint64_t intensities_ignored = 0;  ///< scans whose intensities are not as many as their ranges
  std::string last_reason;                ///< why the last unusable one was not used
  std::string wrong_type;                 ///< why the topic is not subscribed: its type, and the one expected
};

/// Subscribes LaserScan, PointCloud2 and VelodyneScan topics of other nodes. The type comes from the master,
/// asked in the master thread; one thread of its own converts and hands the result to the sensor thread.
class RosInputs : public RosClient {
 public:
  /// Runs a function in the sensor thread.
  using Post = std::function<void(std::function<void()>)>;

  RosInputs(const std::vector<TopicSource>& sources, Post post, TopicHandlers handlers);
  ~RosInputs() override;

  void connected() override;
  void disconnected(bool leave) override;
  void poll(MasterClient& master) override;
  std::vector<DiagnosticItem> diagnostics() override;
  std::vector<TopicReport> report() const;

 private:
  struct Source;
  void subscribe(const std::shared_ptr<Source>& source, const std::string& type);
  template <typename Message, typename Frame>
  void subscribe_as(const std::shared_ptr<Source>& source,
                    const std::function<void(const std::string&, Frame&, Stamp)>& handler);
  void subscribe_packets(const std::shared_ptr<Source>& source);

  Post post_;
  TopicHandlers handlers_;
  std::vector<std::shared_ptr<Source>> sources_;
  std::unique_ptr<RosReception> reception_;
};

}  // namespace lidard
