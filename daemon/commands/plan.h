// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "daemon/config/lanes.h"

namespace lidard {

/// The parts of a configuration for both lanes; arrays are indexed by lane, here and below.
struct Plan {
  explicit Plan(Config config)
      : whole(std::move(config)),
        parts{part_of(whole, Lane::planes), part_of(whole, Lane::clouds)},
        topics{output_topics(parts[0]), output_topics(parts[1])} {}
  bool has_clouds() const { return !parts[1].sensors.empty(); }

  const Config whole;
  const std::array<Config, 2> parts;
  const std::array<std::vector<OutputTopic>, 2> topics;
};

}  // namespace lidard
