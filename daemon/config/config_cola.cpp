// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/config_parts.h"

namespace lidard {

void read_cola_requests(Mapping& yaml, DeviceRequests& requests) {
  constexpr int most_skipped = 999;
  if (const auto skip = yaml.find("skip")) requests.skip = static_cast<int>(skip->integer(0, most_skipped));
  if (const auto states = yaml.find("publish_states")) requests.device_states = states->boolean();
}

}  // namespace lidard
