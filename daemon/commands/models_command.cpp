// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <nlohmann/json.hpp>
#include <ostream>

#include "daemon/commands/commands.h"
#include "daemon/files/text_table.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

nlohmann::ordered_json json_of(const Model& model) {
  return {{"name", model.name},
          {"vendor", model.vendor},
          {"product", model.product},
          {"protocol", model.protocol},
          {"frames", model.kind == FrameKind::cloud ? "cloud" : "scan"},
          {"transport", model.transport == Transport::udp ? "udp" : "tcp"},
          {"port", model.port},
          {"telemetry_port", model.telemetry_port},
          {"packets_per_s", model.packets_per_s},
          {"frame_period_s", model.frame_period},
          {"range_min_m", model.range_min},
          {"range_max_m", model.range_max},
          {"beams", model.beams},
          {"verified", model.verified}};
}

}  // namespace

int run_models(bool json, std::ostream& out) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Model& model : models()) list.push_back(json_of(model));
  if (json)
    out << list.dump(2) << '\n';
  else
    print_columns(table_of(list, {"name", "vendor", "product", "protocol", "transport", "port",
                                  "packets_per_s", "verified"}),
                  out);
  return 0;
}

}  // namespace lidard
