// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/pipeline/device_connections.h"
#include "daemon/pipeline/output_id.h"
#include "daemon/pipeline/output_report.h"
#include "daemon/pipeline/sensor_report.h"
#include "daemon/pipeline/sink.h"
#include "daemon/pipeline/transform_source.h"

namespace lidard {

/// Packets and messages in; frames, merged and virtual scans out. The same object serves live input and
/// replay; it has no thread and no clock: time is what the arrivals and tick() say.
class Pipeline {
 public:
  /// `transforms` and the sinks must outlive the pipeline.
  Pipeline(const Config& config, TransformSource& transforms, FrameSink& sink);
  Pipeline(const Config& config, TransformSource& transforms, std::vector<FrameSink*> sinks);
  ~Pipeline();

  /// The configured transforms, for /tf_static.
  std::vector<StaticTransform> static_transforms() const;

  /// A datagram, or a chunk of a connection in a capture; finds the sensor it belongs to by port and sender.
  void packet(const Packet& packet);

  /// Where requests to devices go; must outlive the pipeline's use. nullptr, as in replay: they are dropped.
  void set_links(DeviceConnections* links);
  /// What came over the connection of a sensor, `sensor` being its place in the configuration.
  void chunk(std::size_t sensor, const Packet& packet);
  void connected(std::size_t sensor, Stamp now);
  void disconnected(std::size_t sensor);
  /// Frames that a sensor's driver has handed on so far.
  std::uint64_t frames(std::size_t sensor) const;

  /// A packet of a sensor with `packet_topic:`; its `arrival` is that at the node that received it,
  /// `received` when its message came here.
  void packet_message(const std::string& sensor, const Packet& packet, Stamp received);
  /// A message of a `topic:` source, `sensor` being its name in the configuration.
  void scan_message(const std::string& sensor, PlanarScan& scan, Stamp received);
  void cloud_message(const std::string& sensor, Cloud& cloud, Stamp received);
  /// A pose of `child` (empty: base_frame) in the odometry's frame, for deskewing.
  void pose_message(Stamp stamp, const Pose& pose, const std::string& child, Stamp received);
  /// Turn rates in `frame`, rad/s, and the speed ahead, m/s: the vehicle's motion where nobody knows its
  /// poses.
  void turn_message(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame, Stamp received);
  void speed_message(double speed);
  /// Time passed: publishes what is due at or before `now`, each at its own time.
  void advance(Stamp now);
  /// The next time at which advance() has something to do.
  std::optional<Stamp> next_event() const;
  /// Time passed; publishes diagnostics once per second of it, and when a source comes or goes.
  void tick(Stamp now);
  /// End of input: hands on what is complete.
  void finish(Stamp now);
  /// The input starts again (replay --loop).
  void restart();

  /// Gives a merged scan or a group of virtual scans another grid, profile or encoding from its next input
  /// on. Empty, or why it cannot be: then nothing changes.
  std::string set_output(const OutputId& output, const OutputScanConfig& wanted);

  std::vector<SensorReport> report() const;
  /// What came out so far, one for each of output_topics(), with what was missing in it as its remark.
  std::vector<OutputReport> output_report() const;
  /// Why nothing came on one of output_topics() so far, or what was missing in all that came; empty:
  /// nothing is missing.
  std::string why_missing(const std::string& topic) const;
  /// Senders on a configured port that no sensor claims, "192.168.1.9:2368 (412 packets)".
  std::vector<std::string> unclaimed_senders() const;
  std::vector<DiagnosticItem> diagnostics(Stamp now) const;
  /// Adds what others know (sockets) to every diagnostics() list.
  void add_diagnostics(std::function<void(std::vector<DiagnosticItem>&)> source);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidard
