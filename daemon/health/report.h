// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "core/base/counters.h"
#include "core/frames/frame_filter.h"
#include "daemon/pipeline/status.h"
#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"

namespace lidard {

/// Why packets over `span` gave no complete frame: "only about 0.4 of a frame: …".
std::string why_no_frame(const Model& model, const Counters& counters, Span span);
/// Prints the table of outputs: a row for every promised or published one, and one line for the others.
void print_outputs(const char* head, const std::vector<TopicTotals>& outputs, std::ostream& out);
/// False if an output that was promised never came.
bool all_came(const std::vector<TopicTotals>& outputs);

/// Prints one line with the counters of a sensor that are not zero (packets always).
void print_counters(const Counters& counters, std::ostream& out);
/// "filter removed 12 of 3400 returns (intensity 10, outliers 2)".
std::string filter_text(const FilterCounters& counters);
/// Why one of the filters does not work as configured; empty: they do.
std::string filter_trouble(const std::vector<FilterStatus>& filters);
/// Prints one line with the counters of a capture beyond the sensor's datagrams, if any.
void print_capture_counters(const CaptureCounters& counters, std::uint64_t other_datagrams,
                            std::ostream& out);
/// Prints the table at the end of a replay: a row per sensor.
void print_table(const std::vector<SensorStatus>& sensors, std::ostream& out);
/// Prints a line for every sensor with a fault.
void print_verdicts(const std::vector<SensorStatus>& sensors, std::ostream& out);

}  // namespace lidard
