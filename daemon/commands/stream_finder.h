// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/commands/decode.h"
#include "drivers/flow.h"

namespace lidard {

/// The packets of one sensor in a capture.
struct SensorStream {
  Flow data;
  const Model* model = nullptr;
  std::string remark;

  /// Its data, and its model's telemetry and dialogue.
  FlowTable<const Model*> flows() const;
  std::string to_string() const { return std::string(model->name) + " " + data.to_string(); }
};

/// True if the packet passes the sender and port asked for; the port of a connection is the device's own.
bool is_wanted(const Packet& packet, const DecodeOptions& options);

/// The streams of a capture that can be decoded: as `model` if it is not nullptr, else as what their packets
/// look like. Throws CaptureError if the file cannot be opened.
std::vector<SensorStream> find_streams(const DecodeOptions& options, const Model* model);

}  // namespace lidard
