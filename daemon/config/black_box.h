// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "drivers/key.h"

namespace lidard {

class Mapping;

/// `blackbox:` of the configuration.
struct BlackBoxConfig {
  double seconds = 0;      ///< of packets that are kept; 0: none
  double megabytes = 256;  ///< of memory at most: a shorter time is kept where that does not suffice
  std::string path;        ///< folder of the captures; empty: $STATE_DIRECTORY, else /var/lib/lidard
  int files = 10;          ///< captures that are kept there; the oldest is removed for a new one
  int per_day = 100;       ///< captures that errors may start within 24 hours
};

Keys black_box_keys(BlackBoxConfig& black_box);
void read_black_box(const Mapping& root, BlackBoxConfig& black_box);

}  // namespace lidard
