// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <vector>

#include "core/base/counters.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/capture/pcap_source.h"

namespace lidard {

/// One line with all counters of a sensor that are not zero (packets always).
void print_counters(const Counters& counters, std::ostream& out);
/// "rejected 3 (size 1, magic 2)", or "0".
std::string rejected_text(const Counters& counters);
/// One line with what a capture held beyond the sensor's datagrams; nothing if there was nothing.
void print_capture_counters(const CaptureCounters& counters, std::uint64_t other_datagrams,
                            std::ostream& out);
/// The table at the end of a replay: a row per sensor.
void print_table(const std::vector<SensorReport>& sensors, std::ostream& out);
/// A line for each sensor that gave less than it should have.
void print_verdicts(const Config& config, const std::vector<SensorReport>& sensors, std::ostream& out);

}  // namespace lidard
