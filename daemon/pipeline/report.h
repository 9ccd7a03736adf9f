// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "core/base/counters.h"
#include "core/base/time.h"
#include "core/frames/frame_filter.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/pose_gate.h"
#include "daemon/pipeline/reception.h"
#include "drivers/capture/pcap_source.h"
#include "drivers/driver.h"
#include "drivers/model.h"

namespace lidard {

/// The results of a sensor since the start, for the table at the end of a replay and for diagnostics.
struct SensorReport {
  std::string name;
  std::string model;  ///< or "topic"
  Counters counters;
  DeviceInfo info;
  std::optional<FilterCounters> filter;  ///< of its own frames; none: it has no filter
  std::string filter_trouble;            ///< why its filter does not work as configured; empty: it does
  std::optional<PoseGate> gate;          ///< of its clouds; none: they are not transformed
  bool seen = false;                     ///< data was received
  Stamp last_arrival;                    ///< of data
  std::optional<Stamp> last_telemetry;   ///< of telemetry
  std::string link_trouble;   ///< while silent: a fault of its connection or this host's network; empty: none
  std::string link_hint;      ///< while silent: a possible cause there
  std::string other_model;    ///< the model of packets of another model; empty: unknown
  std::string two_devices;    ///< a sentence on two devices with its address; empty: there is one
  std::string clock_trouble;  ///< stamps of its topic are another clock's; empty: they are not
  std::uint64_t stamps_replaced = 0;  ///< of its topic
  bool starting = false;              ///< the first second after the start: silence is no fault yet
  Reception recent, whole;            ///< of the last 10 s, and since the start
};

/// The output on one topic or to one file.
struct OutputReport {
  std::string name;
  std::uint64_t messages = 0;
  Stamp first{}, last{};  ///< when the first and the last one were released
  bool promised = true;   ///< false: it depends on the state of the device
  std::string remark;     ///< why there is no output, or what was missing

  void count(Stamp released);
  /// Messages per second; 0: fewer than two.
  double rate() const;
};

/// Why packets over `span` gave no complete frame: "only about 0.4 of a frame: …".
std::string why_no_frame(const Model& model, const Counters& counters, Span span);
/// Prints the table of outputs: a row for every promised or published one, and one line for the others.
void print_outputs(const char* head, const std::vector<OutputReport>& outputs, std::ostream& out);
/// False if an output that was promised never came.
bool all_came(const std::vector<OutputReport>& outputs);

/// Prints one line with the counters of a sensor that are not zero (packets always).
void print_counters(const Counters& counters, std::ostream& out);
/// "rejected 3 (size 1, magic 2)", or "0".
std::string rejected_text(const Counters& counters);
/// "filter removed 12 of 3400 returns (intensity 10, outliers 2)".
std::string filter_text(const FilterCounters& counters);
/// Why a filter on that topic does not work as configured; empty: it does.
std::string filter_trouble(const FilterCounters& counters, const std::string& topic);
/// Prints one line with the counters of a capture beyond the sensor's datagrams, if any.
void print_capture_counters(const CaptureCounters& counters, std::uint64_t other_datagrams,
                            std::ostream& out);
/// Prints the table at the end of a replay: a row per sensor.
void print_table(const std::vector<SensorReport>& sensors, std::ostream& out);
/// Prints a line for every sensor with a fault.
void print_verdicts(const Config& config, const std::vector<SensorReport>& sensors, std::ostream& out);

}  // namespace lidard
