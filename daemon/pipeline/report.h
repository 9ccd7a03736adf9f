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

/// What one sensor did since the start, for the table at the end of a replay and for diagnostics.
struct SensorReport {
  std::string name;
  std::string model;  ///< or "topic"
  Counters counters;
  DeviceInfo info;
  std::optional<FilterCounters> filter;  ///< of its own frames; none: it has no filter
  std::string filter_trouble;            ///< why its filter does not do what it was meant to; empty: no doubt
  std::optional<PoseGate> gate;          ///< of its clouds; none: published as they were measured
  bool seen = false;                     ///< any data received at all
  Stamp last_arrival;                    ///< of data
  Stamp last_telemetry;                  ///< of what the device tells beside its data
  std::string link_trouble;  ///< while silent: what is wrong with its connection or this host's network;
                             ///< empty: nothing
  std::string link_hint;     ///< while silent: what may be wrong there
  std::string other_model;  ///< which model's packets come in place of the configured one's; empty: not known
  bool starting = false;    ///< the first second of all watching: silence says nothing yet
  Reception recent, whole;  ///< of the last 10 s, and since the start
  std::vector<std::string> rivals, rivals_ever;  ///< several senders into one entry, now and at any time
};

/// What came out on one topic, or into one file.
struct OutputReport {
  std::string name;
  std::uint64_t messages = 0;
  Stamp first{}, last{};  ///< when the first and the last one were released
  bool promised = true;   ///< false: it depends on what the device has to tell
  std::string remark;     ///< why there is none, or what was missing

  void count(Stamp released);
  /// Messages per second; 0: fewer than two.
  double rate() const;
};

/// Why a driver that got packets over a time of `span` gave no whole frame: "only about 0.4 of a frame: …".
std::string why_no_frame(const Model& model, const Counters& counters, Span span);
/// The table of outputs: a row for each that was promised or came, and one line for the others.
void print_outputs(const char* head, const std::vector<OutputReport>& outputs, std::ostream& out);
/// False if an output that was promised never came.
bool all_came(const std::vector<OutputReport>& outputs);

/// One line with all counters of a sensor that are not zero (packets always).
void print_counters(const Counters& counters, std::ostream& out);
/// "rejected 3 (size 1, magic 2)", or "0".
std::string rejected_text(const Counters& counters);
/// What a filter removed: "filter removed 12 of 3400 returns (intensity 10, outliers 2)".
std::string filter_text(const FilterCounters& counters);
/// Why a filter does not do what it was meant to, on that topic; empty: no doubt.
std::string filter_trouble(const FilterCounters& counters, const std::string& topic);
/// One line with what a capture held beyond the sensor's datagrams; nothing if there was nothing.
void print_capture_counters(const CaptureCounters& counters, std::uint64_t other_datagrams,
                            std::ostream& out);
/// The table at the end of a replay: a row per sensor.
void print_table(const std::vector<SensorReport>& sensors, std::ostream& out);
/// A line for each sensor that gave less than it should have.
void print_verdicts(const Config& config, const std::vector<SensorReport>& sensors, std::ostream& out);

}  // namespace lidard
