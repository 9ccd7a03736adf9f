// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/black_box.h"

#include "daemon/config/rows.h"

namespace lidard {

Keys black_box_keys(BlackBoxConfig& black_box) {
  using namespace keys;
  return {
      {"seconds", black_box.seconds, number(0, 3600, "s"),
       "packets of all sensors so far back are kept in memory, and written when something goes wrong; 0: "
       "none"},
      {"megabytes", black_box.megabytes, number(1, 100'000, "MB"),
       "memory for them at most; where that does not suffice, a shorter time is kept"},
      {"path", black_box.path, text("a folder"),
       "where the captures are written; empty: $STATE_DIRECTORY, else /var/lib/lidard", or_none},
      {"files", black_box.files, whole(1, 1000),
       "captures kept there; a new one takes the place of the oldest, but the first of each kind of error "
       "stays"},
      {"per_day", black_box.per_day, whole(1, 1440),
       "captures that errors may start within 24 hours, and one a minute at most; `lidard dump` does not "
       "count"}};
}

void read_black_box(const Mapping& root, BlackBoxConfig& black_box) {
  if (const auto section = root.find("blackbox")) read_section(*section, black_box_keys(black_box));
}

}  // namespace lidard
