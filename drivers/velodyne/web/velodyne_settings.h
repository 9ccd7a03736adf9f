// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/address.h"
#include "drivers/key.h"

namespace lidard {

/// What a Velodyne's web interface reports, flat: "config.host.dport" -> "2368".
using VelodyneTree = std::map<std::string, std::string>;

/// Reads one JSON answer of the sensor; empty if it is no JSON object. Text is made printable and short;
/// what is nested deeper or longer than any sensor's answer is left out.
std::optional<VelodyneTree> read_velodyne_json(const std::string& text);

enum class VelodyneReturns : std::uint8_t { strongest, last, dual };
/// As the sensor spells it.
const char* to_string(VelodyneReturns returns);

/// Settings that the sensor is to have; those not set stay as they are.
struct VelodyneSettings {
  std::optional<int> rpm;
  std::optional<VelodyneReturns> returns;
  std::optional<int> fov_start_deg, fov_end_deg;  ///< 0 to 360, as the sensor counts azimuth
  std::optional<IpAddress> host_address;
  std::optional<std::uint16_t> host_port, host_telemetry_port;

  bool any() const;
};

/// `control:` of a sensor: what may be done through its web interface.
struct VelodyneControl {
  bool read = false;         ///< false: no traffic to the sensor at all
  bool allow_write = false;  ///< settings that differ from `wanted` are written
  std::uint16_t port = 80;
  IpAddress address;            ///< the sensor's
  std::uint16_t data_port = 0;  ///< where its data are expected
  VelodyneSettings wanted;
};

/// One request that changes a setting.
struct VelodyneChange {
  std::string path;
  std::string body;
  std::string text;  ///< "rpm: 600 -> 1200"
};

struct VelodynePlan {
  std::vector<VelodyneChange> changes;  ///< in the order to make them
  std::vector<std::string> unknown;     ///< wanted settings that the sensor does not report
};

/// What to write so that a sensor that reports `tree` has the wanted settings: only what differs. A setting
/// that is not reported is not written, since nobody could tell whether it must be.
VelodynePlan plan(const VelodyneTree& tree, const VelodyneSettings& wanted);

/// `control:` of a sensor: Trait::web_control.
Keys<VelodyneControl> control_keys();

}  // namespace lidard
