// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_keys.h"

namespace lidard {

using namespace keys;
using R = DeviceRequests;

Keys<R> cola_keys() {
  return {flag("publish_states", &R::device_states, "also field evaluation, inputs and outputs"),
          whole("skip", &R::skip, 0, 999, "scans left out between two").unless_set("as the device is set")};
}

}  // namespace lidard
