// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/reading.h"

namespace lidard {

/// What a name in laserscan_topics or cloud_topic stands for: a sensor, or a virtual scan. One of the two is
/// set.
struct NamedSource {
  const SensorConfig* sensor = nullptr;
  const VirtualScanConfig* virtual_group = nullptr;
  std::string name;  ///< of the sensor, or the topic of the virtual scan as it is published
};

/// The sensors that give frames of this kind, for messages.
std::string names_of(const Config& config, FrameKind kind);
/// What `value` names: a sensor by its name, by the topic it listens to or by the topic it publishes frames
/// of this kind on; or a virtual scan by its topic, where scans are wanted. A leading slash is of no
/// importance. Throws if that is nothing, several things, or something that gives frames of another kind;
/// `expected` says what may be named.
NamedSource read_source(const Value& value, FrameKind kind, const Reading& reading,
                        const std::string& expected);
/// The topics of virtual scans that carry scans of one frame each.
std::vector<std::string> virtual_topics(const Config& config);

}  // namespace lidard
