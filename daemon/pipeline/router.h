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

#include "daemon/config/config.h"
#include "daemon/pipeline/sink.h"
#include "daemon/pipeline/status.h"

namespace lidard {

class Router;

/// Passes a scan to the part of the configuration that merges it.
using Forward = std::function<void(const std::string& source, const PlanarScan& scan, Stamp now)>;

/// Uses the frames of sources.
class FrameUser {
 public:
  virtual ~FrameUser() = default;
  /// False while nobody would get what it makes of them.
  virtual bool is_wanted() const { return true; }
  /// Accepts a frame; `source`: index of its source among those of this.
  virtual void add(std::size_t source, const Frame& frame, Stamp now) = 0;
};

/// Who uses the frames of a sensor, or what travels on a topic. Keeps its address over a reload.
class Route {
 public:
  Route(Router& router, std::string name) : router_(router), name_(std::move(name)) {}
  /// Delivers a frame to the sink, if this is a topic, and to its users.
  void deliver(const Frame& frame, Stamp now);
  /// False while nobody would get a frame.
  bool is_wanted() const;
  const std::string& name() const { return name_; }

 private:
  friend class Router;
  struct Use {
    FrameUser* user;
    std::size_t source;  // index among those of the user
  };
  Router& router_;
  const std::string name_;
  std::optional<OutputTopic> topic_;  // none: the frames of a sensor, or of a source elsewhere
  TopicTotals report_;                // of the topic
  std::vector<Use> uses_;
  bool is_forwarded_ = false;
};

/// The routes of a pipeline: one for each sensor, each topic and each source of merged scans that is
/// elsewhere.
class Router {
 public:
  /// The sink must outlive this.
  explicit Router(FrameSink& sink) : sink_(sink) {}
  /// Makes the routes of a configuration, which have no users yet. Topics that were there before keep what
  /// they counted.
  void configure(const Config& config);
  void set_forward(Forward forward) { forward_ = std::move(forward); }
  /// From now on the user gets the frames of its sources, which must be there.
  void connect(FrameUser& user, const std::vector<std::string>& sources);

  /// The route of that source: a sensor, a virtual scan or merged cloud by its topic, or a source elsewhere;
  /// nullptr: there is none.
  Route* find_source(const std::string& name) const;
  /// The route of a source, or of a topic, that must be there.
  Route& source(const std::string& name) const;
  Route& topic(const std::string& name) const;
  /// Number of frames delivered so far.
  std::uint64_t delivered() const { return delivered_; }
  /// What came out, by OutputTopic::id.
  std::vector<TopicTotals> reports() const;

 private:
  friend class Route;
  FrameSink& sink_;
  Forward forward_ = [](const std::string&, const PlanarScan&, Stamp) {};
  std::vector<std::unique_ptr<Route>> routes_;  // sensors, topics, sources elsewhere
  std::uint64_t delivered_ = 0;
};

}  // namespace lidard
