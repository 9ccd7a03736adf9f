// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/address.h"
#include "drivers/driver.h"
#include "drivers/key.h"

namespace lidard {

class Mapping;

enum class VelodyneReturns : std::uint8_t { strongest, last, dual };
/// Requested settings of the sensor; settings without a value stay unchanged.
struct VelodyneSettings {
  std::optional<int> rpm;
  std::optional<VelodyneReturns> returns;
  std::optional<int> fov_start_deg, fov_end_deg;  ///< 0 to 360, as the sensor counts azimuth
  std::optional<IpAddress> host_address;
  std::optional<std::uint16_t> host_port, host_telemetry_port;

  bool any() const;
};

/// `control:` of a sensor: settings of its web interface. Without wanted ones there is no traffic to the
/// sensor.
struct VelodyneControl : FamilySettings {
  bool allow_write = false;  ///< writes settings that differ from `wanted`
  std::uint16_t port = 80;
  IpAddress address;            ///< the sensor's
  std::uint16_t data_port = 0;  ///< local port of its data
  VelodyneSettings wanted;
};

/// The wanted settings of a sensor; nullptr: none.
inline const VelodyneControl* web_control(const DriverConfig& config) {
  return static_cast<const VelodyneControl*>(config.control.get());
}

/// Keys of `control:` of a sensor: Trait::web_control. drivers/velodyne/web defines them.
Keys control_keys(VelodyneControl& control);
/// What these keys have to fulfil together, and what follows from them; `yaml`: the section; `address`: of
/// the sensor. Throws ConfigError; appends warnings with their locations.
void check_control(const Mapping& yaml, const std::optional<IpAddress>& address, VelodyneControl& control,
                   std::vector<std::string>& warnings);

}  // namespace lidard
