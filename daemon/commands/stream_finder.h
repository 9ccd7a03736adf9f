// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/commands/decode.h"
#include "drivers/model.h"

namespace lidard {

/// The packets of one sensor in a capture: one sender's datagrams to one port, or what it sent over
/// connections to one port of its own.
struct SensorStream {
  Transport transport = Transport::udp;
  IpAddress sender;
  std::uint16_t port = 0;
  const Model* model = nullptr;
  std::string remark;

  /// True for the stream's own data and its model's telemetry and dialogue.
  bool owns(const Packet& packet) const;
  std::string to_string() const;
};

/// True if the packet passes the sender and port asked for; the port of a connection is the device's own.
bool is_wanted(const Packet& packet, const DecodeOptions& options);

/// The streams of a capture that can be decoded: as `model` if it is not nullptr, else as what their packets
/// look like. Throws CaptureError if the file cannot be opened.
std::vector<SensorStream> find_streams(const DecodeOptions& options, const Model* model);

}  // namespace lidard
