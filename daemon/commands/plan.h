// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/lanes.h"
#include "daemon/live/frame_queue.h"

namespace lidard {

/// Scans on their way from the lane of clouds to that of planes: a slot of the queue for each source.
struct HandedOver {
  static constexpr std::size_t depth = 100;
  explicit HandedOver(std::vector<std::string> names) : sources(std::move(names)) {
    for (std::size_t i = 0; i < sources.size(); ++i) queue.add_slot(depth);
  }
  const std::vector<std::string> sources;
  FrameQueue queue{Backpressure::drop_oldest};
};

/// A configuration as both lanes see it; arrays are by lane, here and below.
struct Plan {
  explicit Plan(Config config)
      : whole(std::move(config)),
        parts{part_of(whole, Lane::planes), part_of(whole, Lane::clouds)},
        topics{output_topics(parts[0]), output_topics(parts[1])},
        handed_over(std::make_shared<HandedOver>(parts[1].hand_over)) {}
  bool has_clouds() const { return !parts[1].sensors.empty(); }

  const Config whole;
  const std::array<Config, 2> parts;
  const std::array<std::vector<OutputTopic>, 2> topics;
  const std::shared_ptr<HandedOver> handed_over;
};

}  // namespace lidard
