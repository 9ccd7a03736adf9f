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
  void note(const Packet& packet);
  /// "192.168.1.9 -> port 2368 (412 packets)".
  std::vector<std::string> names() const;
  /// The first of them that sends datagrams to the port; empty: there is none.
  std::string sender_to(std::uint16_t port) const;

 private:
  std::map<Flow, std::uint64_t> packets_;
  std::uint64_t not_named_ = 0;
};

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
