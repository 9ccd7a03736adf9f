// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace lidard {

/// What travels on a topic. A scan with several echoes goes to a topic of its own (MultiEchoLaserScan).
/// `extended_scan` and `output_paths`: a scan and a DeviceState as messages of sick_safetyscanners.
enum class TopicKind : std::uint8_t {
  scan,
  echoes,
  cloud,
  merged_cloud,
  message,
  extended_scan,
  output_paths
};

/// A topic that something in a configuration may publish on.
struct OutputTopic {
  std::string name;  ///< as ROS has it (relative names are resolved by the sink)
  TopicKind kind;
  bool promised = true;     ///< comes with every frame; else only when the device has something to report
  std::size_t message = 0;  ///< of TopicKind::message: message_kind() of what travels
  std::size_t id = 0;       ///< index in output_topics()
  std::string_view from{};  ///< the driver's name of what travels; empty: what every sensor of the kind gives
};

}  // namespace lidard
