// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>

#include "core/motion/frame_tree.h"
#include "daemon/health/pipeline_health.h"
#include "test/sim/world/units.h"
#include "test/support/recording_sink.h"

namespace lidard::test {

constexpr Stamp bench_begin{1'700'000'000'000'000'000};

/// A tf that knows the poses it is given, of any child in any parent, and says how often it was asked.
class KnownTransforms final : public TransformSource {
 public:
  void set(const std::string& parent, const std::string& child, const Pose& pose) {
    poses_[{parent, child}] = pose;
  }
  bool lookup(const std::string& parent, const std::string& child, Stamp, Pose& pose,
              std::string& why_not) override {
    ++asked;
    const auto found = poses_.find({parent, child});
    if (found == poses_.end()) {
      why_not = "no tf from " + child + " to " + parent;
      return false;
    }
    pose = found->second;
    return true;
  }
  int asked = 0;

 private:
  std::map<std::pair<std::string, std::string>, Pose> poses_;
};

/// A scan of `beams` beams from -pi to almost pi, all of them hits at `range` m, that takes `lasts` from its
/// first beam at `stamp` to its last one.
inline PlanarScan round_scan(const std::string& frame, Stamp stamp, float range = 5, std::size_t beams = 361,
                             Span lasts = Span(0)) {
  PlanarScan scan;
  scan.frame_id = frame;
  scan.stamp = stamp;
  scan.reset(beams, 1, false);
  scan.set_angles(-3.1415927F, 6.2831853F / static_cast<float>(beams));
  scan.range_max = 30;
  scan.time_increment = static_cast<float>(seconds(lasts) / static_cast<double>(beams - 1));
  for (std::size_t i = 0; i < beams; ++i) scan.set_hit(i, range);
  return scan;
}

/// A pipeline of the configuration `text` with what it says.
struct PipelineBench {
  explicit PipelineBench(const std::string& text) : config(parse_config(text, "bench")) {}

  /// A message of a `topic:` source that comes in at `arrival`.
  void give(const std::string& sensor, PlanarScan scan, Stamp arrival) {
    pipeline.scan_message(sensor, scan, arrival);
  }
  void give(const std::string& sensor, Cloud cloud, Stamp arrival) {
    pipeline.cloud_message(sensor, cloud, arrival);
  }
  DiagnosticItem item(const std::string& name, Stamp now) const {
    for (const DiagnosticItem& one : items_of(pipeline, now))
      if (one.name == name) return one;
    throw std::out_of_range(name);
  }
  std::string value(const std::string& name, const std::string& key, Stamp now) const {
    return value_of(item(name, now), key);
  }

  KnownTransforms tf;
  RecordingSink sink;
  Config config;
  Pipeline pipeline{config, tf, sink};
  std::function<void(std::vector<DiagnosticItem>&)> add_items = [](std::vector<DiagnosticItem>&) {};
  HealthReporter reporter{pipeline, sink, [this](std::vector<DiagnosticItem>& items) { add_items(items); }};
};

}  // namespace lidard::test
