// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>

#include "daemon/offline/player.h"
#include "daemon/offline/recorded_motion.h"
#include "daemon/python/frame_source.h"

namespace lidard::python {

/// What a configuration makes of captures.
class ReplayReader final : public FrameSource, public FrameSink {
 public:
  /// `topics`: what is made; empty: everything. `motion`: a table, or empty. Throws ConfigError and
  /// std::runtime_error. At the end new_error() says which output never came.
  ReplayReader(Config config, const std::vector<std::string>& captures, const std::string& motion,
               std::set<std::string> topics);

  bool wants(const OutputTopic& topic) const override;
  void publish(const OutputTopic& topic, const lidard::Frame& frame, Stamp released) override;

 private:
  bool advance() override;
  std::string sensors_json() const override;
  void free() override { run_.reset(); }
  /// Why an output is missing; empty: all came.
  std::string what_is_missing() const;

  struct Run {
    Run(const Config& config, const std::vector<std::string>& captures, const std::string& motion_file,
        FrameSink& sink);
    PlayOptions options;
    MotionTable motion;
    MergedCapture capture;
    Pipeline pipeline;
    Player player;
  };
  const Config config_;
  const std::set<std::string> topics_;
  std::map<std::string, std::string> sensor_of_;  // by topic
  std::string last_sensors_;                      // of a run that has ended
  std::unique_ptr<Run> run_;
};

}  // namespace lidard::python
