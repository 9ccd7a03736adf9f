// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "drivers/driver.h"
#include "drivers/hokuyo/scip_message.h"
#include "drivers/hokuyo/scip_parameters.h"

namespace lidard::hokuyo {

/// What to ask a sensor for: the steps inside the configured angles (all of them if there are none), cluster
/// and skip.
inline ScipScanRequest request_for(const ScipParameters& p, const DriverConfig& config) {
  ScipScanRequest request;
  // Configured angles are rounded: a step on the limit is inside.
  constexpr double slack = 0.01;
  const auto step_at = [&p](double angle) { return angle / p.rad_per_step() + p.front_step; };
  const double low = config.angle_min ? std::ceil(step_at(*config.angle_min) - slack) : p.first_step;
  const double high = config.angle_max ? std::floor(step_at(*config.angle_max) + slack) : p.last_step;
  request.first_step = static_cast<int>(std::clamp<double>(low, p.first_step, p.last_step));
  request.last_step = static_cast<int>(std::clamp<double>(high, p.first_step, p.last_step));
  if (low > high || request.last_step < request.first_step) {
    request.first_step = p.first_step;
    request.last_step = p.last_step;
  }
  request.cluster = std::clamp(config.requests.cluster.value_or(1), 1, 99);
  request.skip = std::clamp(config.requests.skip.value_or(0), 0, 9);
  return request;
}

/// True for UST firmware that knows the % extension: from 4.1, or from 1.1 within 1.x (as urg_stamped has
/// it).
inline bool firmware_knows_percent(const std::string& firmware) {
  int major = 0, minor = 0;
  if (std::sscanf(firmware.c_str(), "%d.%d", &major, &minor) != 2) return false;
  return major > 4 || (major == 4 && minor >= 1) || (major == 1 && minor >= 1);
}

}  // namespace lidard::hokuyo
