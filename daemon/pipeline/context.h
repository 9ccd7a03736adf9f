// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "core/base/bytes.h"
#include "daemon/pipeline/router.h"
#include "daemon/pipeline/vehicle_motion.h"
#include "drivers/address.h"

namespace lidard {

/// DeviceConnections::trouble() before the end of the first attempt.
inline constexpr const char* first_attempt = "connecting";

/// The TCP connections to devices. Sensors are identified by their index in the configuration. There are no
/// connections in replay.
class DeviceConnections {
 public:
  virtual ~DeviceConnections() = default;
  /// Opens a connection to the device's dialogue port unless there is one.
  virtual void connect(std::size_t sensor, const IpAddress& device) = 0;
  virtual void send(std::size_t sensor, ByteView bytes) = 0;
  /// The time at which it is called.
  virtual Stamp now() const = 0;
  /// Ends the connection; `again`: opens a new one.
  virtual void disconnect(std::size_t sensor, bool again) = 0;
  /// Why the sensor has no connection or cannot be reached, with the remedy; empty: no known fault.
  virtual std::string trouble(std::size_t sensor) const = 0;
  /// A possible reason for the silence of a sensor with a working connection; empty: unknown.
  virtual std::string hint(std::size_t /*sensor*/) const { return {}; }
};

/// What the sensors and makers of a pipeline share; it must outlive them.
struct PipelineContext {
  const VehicleConfig& vehicle;
  const FrameTree& frames;
  VehicleMotion& motion;
  Router& router;
  DeviceConnections* connections = nullptr;  ///< nullptr, as in replay: requests are dropped
  Stamp now{};
  Span messages_ahead{0};  ///< of the arrivals: the clock that stamps messages
};

}  // namespace lidard
