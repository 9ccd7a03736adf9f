// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "drivers/capture/pcap_source.h"
#include "drivers/flow.h"

namespace lidard {

/// A flow and its packets.
struct SeenFlow : Flow {
  std::set<IpAddress> destinations;
  std::uint16_t source_port = 0;  ///< of the first datagram
  Endpoint peer;                  ///< of the first connection
  std::uint64_t packets = 0;      ///< or chunks of connections
  std::uint64_t bytes = 0;        ///< of payload
  std::size_t smallest = 0, largest = 0;
  Stamp first, last;
  std::string remark;  ///< of the identifier, for flows that belong to no model

  double duration() const { return seconds(last - first); }
  /// Packets per second; 0: unknown.
  double rate() const { return duration() > 0 ? static_cast<double>(packets - 1) / duration() : 0; }
};

/// A recognized sensor and the results of its driver.
struct FoundSensor {
  std::string name;  ///< for the configuration
  const Model* model = nullptr;
  std::vector<const Model*> others;  ///< other models that fit the packets
  SeenFlow data;
  std::optional<SeenFlow> telemetry;
  Counters counters;
  DeviceInfo info;
  std::uint64_t frames = 0;       ///< published
  Stamp first_frame, last_frame;  ///< their stamps

  /// Frames per second; 0: unknown.
  double frame_rate() const {
    const double passed = seconds(last_frame - first_frame);
    return passed > 0 ? static_cast<double>(frames - 1) / passed : 0;
  }
  /// Packets per second, or for a connection frames per second.
  double rate() const { return data.transport == Transport::tcp ? frame_rate() : data.rate(); }
};

/// One capture file.
struct SurveyedCapture {
  std::string file;
  CaptureCounters counters;
  std::optional<Stamp> first, last;  ///< of its datagrams
  std::string error;                 ///< why it could not be read to its end; empty: it was
  bool damaged = false;              ///< by more than an incomplete last record
};

/// The content of a set of captures.
struct Survey {
  std::vector<SurveyedCapture> captures;
  std::vector<FoundSensor> sensors;  ///< by address and port
  std::vector<SeenFlow> unknown;     ///< flows that belong to no model, by number of packets
  std::uint64_t uncounted = 0;       ///< datagrams beyond the largest number of flows
};

/// What a survey looks for.
struct SurveyOptions {
  const Model* model = nullptr;                       ///< nullptr: any, from the packets
  std::function<bool(const Packet&)> is_wanted = {};  ///< empty: all packets
  bool first_frames = false;                          ///< the drivers run until each has given a frame
  Span part = Span::max();  ///< what came later than that after the begin of its capture is not read
};

/// Reads the captures twice: to recognize the sensors, and to run their drivers.
Survey survey(const std::vector<std::string>& captures, const SurveyOptions& options = {});
/// The same; throws std::runtime_error if there is no sensor, and prints why a capture was not read to its
/// end.
Survey survey_of_sensors(const std::vector<std::string>& captures, std::ostream& err,
                         const SurveyOptions& options = {});

/// A name for one more sensor of a model beside others.
std::string name_for(const Model& model, const std::vector<FoundSensor>& others);
/// The owners of packets, as indices of the sensors.
FlowTable<std::size_t> owners_of(const std::vector<FoundSensor>& sensors);

/// The configuration that replays the sensors, as YAML.
std::string config_of(const Survey& survey);

}  // namespace lidard
