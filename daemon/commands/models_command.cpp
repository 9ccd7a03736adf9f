// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <ostream>

#include "daemon/commands/commands.h"
#include "daemon/files/text_table.h"
#include "daemon/offline/survey_json.h"

namespace lidard {

int run_models(bool json, std::ostream& out) {
  const nlohmann::ordered_json list = json_of_models();
  if (json)
    out << list.dump(2) << '\n';
  else
    print_columns(table_of(list, {"name", "vendor", "product", "protocol", "transport", "port",
                                  "packets_per_s", "verified"}),
                  out);
  return 0;
}

}  // namespace lidard
