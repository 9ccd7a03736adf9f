// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/ros/master/environment.h"
#include "drivers/key.h"

namespace lidard {

/// Values of items by name.
using ItemValues = std::map<std::string, KeyValue>;

/// An output, or the clouds of a sensor, whose items may be changed while it runs.
struct Reconfigurable {
  MakerId id;
  std::string server;                  ///< name below the node; empty: the node itself
  std::vector<std::string> topics;     ///< of its scans
  double free_required = 0;            ///< m; 0: none
  std::string flat_source;             ///< a source without evidence, so that profile is flatten; empty: none
  OutputScanConfig config;             ///< in force
  std::optional<SensorConfig> sensor;  ///< in force, where it is a sensor's; then `config` means nothing
  ReconfigureNames names = ReconfigureNames::entries;
};

/// The outputs of a configuration with their items.
std::vector<Reconfigurable> changeable_outputs(const Config& config, ReconfigureNames names);

/// The settings of an output that may be changed while it runs: its keys, with limits of their own. They are
/// bound to `output`.
Keys items_of(Reconfigurable& output);
/// The values in force.
ItemValues values_of(Reconfigurable output);

/// Changes `output` to `wanted`, in which items may be missing; numbers are brought into their limits first.
/// Returns why it cannot be and the remedy, then nothing changes; empty after success.
std::string change(Reconfigurable& output, const ItemValues& wanted);

/// The number of beams of an output.
std::size_t beams_of(const OutputScanConfig& config);

/// The values of a request.
ItemValues read_values(const dynamic_reconfigure::Config& config);
/// The values in force as a message.
dynamic_reconfigure::Config config_message(Reconfigurable output);
/// The items with their limits as a message; the values in force are their defaults.
dynamic_reconfigure::ConfigDescription description_message(Reconfigurable output);

}  // namespace lidard
