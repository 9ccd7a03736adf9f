// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/maker.h"

#include <limits>
#include <stdexcept>

namespace lidard {

Route* Maker::topic(const std::string& name) {
  if (name.empty()) return nullptr;
  Route* const route = &context_.router.topic(name);
  topics_.push_back(route);
  return route;
}

MakerStatus Maker::status(Stamp) const {
  MakerStatus status;
  status.id = id;
  status.sources = sources;
  for (const Route* topic : topics_) status.topics.push_back(topic->name());
  status.counters = counters_;
  status.is_wanted = is_wanted();
  return status;
}

ScanGrid grid_of(const ScanGridSpec& spec) {
  const auto grid = make_grid(spec);
  if (!grid) throw std::logic_error("configuration accepted a grid that is wrong: " + grid.reason());
  return *grid;
}

HeightBand band_of(const OutputScanConfig& config) {
  HeightBand band;
  if (config.min_height) band.min = *config.min_height;
  if (config.max_height) band.max = *config.max_height;
  return band;
}

float value_of(EmptyBeam beam, const OutputScanConfig& config) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  switch (beam) {
    case EmptyBeam::inf:
      return infinite;
    case EmptyBeam::nan:
      return std::numeric_limits<float>::quiet_NaN();
    case EmptyBeam::range_max_plus_one:
      return static_cast<float>(config.grid.range_max) + 1;
    case EmptyBeam::minus_inf:
      return -infinite;
    case EmptyBeam::zero:
      return 0;
  }
  return infinite;
}

}  // namespace lidard
