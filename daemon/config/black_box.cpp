// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// `blackbox:` of a configuration.
#include "daemon/config/sections.h"

namespace lidard {

const Keys<BlackBoxConfig>& black_box_keys() {
  using namespace keys;
  using B = BlackBoxConfig;
  static const Keys<B> all{
      number("seconds", &B::seconds, 0, 3600, "s",
             "packets of all sensors so far back are kept in memory, and written when something goes wrong; "
             "0: none"),
      number("megabytes", &B::megabytes, 1, 100'000, "MB",
             "memory for them at most; where that does not suffice, a shorter time is kept"),
      text("path", &B::path, "a folder",
           "where the captures are written; empty: $STATE_DIRECTORY, else /var/lib/lidard")
          .or_empty(),
      whole("files", &B::files, 1, 1000,
            "captures kept there; a new one takes the place of the oldest, but the first of each kind of "
            "error stays")};
  return all;
}

void read_black_box(Mapping& root, Reading& reading) {
  const auto section = root.find("blackbox");
  if (!section) return;
  Mapping yaml = mapping_of(*section, black_box_keys());
  read_keys(yaml, black_box_keys(), reading.config.black_box);
}

}  // namespace lidard
