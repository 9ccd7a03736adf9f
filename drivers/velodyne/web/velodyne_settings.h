// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/web_control.h"

namespace lidard {

/// What a Velodyne's web interface reports, flat: "config.host.dport" -> "2368".
using VelodyneTree = std::map<std::string, std::string>;

/// Reads one JSON answer of the sensor; empty if it is no JSON object. Text is made printable and short;
/// what is nested deeper or longer than any sensor's answer is left out.
std::optional<VelodyneTree> read_velodyne_json(const std::string& text);

/// As the sensor spells it.
const char* to_string(VelodyneReturns returns);

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

}  // namespace lidard
