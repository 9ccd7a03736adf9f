// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/web_status.h"

#include <algorithm>
#include <cctype>

#include "core/base/number_text.h"

namespace lidard::velodyne {
namespace {

std::string value_of(const VelodyneTree& tree, const std::string& key) {
  const auto found = tree.find(key);
  return found == tree.end() ? std::string() : found->second;
}

bool same_word(const std::string& a, const std::string& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](char x, char y) {
           return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
         });
}

bool is_everybody(const IpAddress& address) {
  return address.is_multicast() || (!address.v6 && address.bytes[3] == 255);
}

void judge_port(const VelodyneTree& tree, const Received& received, std::vector<std::string>& found) {
  const auto port = number_in<unsigned>(value_of(tree, "config.host.dport"));
  if (!port || *port == received.listens_on) return;
  const std::string reports =
      "the sensor reports that it sends to port " + value_of(tree, "config.host.dport") + ", ";
  if (received.data)
    found.push_back(reports + "but its data arrive on " + std::to_string(received.listens_on) +
                    "; is there another sensor with its address, or a forwarding rule?");
  else
    found.push_back(reports + "but ip_port is " + std::to_string(received.listens_on) +
                    "; correct ip_port, or set host_port: " + std::to_string(received.listens_on) +
                    " in control");
}

void judge_address(const WebState& state, const Received& received, std::vector<std::string>& found) {
  const std::string text = value_of(state.tree, "config.host.addr");
  const auto address = IpAddress::parse(text);
  if (!address || is_everybody(*address)) return;
  if (received.data) {
    if (*address != received.destination.address && !is_everybody(received.destination.address))
      found.push_back("the sensor reports that it sends to " + text + ", but its data arrive for " +
                      received.destination.address.to_string() +
                      "; is there another sensor with its address, or a forwarding rule?");
  } else if (!state.local_address.empty() && text != state.local_address) {
    found.push_back("the sensor sends its data to " + text + ", but this host is " + state.local_address +
                    " there; set host_address: " + state.local_address +
                    " in control, or this host's address");
  }
}

void judge_state(const VelodyneTree& tree, std::vector<std::string>& found) {
  if (same_word(value_of(tree, "status.motor.state"), "off"))
    found.emplace_back("the motor is off; switch it on in the sensor's web page (rpm)");
  if (same_word(value_of(tree, "status.laser.state"), "off"))
    found.emplace_back("the laser is off; switch it on in the sensor's web page");
  if (same_word(value_of(tree, "status.gps.pps_state"), "error"))
    found.emplace_back("the sensor reports an error of the PPS signal; check the time source");
}

std::string list_of(const std::vector<std::string>& words) {
  std::string list;
  for (const auto& word : words) list += (list.empty() ? "" : ", ") + word;
  return list;
}

void judge(const WebState& state, const Received& received, SettingsStatus& item) {
  std::vector<std::string> found = contradictions(state, received);
  judge_state(state.tree, found);
  if (!state.refused.empty()) {
    item.level = SettingsStatus::Level::error;
    item.message = "the sensor did not apply " + list_of(state.refused) +
                   "; set it in the sensor's web page, or remove it from control";
  } else if (!state.trouble.empty()) {
    item.level = SettingsStatus::Level::warn;
    item.message = state.trouble;
  } else if (!state.unknown.empty()) {
    item.level = SettingsStatus::Level::warn;
    item.message = "the sensor does not report " + list_of(state.unknown) +
                   ", so it is not written; remove it from control";
  } else if (!found.empty()) {
    item.level = SettingsStatus::Level::warn;
    item.message = found.front();
  } else {
    item.message = state.answered ? "answering" : "not asked yet";
  }
  for (std::size_t i = 0; i < found.size(); ++i)
    item.details.emplace_back("Remark " + std::to_string(i + 1), found[i]);
}

void add_values(const VelodyneTree& tree, SettingsStatus& item) {
  static constexpr std::pair<const char*, const char*> rows[] = {
      {"Model", "info.model"},
      {"Serial Number", "info.serial"},
      {"Returns", "config.returns"},
      {"Set rpm", "config.rpm"},
      {"FOV start", "config.fov.start"},
      {"FOV end", "config.fov.end"},
      {"Destination address", "config.host.addr"},
      {"Destination port", "config.host.dport"},
      {"Destination telemetry port", "config.host.tport"},
      {"Motor", "status.motor.state"},
      {"Motor rpm", "status.motor.rpm"},
      {"Motor lock", "status.motor.lock"},
      {"Laser", "status.laser.state"},
      {"PPS", "status.gps.pps_state"},
      {"Position", "status.gps.position"},
  };
  for (const auto& [label, key] : rows) {
    const std::string value = value_of(tree, key);
    if (!value.empty()) item.details.emplace_back(label, value);
  }
}

}  // namespace

std::vector<std::string> contradictions(const WebState& state, const Received& received) {
  std::vector<std::string> found;
  judge_port(state.tree, received, found);
  judge_address(state, received, found);
  return found;
}

SettingsStatus web_status(const WebState& state, const Received& received) {
  SettingsStatus item;
  item.serial = state.serial;
  judge(state, received, item);
  add_values(state.tree, item);
  item.details.emplace_back("Requests", std::to_string(state.requests));
  item.details.emplace_back("Failed requests", std::to_string(state.failures));
  item.details.emplace_back("Settings written", std::to_string(state.writes));
  return item;
}

}  // namespace lidard::velodyne
