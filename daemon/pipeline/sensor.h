// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/frames/frame_filter.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/cloud_placer.h"
#include "daemon/pipeline/other_model.h"
#include "daemon/pipeline/output.h"
#include "daemon/pipeline/raw_packets.h"
#include "daemon/pipeline/reception.h"
#include "daemon/pipeline/report.h"
#include "daemon/pipeline/sensor_health.h"
#include "daemon/pipeline/vehicle_motion.h"
#include "drivers/address.h"
#include "drivers/capture/pcap_source.h"

namespace lidard {

/// What DeviceConnections::trouble() says before the first attempt has come to an end.
inline constexpr const char* first_attempt = "connecting";

/// The TCP connections to devices, as a pipeline uses them. A sensor is named by its place in the
/// configuration. In replay there are none.
class DeviceConnections {
 public:
  virtual ~DeviceConnections() = default;
  /// Opens a connection to the device's dialogue port unless there is one.
  virtual void connect(std::size_t sensor, const IpAddress& device) = 0;
  virtual void send(std::size_t sensor, ByteView bytes) = 0;
  /// Ends the connection; `again`: and opens another one.
  virtual void disconnect(std::size_t sensor, bool again) = 0;
  /// Why the sensor has no connection, or cannot be reached, with the remedy; empty: nothing is known to be
  /// wrong.
  virtual std::string trouble(std::size_t sensor) const = 0;
  /// What may be the reason that nothing comes from a sensor though its connection is well; empty: no idea.
  virtual std::string hint(std::size_t /*sensor*/) const { return {}; }
};

/// What the sensors of a pipeline share: where their frames go, their connections, and the time.
struct SensorContext {
  Outlet& outlet;
  VehicleMotion& motion;
  DeviceConnections* connections = nullptr;  ///< nullptr, as in replay: requests are dropped
  Stamp now{};
};

/// One sensor: its driver, its connection, whether its data come, and where its frames go.
class Sensor final : public DriverOutput {
 public:
  /// `place`: in the configuration. `context` must outlive this.
  Sensor(const SensorConfig& config, std::size_t place, SensorContext& context);

  const SensorConfig& config() const { return config_; }
  /// Its place in the configuration is another one now.
  void set_place(std::size_t place) { place_ = place; }
  const Counters& counters() const { return driver_ ? driver_->counters() : topic_counters_; }

  /// Applies what may change while it runs: see Driver::change(), and how its cloud is arranged.
  void change(const SensorConfig& wanted);

  /// A packet of this sensor, or a chunk of its connection.
  void receive(const Packet& packet, Stamp received);
  /// A chunk of one of its connections in a capture; one of them at a time is followed.
  void receive_recorded(Packet chunk);
  void connected(Stamp now);
  void disconnected() { driver_->disconnected(); }
  /// A scan that another driver published. A scan without beams becomes one that observed nothing, so that it
  /// counts as delivered.
  void receive(PlanarScan& scan, Stamp received);
  /// A cloud that another driver published.
  void receive(Cloud& cloud, Stamp received);
  /// Time passed.
  void advance(Stamp now);
  /// When advance() is worth a call if nothing else happens.
  std::optional<Stamp> next_event() const { return placer_ ? placer_->next_event() : std::nullopt; }
  /// The clock jumped.
  void clock_jumped(Stamp now);
  void tick(Stamp now);
  /// True once where it fell silent, became an error by that, or is heard of again.
  bool silence_changed(Stamp now);
  /// End of input: hands on what is complete.
  void finish();
  /// The input starts again.
  void restart();

  SensorReport report() const;
  /// The device's settings against those wanted; none: its driver does not look at them, or cannot.
  std::optional<DiagnosticItem> settings(Stamp now) const;
  /// Why it gave no frames, or why they are not published; empty: nothing is missing.
  std::string why_no_frames(const UnknownSenders& unknown) const;

  void scan(PlanarScan& scan) override;
  void cloud(Cloud& cloud) override;
  bool wants_cloud() override;
  void message(const DeviceMessage& message) override;
  void extra_scan(std::string_view name, PlanarScan& scan) override;
  void note(std::string_view sentence) override;
  void request(ByteView bytes) override;
  void connect() override { request_ = ConnectionRequest::connect; }
  void disconnect(bool again) override {
    request_ = again ? ConnectionRequest::connect_anew : ConnectionRequest::hang_up;
  }

 private:
  enum class ConnectionRequest : std::uint8_t { none, connect, connect_anew, hang_up };

  /// Does with the connection what the driver asked for in the call that just returned.
  void apply_connection_request();
  /// Data came in.
  void notice_data(Stamp received);
  /// Remembers the geometry; says so when the number of beams changed.
  void notice_shape(const PlanarScan& scan);
  /// Makes a scan without beams one that observed nothing.
  void fill_empty(PlanarScan& scan) const;
  /// A scan of its own on a topic of its own, with echoes and flags on topics beside it. The filter comes
  /// after those who see everything.
  void publish_scan(const OutputTopic& topic, std::optional<FrameFilter>& filter, PlanarScan& scan);
  /// Its cloud, on the topic of its own.
  void publish_cloud(Cloud& cloud, Stamp now);
  /// Publishes the packets since the last call, if there are any.
  void publish_raw();
  /// The vehicle's motion is followed up to a frame.
  void follow_motion(Stamp frame);
  /// For the outputs that are made of this sensor's frames.
  template <class Frame>
  void feed(const Frame& frame);
  /// What the device reports beside its frames, on each of its topics.
  void publish_from_device(std::string_view name, const Payload& payload);

  SensorConfig config_;
  std::size_t place_;
  SensorContext& context_;
  std::unique_ptr<Driver> driver_;                   // nullptr: another driver publishes on config_.topic
  std::optional<FrameFilter> filter_, ring_filter_;  // of its frames, and of the ring that is a scan
  std::optional<bool> cloud_wanted_;                 // as the driver was told when its cloud began
  CloudArranger arranger_;
  std::optional<CloudPlacer> placer_;
  std::optional<RingScan> ring_scan_;
  PlanarScan ring_;
  RawPacketCollector raw_{config_};
  const OutputTopic* topic_ = nullptr;                // of its frames; nullptr, as below: none
  const OutputTopic* ring_topic_ = nullptr;           // of the ring that is a scan
  const OutputTopic* raw_topic_ = nullptr;            // of its packets
  std::vector<const OutputTopic*> more_scan_topics_;  // of its scans in other messages
  std::vector<const OutputTopic*> device_topics_;     // of what its driver reports by name
  ConnectionPicker connection_;                       // in a capture
  ConnectionRequest request_ = ConnectionRequest::none;
  IpAddress sender_;   // of the last datagram
  bool seen_ = false;  // data; not what a device tells beside it
  Stamp first_arrival_{};
  Stamp last_arrival_{};
  Stamp last_telemetry_{};
  Health silence_ = Health::ok;
  Counters topic_counters_;  // without a driver
  ReceptionWatch watch_;
  OtherModel other_model_;
  PlanarScan shape_;  // geometry of its last scan that had beams
};

}  // namespace lidard
