// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/counters.h"
#include "core/base/time.h"
#include "daemon/pipeline/reception.h"
#include "drivers/driver.h"

namespace lidard {

/// What one sensor did since the start, for the table at the end of a replay and for diagnostics.
struct SensorReport {
  std::string name;
  std::string model;  ///< or "topic"
  Counters counters;
  DeviceInfo info;
  bool seen = false;         ///< any data received at all
  Stamp last_arrival;        ///< of data
  Stamp last_telemetry;      ///< of what the device tells beside its data
  std::string link_trouble;  ///< why there is no connection to a device that needs one; empty: there is
  bool starting = false;     ///< the first second of all watching: silence says nothing yet
  Reception recent, whole;   ///< of the last 10 s, and since the start
  std::vector<std::string> rivals, rivals_ever;  ///< several senders into one entry, now and at any time
};

}  // namespace lidard
