// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "daemon/commands/commands.h"
#include "daemon/files/text_table.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

const char* transport_of(const Model& model) { return model.transport == Transport::udp ? "UDP" : "TCP"; }

std::vector<std::string> row_of(const Model& model) {
  const std::string port = model.port == 0 ? "port as configured" : std::to_string(model.port);
  return {std::string(model.name),
          std::string(model.vendor) + " " + std::string(model.product),
          std::string(model.protocol),
          std::string(transport_of(model)) + " " + port,
          std::to_string(std::lround(model.packets_per_s)) + "/s",
          std::string(model.verified)};
}

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
  if (!json) {
    TextTable table{{"name", "product", "protocol", "transport", "packets", "verified"}};
    for (const Model& model : models()) table.push_back(row_of(model));
    print_columns(table, out);
    return 0;
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Model& model : models()) list.push_back(json_of(model));
  out << list.dump(2) << '\n';
  return 0;
}

}  // namespace lidard
