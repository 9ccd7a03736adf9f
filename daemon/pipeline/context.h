// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "core/base/bytes.h"
#include "daemon/pipeline/router.h"
#include "daemon/pipeline/status.h"
#include "daemon/pipeline/vehicle_motion.h"
#include "drivers/address.h"

namespace lidard {

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
  /// What is known of the way to the sensor.
  virtual ConnectionStatus status(std::size_t sensor) const = 0;
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
