// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_keys.h"

namespace lidard {

using namespace keys;
using R = DeviceRequests;

Keys<R> scip_keys() {
  return {whole("skip", &R::skip, 0, 9, "scans left out between two").or_else(0.0),
          whole("cluster", &R::cluster, 1, 99, "beams merged into one").or_else(1.0)};
}

Keys<R> scip_clock_keys() {
  return {flag("calibrate_time", &R::calibrate_time, "compares both clocks once before the stream starts")};
}

}  // namespace lidard
