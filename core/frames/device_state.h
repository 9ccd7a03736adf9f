// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"

namespace lidard {

/// One named value of a device's state; flags are 0 or 1. The name is a constant of the driver.
struct DeviceValue {
  std::string_view name;
  double value = 0;
};

/// What a device tells beside its frames: switching outputs, field evaluation, encoder, system state.
struct DeviceState {
  std::string_view topic;  ///< last part of the topic's name, one of Model::state_topics
  std::string frame_id;
  Stamp stamp;  ///< that of the scan it came with, else its own
  std::vector<DeviceValue> values;
};

}  // namespace lidard
