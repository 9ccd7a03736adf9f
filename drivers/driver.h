// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/angle.h"
#include "core/base/bytes.h"
#include "core/base/counters.h"
#include "core/base/device_clock.h"
#include "core/base/time.h"
#include "core/frames/cloud.h"
#include "core/frames/cloud_layout.h"
#include "core/frames/device_message.h"
#include "core/frames/scan.h"
#include "drivers/address.h"

namespace lidard {

/// Transport protocol.
enum class Transport : std::uint8_t { udp, tcp };

/// A datagram, or a chunk of one direction of a TCP stream, as received. The payload is valid only during the
/// call.
struct Packet {
  ByteView payload;
  Stamp arrival;  ///< stamp of the capture; live: `received`, converted by the receiver
  Endpoint from;
  Endpoint to;
  Transport transport = Transport::udp;
  bool stream_start = false;  ///< first chunk of a connection, or of its part in a capture
  std::uint64_t missing = 0;  ///< bytes of the stream lost right before this chunk (captures with holes)
  HostStamp received{};       ///< live: the kernel's receive stamp
  /// Of an unknown sender, live: this packet and those before it that the kernel's filter dropped.
  std::uint64_t stands_for = 1;
};

/// A driver's verdict on a packet or on a chunk of a stream. The driver has counted it.
struct Verdict {
  bool has_data = false;         ///< measurement data, good or bad (not telemetry or answers of a dialogue)
  Reject reject = Reject::none;  ///< why data of this packet, or of the held back one, was rejected
  /// What distinguishes its device from another one with the same address ("scanner 17"), until the next
  /// packet; empty: nothing does.
  std::string_view device{};
};

/// Name of the extra scan whose intensities hold the device's flags of each beam.
constexpr std::string_view beam_status_scan = "beam_status";
/// Name of the state of a safety scanner's output paths.
constexpr std::string_view output_paths_topic = "output_paths";

/// Receives the output of a driver. The references are valid during the call; a cloud's or scan's buffers may
/// be swapped out by the receiver, which must leave a valid (possibly empty) vector behind.
class FrameReceiver {
 public:
  virtual ~FrameReceiver() = default;
  virtual void scan(PlanarScan& scan) = 0;
  virtual void cloud(Cloud& cloud) = 0;
  /// Called when a cloud begins. False: the cloud has no consumer, and a few of its columns are enough for
  /// diagnostics.
  virtual bool wants_cloud() { return true; }
  /// A message of the device beside its frames; its topic is one of Model::messages, or RawPackets::topic.
  virtual void message(const DeviceMessage& /*message*/) {}
  /// A further scan of the device (such as intrusion data); `topic` is one of Model::extra_scans.
  virtual void extra_scan(std::string_view /*topic*/, PlanarScan& /*scan*/) {}
  /// Bytes to send to the device over its TCP connection; dropped in replay.
  virtual void request(ByteView /*bytes*/) {}
  /// When a request leaves that is made now: on a busy host later than the arrival of the packet that caused
  /// it. `arrival`: of that packet, which is all that a replay knows.
  virtual Stamp leaves(Stamp arrival) { return arrival; }
  /// A sentence for the log: a setting of the device was written ("host address 192.168.0.2 -> 192.168.0.5").
  virtual void note(std::string_view /*sentence*/) {}
  /// Opens the TCP connection (again), from tick() or receive(). Devices that stream over TCP are connected
  /// without a request; devices that stream over UDP (Model::dialogue_port) only on request.
  virtual void connect() {}
  /// Closes the connection and, with `again`, opens a new one after a pause.
  virtual void disconnect(bool /*again*/) {}
};

/// Properties of the device, completed while packets arrive. Keys follow REP 138 where possible.
struct DeviceInfo {
  std::string serial;                                        ///< empty: unknown
  std::vector<std::pair<std::string, std::string>> details;  ///< for diagnostics, in display order
  std::vector<std::string> warnings;                         ///< full sentences, each with its remedy
  std::string from_configuration;  ///< the one of them that `lidard check` has too; empty: none
  bool has_fault = false;          ///< one of the warnings says that the device itself is in error

