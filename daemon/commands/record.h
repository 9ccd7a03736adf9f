// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>

#include "daemon/config/config.h"

namespace lidard {

/// What `lidard record` was asked for.
struct RecordOptions {
  std::string config;
  std::string output;
  std::string interface = "any";  ///< of the host
  double duration = 0;            ///< s; 0: until a signal
};

/// The filter, as pcap-filter(7) has it, for the traffic of the configured sensors: all that a known address
/// sends and gets, else what goes to the sensor's ports. Empty: no sensor is on the network.
std::string capture_filter(const Config& config);

/// Records the configured sensors' traffic, UDP and both directions of TCP, without taking it from anybody.
/// Messages go to `err`. Returns the exit code.
int run_record(const RecordOptions& options, std::ostream& err);

}  // namespace lidard
