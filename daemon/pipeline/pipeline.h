// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/start_watch.h"
#include "daemon/pipeline/maker.h"
#include "daemon/pipeline/messages.h"
#include "daemon/pipeline/sensor.h"

namespace lidard {

/// Packets and messages in; frames, merged and virtual scans out. The same object serves live input and
/// replay; it has no thread and no clock: time is what the arrivals and tick() say.
///
/// The stages in order: whose packet it is (flows), the sensors with their drivers, what is made of their
/// frames (makers), and the way on (router), which ends in the sink.
class Pipeline final : public MessageReceiver {
 public:
  /// `transforms` and `sink` must outlive the pipeline.
  Pipeline(const Config& config, TransformSource& transforms, FrameSink& sink);

  /// Applies another configuration. Sensors and makers that are as their entries say go on as if nothing had
  /// happened.
  void configure(const Config& config);
  /// What gets the scans of Config::Elsewhere::merged.
  void set_forward(Forward forward) { router_.set_forward(std::move(forward)); }
  /// The configured transforms, for /tf_static.
  const std::vector<StaticTransform>& static_transforms() const { return frames_.fixed(); }

  /// A datagram, or a chunk of a connection in a capture; finds the sensor it belongs to by port and sender.
  void packet(const Packet& packet);
  /// The time at which a packet counts as received: its arrival, or the time by the sensors' clocks where
  /// the capture has no arrival times.
  Stamp time_of(const Packet& packet) const;

  /// Where requests to devices go; must outlive the pipeline's use. nullptr, as in replay: they are dropped.
  void set_connections(DeviceConnections* connections) { context_.connections = connections; }
  /// What came over the connection of a sensor, `sensor` being its index in the configuration.
  void chunk(std::size_t sensor, const Packet& packet);
  void connected(std::size_t sensor, Stamp now);
  void disconnected(std::size_t sensor) { sensors_.at(sensor)->disconnected(); }
  /// Frames that a sensor's driver has handed on so far.
  std::uint64_t frames(std::size_t sensor) const { return sensors_.at(sensor)->counters().frames; }

  /// A scan of a source of merged scans that another part of the configuration has.
  void forwarded_scan(const std::string& source, const PlanarScan& scan, Stamp received);

  void set_message_clock(Span ahead) override { context_.messages_ahead = ahead; }
  void packet_message(const std::string& sensor, const Packet& packet, Stamp received) override;
  void scan_message(const std::string& sensor, PlanarScan& scan, Stamp received) override;
  void cloud_message(const std::string& sensor, Cloud& cloud, Stamp received) override;
  void pose_message(Stamp stamp, const Pose& pose, const std::string& child, Stamp received) override;
  void turn_message(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame,
                    Stamp received) override;
  void speed_message(double speed, Stamp received) override {
    if (vehicle_.has_motion()) motion_.add_speed(speed, received);
  }
  std::string set_scan(const MakerId& maker, const OutputScanConfig& wanted) override;
  std::string set_sensor(const SensorConfig& wanted) override;

  /// Time passed: publishes what is due at or before `now`, each at its own time.
  void advance(Stamp now);
  /// The next time at which advance() has something to do.
  std::optional<Stamp> next_event();
  /// Time passed; calls the reporter when its time has come.
  void tick(Stamp now);
  /// End of input: hands on what is complete.
  void finish(Stamp now);
  /// The input starts again (replay --loop).
  void restart();

  /// States and counters; what the parts refer to is valid until the next configure().
  PipelineStatus status(Stamp now) const;
  /// What came out so far, one for each of output_topics().
  std::vector<TopicTotals> topic_totals() const { return router_.reports(); }
  /// Senders on a configured port that no sensor claims, "192.168.1.9:2368 (412 packets)".
  std::vector<std::string> unclaimed_senders() const { return unknown_senders_.names(); }
  /// The newest time that the pipeline knows.
  Stamp now() const { return context_.now; }
  /// Called once per second of the time, and when a source comes or goes.
  void set_reporter(std::function<void(Stamp now)> reporter) { reporter_ = std::move(reporter); }

 private:
  template <class What>
  using List = std::vector<std::unique_ptr<What>>;

  Sensor* owner_of(const Packet& packet);
  Sensor* find_sensor(const std::string& name, bool with_driver) const;
  void add_sensor(const SensorConfig& entry, std::size_t index, List<Sensor>& before);
  template <class Entry>
  void add_maker(const Entry& entry, List<Maker>& before);
  void advance_to(Stamp at);
  void call_reporter(Stamp now);

  VehicleConfig vehicle_;
  FrameTree frames_;
  VehicleMotion motion_;
  FlowTable<Sensor*> flows_;
  std::set<std::uint16_t> tcp_ports_;  // of devices that stream over TCP
  UnknownSenders unknown_senders_;
  List<Sensor> sensors_;  // by their index in the configuration
  List<Maker> makers_;
  Router router_;
  PipelineContext context_{vehicle_, frames_, motion_, router_};
  /// The time by the sensors' clocks, when packets had this arrival.
  struct MadeTime {
    Stamp arrival, now;
  };
  std::optional<MadeTime> made_time_;
  Span made_ahead_{0};  // by which the time was ahead of the newest packet's arrival
  StartWatch start_;
  std::optional<Stamp> next_event_;
  std::optional<std::uint64_t>
      next_event_after_;  // frames delivered when it was found; none: it is not known
  std::function<void(Stamp)> reporter_ = [](Stamp) {};
  Stamp last_report_{};
  bool report_wanted_ = false;  // a source has come or gone
};

}  // namespace lidard