  /// Sets a detail; a new one is appended.
  void set(std::string_view key, std::string_view value) {
    for (auto& detail : details) {
      if (detail.first != key) continue;
      if (detail.second != value) detail.second = value;
      return;
    }
    details.emplace_back(key, value);
  }
  /// Removes the warning `before` and appends `after`; empty: none.
  void replace_warning(std::string_view before, std::string_view after) {
    if (before == after) return;
    warnings.erase(std::remove(warnings.begin(), warnings.end(), before), warnings.end());
    if (!after.empty()) warnings.emplace_back(after);
  }
};

struct DriverConfig;

/// The protocol of one device: bytes and an arrival stamp in; frames, requests and status out. A driver owns
/// no socket, thread or clock, so that live input, replay, fuzzers and tests make the same calls.
class Driver {
 public:
  virtual ~Driver() = default;
  /// Accepts one datagram, or one chunk that the device sent over TCP (`packet.transport`).
  virtual Verdict receive(const Packet& packet, FrameReceiver& out) = 0;
  /// A TCP connection to the device was made; the dialogue starts here. Never called in replay.
  virtual void connected(Stamp /*now*/, FrameReceiver& /*out*/) {}
  /// The connection ended: drops an incomplete telegram. For a device that streams over UDP also: the
  /// requested connection failed; the next one is opened only on request.
  virtual void disconnected() {}
  /// Advances the time (arrival time scale), for time-outs and keep-alives.
  virtual void tick(Stamp /*now*/, FrameReceiver& /*out*/) {}
  /// End of the input (of a capture): publishes a frame that is complete enough.
  virtual void finish(FrameReceiver& /*out*/) {}
  /// Resets the stream (a capture starts again); keeps the counters and info().
  virtual void restart() = 0;
  /// Applies those of the settings that may change at run time, from the next frame on; others stay as they
  /// are.
  virtual void change(const DriverConfig& /*wanted*/) {}

  virtual const Counters& counters() const = 0;
  virtual const DeviceInfo& info() const = 0;
  /// The clock behind the stamps of frames; nullptr: there is none.
  virtual const DeviceClock* clock() const { return nullptr; }
  /// False if the device sends no time, so that the clock counts nominal intervals.
  virtual bool sends_time() const { return true; }
};

/// Properties of the driver's device, with a warning if its packets have no arrival times; `input`: their
/// origin, for the sentence.
inline DeviceInfo info_of(const Driver& driver, const std::string& input = "the capture") {
  DeviceInfo info = driver.info();
  const DeviceClock* const clock = driver.clock();
  if (clock == nullptr || !clock->lacks_arrivals()) return info;
  const char* const known = driver.sends_time()
                                ? "stamps follow the sensors' clocks"
                                : "the device sends no time either: stamps follow its nominal period";
  info.warnings.push_back((clock->lacks_now() ? "" : "a part of ") + input + " has no arrival times; " +
                          known + " and are not comparable between sensors");
  return info;
}

struct Model;

/// Settings that only the driver of one family knows.
struct FamilySettings {
  virtual ~FamilySettings() = default;
};

/// Requests to the device. By default only those that start the stream.
struct DeviceRequests {
  bool allow_write = false;   ///< writes settings that differ from the configuration
  bool listen_only = false;   ///< no connection at all (devices that stream over UDP)
  std::string user_level;     ///< SOPAS: number of the level to log in at; empty: the model's default
  std::string password_hash;  ///< SOPAS: 8 hexadecimal digits; empty: the model's default
  std::optional<IpAddress> host_address;  ///< receiver of the device's datagrams
  std::uint16_t host_port = 0;            ///< 0: the sensor's port
  std::optional<int> skip;                ///< scans skipped between two (REP 138)
  std::optional<int> cluster;             ///< beams merged into one (REP 138)
  bool calibrate_time = true;  ///< compare both clocks once before the stream starts (REP 138; SCIP: TM)
  bool device_states = false;  ///< SOPAS: subscribe to field evaluation, inputs and outputs
};

/// Configuration of a driver; every default fits the model.
struct DriverConfig {
  const Model* model = nullptr;
  std::string frame_id;
  ClockMode clock = ClockMode::smooth;
  Span time_offset{0};  ///< added to every stamp
  /// Warns if the sensor's clock does not follow a receiver (PPS and NMEA).
  bool expect_pps = false;
  double cut_angle = 0;  ///< rad, as the sensor counts azimuth: where a revolution ends (multi-plane lidars)
  bool keep_too_near = false;  ///< fill Cloud::too_near
  double min_range = 0;        ///< m: nearer returns are dropped (multi-plane lidars)
  double max_range = 0;        ///< m: farther returns are dropped; 0: no limit
  double view_direction = 0;   ///< rad, counter-clockwise from the front: middle of the sector that is kept
  double view_width = two_pi;  ///< rad: width of that sector
  bool keep_partial = false;   ///< hand on first, last and torn frames too
  bool keep_origins = false;   ///< fill Cloud::origins
  /// Hand on the packets of each revolution too, with the stamp of this one (Velodynes); unset: not.
  std::optional<FrameStamp> raw_packets;
  /// rad: keep only the beams from angle_min counter-clockwise to angle_max (planar scanners, REP 138).
  std::optional<double> angle_min, angle_max;
  bool publish_intensity = true;
  bool publish_multiecho = false;  ///< all echoes of a planar scanner (REP 138)
  DeviceRequests requests;
  std::shared_ptr<const FamilySettings> calibration;  ///< Trait::calibration; nullptr: the model's table
  std::shared_ptr<const FamilySettings> control;      ///< Trait::web_control; nullptr: not used

  /// True if a direction (rad, counter-clockwise from the front) lies in the view.
  bool in_view(double direction) const {
    return Sector{view_direction - view_width / 2, view_direction + view_width / 2}.holds(direction);
  }
  Sector sector() const { return sector_between(angle_min, angle_max); }
};

}  // namespace lidard
