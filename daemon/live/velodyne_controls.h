// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/live/velodyne_http.h"
#include "daemon/live/velodyne_judge.h"
#include "drivers/velodyne/stream_facts.h"

namespace lidard {

/// The web interfaces of the configured sensors: one worker for each whose `control` allows reading. All
/// calls come from the sensor thread and never wait, but for stop().
class VelodyneControls {
 public:
  explicit VelodyneControls(const Config& config);

  void start();
  /// Waits for the workers, whose requests are cut off.
  void stop();
  /// Looks at a received packet.
  void packet(const Packet& packet);
  /// One item per worker.
  void add_diagnostics(std::vector<DiagnosticItem>& items, Stamp now) const;

 private:
  struct Sensor {
    std::string name;
    Endpoint endpoint;  // its address, our port
    velodyne::StreamFacts facts;
    std::unique_ptr<VelodyneHttp> http;
  };
  std::vector<Sensor> sensors_;
};

}  // namespace lidard
