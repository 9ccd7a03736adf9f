// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/pipeline/device_connections.h"
#include "daemon/pipeline/reception.h"
#include "daemon/pipeline/sink.h"
#include "drivers/capture/connection_picker.h"

namespace lidard {

struct Sensor;
struct SensorReport;

/// Where the frames of a sensor go beside its own topics.
class LineOwner {
 public:
  explicit LineOwner(FrameSink& frame_sink) : sink(frame_sink) {}
  virtual ~LineOwner() = default;
  virtual void scan_from(const Sensor& line, const PlanarScan& scan) = 0;
  virtual void cloud_from(const Sensor& line, const Cloud& cloud) = 0;

  FrameSink& sink;
  DeviceConnections* links = nullptr;  ///< nullptr, as in replay: requests are dropped
  Stamp now{};
};

/// One sensor: its driver, and where its frames go.
struct Sensor final : public DriverOutput {
  /// `topics`: all of the configuration.
  Sensor(const SensorConfig& sensor, std::size_t place, const std::vector<OutputTopic>& topics,
         LineOwner& owner);
  bool owns_port(std::uint16_t port) const {
    if (config.model == nullptr || config.model->transport != Transport::udp) return false;
    if (!config.packet_topic.empty()) return false;
    return port == config.ip_port || (config.telemetry_port != 0 && port == config.telemetry_port);
  }
  /// Where the device listens for its TCP connection; port 0: it has none, or its address is not known.
  Endpoint device() const {
    if (config.model == nullptr || !config.ip_address) return {};
    const bool streams = config.model->transport == Transport::tcp;
    return {*config.ip_address, streams ? config.ip_port : config.model->dialogue_port};
  }
  const Counters& counters() const { return driver ? driver->counters() : topic_counters; }
  SensorReport report() const;
  /// What has arrived later than it is now has arrived just now.
  void clock_jumped_to(Stamp now) {
    last_arrival = std::min(last_arrival, now);
    last_telemetry = std::min(last_telemetry, now);
  }
  /// A packet of this sensor, or a chunk of its connection.
  void receive(const Packet& packet, Stamp received);
  void scan(PlanarScan& scan) override;
  void cloud(Cloud& cloud) override;
  void message(const DeviceMessage& message) override;
  void extra_scan(std::string_view name, PlanarScan& scan) override;
  void note(std::string_view sentence) override;
  void request(ByteView bytes) override;
  void connect() override { wish = ConnectionRequest::connect; }
  void disconnect(bool again) override {
    wish = again ? ConnectionRequest::connect_anew : ConnectionRequest::hang_up;
  }
  /// Does with the connection what the driver asked for in the call that just returned.
  void apply_connection_request();
  /// A scan that another driver published. A scan without beams becomes one that observed nothing, so that it
  /// counts as delivered. False if the scan is not sound.
  bool take_message(PlanarScan& scan, Stamp received);
  /// A cloud that another driver published.
  void take_message(Cloud& cloud, Stamp received);
  /// Makes a scan without beams one that observed nothing.
  void fill_empty(PlanarScan& scan) const;
  /// The configured pose counts whatever frame a message of another driver names.
  void place(std::string& frame_id) const {
    if (config.pose) frame_id = config.frame_id;
  }
  /// Data came in.
  void notice_data(Stamp received);
  /// Remembers the geometry; says so when the number of beams changed.
  void notice_shape(const PlanarScan& scan);

  enum class ConnectionRequest : std::uint8_t { none, connect, connect_anew, hang_up };

  SensorConfig config;
  std::size_t index;  // in the configuration
  LineOwner& owner;
  std::unique_ptr<Driver> driver;
  CloudArranger arranger;
  std::optional<RingScan> ring_scan;
  PlanarScan ring;
  const OutputTopic* topic = nullptr;                          // of its frames; nullptr, as below: none
  const OutputTopic* ring_topic = nullptr;                     // of the ring that is a scan
  const OutputTopic* echoes_topic = nullptr;                   // of its scans with all echoes
  std::map<std::string_view, const OutputTopic*> told_topics;  // of messages and further scans
  ConnectionPicker connection;
  IpAddress sender;  // of the last datagram
  ConnectionRequest wish = ConnectionRequest::none;
  bool seen = false;  // data; not what a device tells beside it
  Stamp first_arrival{};
  Stamp last_arrival{};
  Stamp last_telemetry{};
  Counters topic_counters;  // of a `topic:` source
  ReceptionWatch watch;
  PlanarScan shape;  // geometry of its last scan that had beams
};

}  // namespace lidard
