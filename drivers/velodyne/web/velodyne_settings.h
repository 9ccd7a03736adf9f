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

/// Parses a JSON answer of the sensor; empty if it is not a JSON object. Text is made printable and short;
/// values that are nested deeper or longer than any sensor's answer are dropped.
std::optional<VelodyneTree> read_velodyne_json(const std::string& text);

/// The sensor's spelling.
const char* to_string(VelodyneReturns returns);

/// One request that changes a setting.
struct VelodyneChange {
  std::string path;
  std::string body;
  std::string text;  ///< "rpm: 600 -> 1200"
};

struct VelodynePlan {
  std::vector<VelodyneChange> changes;  ///< in the order of the requests
  std::vector<std::string> unknown;     ///< wanted settings that the sensor does not report
};

/// The changes from the reported `tree` to the wanted settings. A setting that is not reported is not
/// written, since it cannot be compared.
VelodynePlan plan(const VelodyneTree& tree, const VelodyneSettings& wanted);

}  // namespace lidard
