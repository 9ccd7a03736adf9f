// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/alternation.h"
#include "core/base/topic_clock.h"
#include "core/frames/frame_filter.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/cloud_placer.h"
#include "daemon/pipeline/context.h"
#include "daemon/pipeline/router.h"
#include "daemon/pipeline/status.h"
#include "drivers/capture/pcap_source.h"
#include "drivers/reception.h"
#include "drivers/registry/other_model.h"

namespace lidard {

/// One sensor: its driver, its connection, the reception of its data and the routes of its frames.
class Sensor final : public FrameReceiver {
 public:
  /// `index`: index in the configuration. `context` must outlive this.
  Sensor(const SensorConfig& config, std::size_t index, const PipelineContext& context);

  const SensorConfig& config() const { return config_; }
  /// Sets another index in the configuration.
  void set_index(std::size_t index) { index_ = index; }
  const Counters& counters() const { return driver_ ? driver_->counters() : topic_counters_; }

  /// Applies settings that may change at run time: those of Driver::change(), and the layout of the cloud.
  void change(const SensorConfig& wanted);

  bool has_driver() const { return driver_ != nullptr; }
  /// True for telemetry from where the data of this sensor come from, which has no ip_address.
  bool sends_telemetry(const Packet& packet) const {
    return !config_.ip_address && packet.to.port == config_.telemetry_port &&
           packet.from.address == data_sender_;
  }
  /// Accepts a packet of this sensor or a chunk of its connection.
  void receive(const Packet& packet, Stamp received);
  /// Accepts a packet that another node received and stamped.
  void receive_message(Packet packet, Stamp received);
  /// Accepts a chunk of one of its connections in a capture; one connection at a time is used.
  void receive_recorded(Packet chunk, Stamp received);
  /// The time by the device's clock, if the newest packets have no arrival times.
  std::optional<Stamp> made_time() const;
  void connected(Stamp now);
  void disconnected() { driver_->disconnected(); }
  /// Accepts a scan of another driver. A scan without beams becomes an unobserved one, so that it counts as
  /// delivered.
  void receive(PlanarScan& scan, Stamp received);
  /// Accepts a cloud of another driver.
  void receive(Cloud& cloud, Stamp received);
  /// Advances the time.
  void advance(Stamp now);
  /// The next time to call advance() without other events.
  std::optional<Stamp> next_event() const { return placer_ ? placer_->next_event() : std::nullopt; }
  /// Call after a jump of the clock.
  void clock_jumped(Stamp now);
  /// `by_arrivals`: the time on the scale of the packets' arrivals.
  void tick(Stamp by_arrivals);
  /// True once when the sensor becomes silent, when that becomes an error, or when data arrives again.
  bool silence_changed(Stamp now);
  /// End of the input: publishes complete frames.
  void finish();
  /// The input starts again.
  void restart();

  SensorStatus status() const;

  void scan(PlanarScan& scan) override;
  void cloud(Cloud& cloud) override;
  bool wants_cloud() override;
  void message(const DeviceMessage& message) override;
  void extra_scan(std::string_view name, PlanarScan& scan) override;
  void note(std::string_view sentence) override;
  void request(ByteView bytes) override;
  Stamp leaves(Stamp arrival) override;
  void connect() override { request_ = ConnectionRequest::connect; }
  void disconnect(bool again) override {
    request_ = again ? ConnectionRequest::connect_anew : ConnectionRequest::hang_up;
  }

  Stamp begun{};  ///< when the configuration asked for it first

 private:
  enum class ConnectionRequest : std::uint8_t { none, connect, connect_anew, hang_up };

  /// Applies the driver's last connection request.
  void apply_connection_request();
  /// What to add to the stamps of a message, which begins at `stamp` and lasts for `lasts`.
  Span correction_of(Stamp stamp, Span lasts, Stamp received);
  /// Records the arrival of data.
  void notice_data(Stamp received);
  /// Stores the geometry; logs a changed number of beams.
  void notice_shape(const PlanarScan& scan);
  /// Makes a scan without beams one that observed nothing.
  void fill_empty(PlanarScan& scan) const;
  /// Publishes a scan on the sensor's topic, with echoes and flags on further topics. The filter is applied
  /// after unfiltered consumers.
  void publish_scan(Route& topic, std::optional<FrameFilter>& filter, PlanarScan& scan);
  /// The scan to publish of `scan`: with `counter_clockwise` that has its beams in this order.
  PlanarScan& in_order(PlanarScan& scan);
  /// Delivers a frame that was measured at `stamp` to what is made of it.
  void deliver(const Frame& frame, Stamp stamp);
  /// Publishes a message of the device on its topics.
  void publish_from_device(std::string_view name, const Frame& frame);

  SensorConfig config_;
  std::size_t index_;
  const PipelineContext& context_;
  Route& route_;                                     // of its frames as they are measured, without a topic
  std::unique_ptr<Driver> driver_;                   // nullptr: another driver publishes on config_.topic
  std::optional<FrameFilter> filter_, ring_filter_;  // of its frames, and of the ring that is a scan
  std::optional<bool> cloud_wanted_;                 // the last answer of wants_cloud()
  CloudArranger arranger_;
  std::optional<CloudPlacer> placer_;
  std::optional<RingScan> ring_scan_;
  PlanarScan ring_, reversed_;
  Route* topic_ = nullptr;                                          // of its frames; nullptr, as below: none
  Route* ring_topic_ = nullptr;                                     // of the ring that is a scan
  std::vector<Route*> more_scan_topics_;                            // of its scans in other messages
  std::vector<std::pair<std::string_view, Route*>> device_topics_;  // of messages of the driver, by name
  ConnectionPicker connection_;                                     // in a capture
  ConnectionRequest request_ = ConnectionRequest::none;
  IpAddress sender_;       // of the last datagram
  IpAddress data_sender_;  // of the last one with data
  bool seen_ = false;      // data was received (not telemetry)
  Stamp last_arrival_{};
  std::optional<Stamp> last_telemetry_;
  SilenceLevel silence_ = SilenceLevel::none;
  Counters topic_counters_;  // without a driver
  TopicClock topic_clock_;   // of messages
  ReceptionWatch watch_;
  OtherModel other_model_;
  Alternation devices_;
  PlanarScan shape_;                                                 // geometry of the last scan with beams
  Stamp shape_noted_{std::numeric_limits<std::int64_t>::min() / 2};  // when a change of it was logged
};

}  // namespace lidard
