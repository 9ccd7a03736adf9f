// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "drivers/capture/pcap_source.h"
#include "drivers/flow.h"

namespace lidard {

/// A flow, and what came of it.
struct SeenFlow : Flow {
  std::set<IpAddress> destinations;
  std::uint16_t source_port = 0;  ///< of the first datagram
  Endpoint peer;                  ///< of the first connection
  std::uint64_t packets = 0;      ///< or chunks of connections
  std::uint64_t bytes = 0;        ///< of payload
  std::size_t smallest = 0, largest = 0;
  Stamp first, last;
  std::string remark;  ///< of the identifier; may be set where no model claims the flow

  double duration() const { return seconds(last - first); }
  /// Packets per second; 0 where there is no duration.
  double rate() const { return duration() > 0 ? static_cast<double>(packets - 1) / duration() : 0; }
};

/// A sensor that was recognised, and what its driver made of its packets.
struct FoundSensor {
  std::string name;  ///< for the configuration
  const Model* model = nullptr;
  std::vector<const Model*> others;  ///< models that the packets may be of as well
  SeenFlow data;
  std::optional<SeenFlow> telemetry;
  Counters counters;
  DeviceInfo info;
  std::uint64_t frames = 0;       ///< handed on
  Stamp first_frame, last_frame;  ///< their stamps

  /// Frames per second; 0 where there is no duration.
  double frame_rate() const {
    const double passed = seconds(last_frame - first_frame);
    return passed > 0 ? static_cast<double>(frames - 1) / passed : 0;
  }
  /// What comes per second: packets or, since a connection's chunks say nothing of the sensor, frames.
  double rate() const { return data.transport == Transport::tcp ? frame_rate() : data.rate(); }
};

/// One capture file.
struct SurveyedCapture {
  std::string file;
  CaptureCounters counters;
  std::optional<Stamp> first, last;  ///< of its datagrams
  std::string error;                 ///< why it could not be read, or not to its end
  bool damaged = false;              ///< by more than a last record that is not whole
};

/// What is in a set of captures.
struct Survey {
  std::vector<SurveyedCapture> captures;
  std::vector<FoundSensor> sensors;  ///< by address and port
  std::vector<SeenFlow> unknown;     ///< flows that no model claims, the one with most packets first
  std::uint64_t uncounted = 0;       ///< datagrams beyond the number of flows that are told apart
};

/// Reads the captures twice: to recognise the sensors, and to let their drivers judge the packets.
Survey survey(const std::vector<std::string>& captures);
/// The same; throws std::runtime_error where there is no sensor, and prints why a capture was not read to its
/// end.
Survey survey_of_sensors(const std::vector<std::string>& captures, std::ostream& err);

/// The configuration that replays what was found, as YAML.
std::string config_of(const Survey& survey);

}  // namespace lidard
