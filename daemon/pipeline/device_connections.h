// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "core/base/bytes.h"
#include "drivers/address.h"

namespace lidard {

/// What DeviceConnections::trouble() says before the first attempt has come to an end.
inline constexpr const char* first_attempt = "connecting";

/// The TCP connections to devices, as a pipeline uses them. A sensor is named by its place in the
/// configuration. In replay there are none.
class DeviceConnections {
 public:
  virtual ~DeviceConnections() = default;
  /// Opens a connection to the device's dialogue port unless there is one.
  virtual void connect(std::size_t sensor, const IpAddress& device) = 0;
  virtual void send(std::size_t sensor, ByteView bytes) = 0;
  /// Ends the connection; `again`: and opens another one.
  virtual void disconnect(std::size_t sensor, bool again) = 0;
  /// Why the sensor has no connection, with the remedy; empty if it has one or needs none.
  virtual std::string trouble(std::size_t sensor) const = 0;
};

}  // namespace lidard
