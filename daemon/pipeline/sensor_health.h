// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/pipeline/report.h"
#include "daemon/pipeline/sink.h"
#include "drivers/flow.h"

namespace lidard {

/// Senders to a configured port that belong to no sensor.
class UnknownSenders {
 public:
  /// A sender is forgotten after this silence.
  static constexpr Span expires_after = std::chrono::seconds(60);

  void note(const Packet& packet);
  /// "192.168.1.9 -> port 2368 (412 packets)"; those that have sent at or after `since`.
  std::vector<std::string> names(Stamp since = {}) const;
  /// The first one that has sent datagrams to the port at or after `since`; empty: none.
  std::string sender_to(std::uint16_t port, Stamp since = {}) const;

 private:
  struct Sender {
    std::uint64_t packets = 0;
    Stamp last{};
  };

  std::map<Flow, Sender> senders_;
};

/// The health by the time since the last data of a source; `period_s`: as in SilenceLimits.
Health silence_of(Stamp last_arrival, double period_s, Stamp now);

/// A sensor's item on /diagnostics: the amount of data and, if it is too small, the probable cause.
DiagnosticItem sensor_health(const SensorConfig& config, const SensorReport& report,
                             const UnknownSenders& unknown, Stamp now);

/// "sensor NAME control": the driver's status of the device's settings.
DiagnosticItem settings_item(const SensorConfig& config, const SettingsStatus& status);

/// The item on senders to configured ports that belong to no sensor; at least one.
DiagnosticItem unknown_senders_item(const std::vector<std::string>& senders);

/// The configured source of a sensor's data: "192.168.1.201 to port 2368", "topic /rear/scan".
std::string where_from(const SensorConfig& config);

}  // namespace lidard
