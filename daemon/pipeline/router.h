// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/frame_motion.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/sink.h"
#include "daemon/pipeline/status.h"

namespace lidard {

class Maker;

/// Passes a scan to the part of the configuration that merges it.
using Forward = std::function<void(const std::string& source, const PlanarScan& scan, Stamp now)>;

/// The way on for frames: to the sink, and to the merged and virtual scans that are made of them. Sources
/// are numbered: sensors by their index in the configuration, then topics by OutputTopic::id.
class Router {
 public:
  /// The sink must outlive this.
  explicit Router(FrameSink& sink) : sink_(sink) {}
  /// Replaces topics and sources, and connects nothing. A topic that was there before keeps its address and
  /// what it counted.
  void configure(const Config& config);
  void set_forward(Forward forward) { forward_ = std::move(forward); }

  /// The topic of that name, which must be there.
  const OutputTopic& topic(const std::string& name) const;
  /// The number of the source of that name: a sensor, a virtual scan by its topic, or a source of merged
  /// scans elsewhere.
  std::optional<std::size_t> find_source(const std::string& name) const;
  /// The number of a source that must be there.
  std::size_t source(const std::string& name) const;
  /// From now on `output` gets what the source gives, as its source number `index`.
  void connect(std::size_t source, Maker& maker, std::size_t index) {
    consumers_.at(source).push_back({&maker, index});
  }

  /// To the sink, and to the outputs that are made of a scan on this topic.
  void publish(const OutputTopic& topic, const Payload& payload, Stamp now);
  /// True if the sink wants what is published on the topic.
  bool wants(const OutputTopic& topic) const { return sink_.wants(topic); }
  /// True if an output is made of what is published on the topic.
  bool feeds(const OutputTopic& topic) const { return feeds(first_topic_ + topic.id); }
  /// Counts a frame that nobody wants.
  void skip(const OutputTopic& topic, Stamp now);
  /// True if an output is made of this source whose frames are wanted.
  bool feeds(std::size_t source) const;
  /// To the outputs that are made of this source.
  void feed(std::size_t source, const PlanarScan& scan, Stamp now);
  void feed(std::size_t source, const Cloud& cloud, Stamp now);
  /// The clouds that were merged on this topic, brought to `instant`.
  void feed(const OutputTopic& topic, const std::vector<PlacedCloud>& clouds, Stamp instant, Stamp now);
  /// Reports a cloud without points, since nobody wanted them.
  void pass_by(std::size_t source, const Cloud& cloud, Stamp now);
  /// True if something was fed since the last call.
  bool was_fed() { return std::exchange(fed_, false); }

  /// What came out, by OutputTopic::id.
  const std::vector<TopicReport>& reports() const { return reports_; }

 private:
  struct Consumer {
    Maker* maker;
    std::size_t index;  // of the source among those of the output
  };
  FrameSink& sink_;
  Forward forward_ = [](const std::string&, const PlanarScan&, Stamp) {};
  std::vector<std::unique_ptr<OutputTopic>> topics_;
  std::vector<TopicReport> reports_;
  std::vector<std::string> names_;                // of the sources; a topic is the source of its scans
  std::vector<std::vector<Consumer>> consumers_;  // by source
  std::vector<char> is_forwarded_;                // by source
  std::size_t first_topic_ = 0;                   // among the sources
  bool fed_ = false;
};

}  // namespace lidard
