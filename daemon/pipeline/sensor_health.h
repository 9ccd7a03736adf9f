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

/// Senders on a configured port that no sensor claims.
class UnknownSenders {
 public:
  /// Who sent nothing for so long is not reported any more.
  static constexpr Span expires_after = std::chrono::seconds(60);

  void note(const Packet& packet);
  /// "192.168.1.9 -> port 2368 (412 packets)"; those that have sent at or after `since`.
  std::vector<std::string> names(Stamp since = {}) const;
  /// The first of them that has sent datagrams to the port at or after `since`; empty: there is none.
  std::string sender_to(std::uint16_t port, Stamp since = {}) const;

 private:
  struct Sender {
    std::uint64_t packets = 0;
    Stamp last{};
  };
  bool make_room(Stamp now);

  std::map<Flow, Sender> senders_;
  Sender not_named_;
};

/// OK while no longer time than a warning or an error has passed since the last data of a source; `period_s`:
/// as in SilenceLimits.
Health silence_of(Stamp last_arrival, double period_s, Stamp now);

/// A sensor's line on /diagnostics: is there data, as much as there should be, and if not, why probably not.
DiagnosticItem sensor_health(const SensorConfig& config, const SensorReport& report,
                             const UnknownSenders& unknown, Stamp now);

/// "sensor NAME control": what its driver tells of the device's settings.
DiagnosticItem settings_item(const SensorConfig& config, const SettingsStatus& status);

/// Names the senders on our ports that no sensor claims; there is at least one.
DiagnosticItem unknown_senders_item(const std::vector<std::string>& senders);

/// Where the data of a sensor come from, as configured: "192.168.1.201 to port 2368", "topic /rear/scan".
std::string where_from(const SensorConfig& config);

}  // namespace lidard
