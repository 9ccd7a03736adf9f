// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/velodyne_settings.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/number_text.h"

namespace lidard {
namespace {

using Json = nlohmann::json;

// A snapshot has about 80 values, three levels deep; the longest is an NMEA sentence.
constexpr std::size_t most_values = 1000;
constexpr std::size_t longest_text = 128;
constexpr int deepest_level = 8;

std::string printable(const std::string& text) {
  std::string result = text.substr(0, longest_text);
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return result;
}

std::string text_of(const Json& value) {
  if (value.is_string()) return printable(value.get_ref<const std::string&>());
  if (value.is_boolean()) return value.get<bool>() ? "on" : "off";
  return value.is_null() ? std::string() : value.dump().substr(0, longest_text);
}

/// Recursion is limited here, since the text comes from the network.
void flatten(const Json& value, const std::string& name, int level, VelodyneTree& tree) {
  if (value.is_array() || tree.size() >= most_values) return;
  if (!value.is_object()) {
    tree.emplace(name, text_of(value));
    return;
  }
  if (level == deepest_level) return;
  for (const auto& [key, child] : value.items())
    flatten(child, (name.empty() ? "" : name + ".") + printable(key), level + 1, tree);
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The sensor accepts 0 to 359, and 359 as the end of a full turn (VLP-16 user manual 63-9243 Rev D, section
/// 10.2).
int sensor_fov(int degrees) { return std::min(degrees, 359); }

std::string fov_text(std::string text) { return text == "360" ? "359" : text; }

/// The wanted value of a form field, and where it is reported.
struct Field {
  const char* name;     // for people
  const char* reports;  // in the snapshot
  const char* path;
  const char* field;
  std::optional<std::string> wanted;
};

template <class Number>
std::optional<std::string> wanted_number(const std::optional<Number>& number) {
  return number ? std::optional<std::string>(std::to_string(*number)) : std::nullopt;
}

std::optional<std::string> wanted_fov(const std::optional<int>& degrees) {
  return degrees ? wanted_number(std::optional<int>(sensor_fov(*degrees))) : std::nullopt;
}

// Paths and fields of the forms: 63-9243 Rev D, section 10.2; names of the reported settings: tier4/nebula,
// UniBwTAS/velodyne.
std::vector<Field> setting_fields(const VelodyneSettings& w) {
  const char* setting = "/cgi/setting";
  const char* fov = "/cgi/setting/fov";
  return {
      {"rpm", "config.rpm", setting, "rpm", wanted_number(w.rpm)},
      {"returns", "config.returns", setting, "returns",
       w.returns ? std::optional<std::string>(to_string(*w.returns)) : std::nullopt},
      {"fov start", "config.fov.start", fov, "start", wanted_fov(w.fov_start_deg)},
      {"fov end", "config.fov.end", fov, "end", wanted_fov(w.fov_end_deg)},
  };
}

/// The address is last, since the stream moves away with it.
std::vector<Field> host_fields(const VelodyneSettings& w) {
  const char* host = "/cgi/setting/host";
  return {{"host port", "config.host.dport", host, "dport", wanted_number(w.host_port)},
          {"host telemetry_port", "config.host.tport", host, "tport", wanted_number(w.host_telemetry_port)},
          {"host address", "config.host.addr", host, "addr",
           w.host_address ? std::optional<std::string>(w.host_address->to_string()) : std::nullopt}};
}

std::optional<std::string> reported(const VelodyneTree& tree, const char* name) {
  const auto found = tree.find(name);
  return found == tree.end() || found->second.empty() ? std::nullopt
                                                      : std::optional<std::string>(found->second);
}

void plan_field(const VelodyneTree& tree, const Field& field, VelodynePlan& plan) {
  if (!field.wanted) return;
  const auto now = reported(tree, field.reports);
  if (!now) {
    plan.unknown.emplace_back(field.name);
    return;
  }
  const bool is_fov = std::string(field.path) == "/cgi/setting/fov";
  if (lower(is_fov ? fov_text(*now) : *now) == lower(*field.wanted)) return;
  plan.changes.push_back({field.path, std::string(field.field) + "=" + *field.wanted,
                          std::string(field.name) + ": " + *now + " -> " + *field.wanted});
}

}  // namespace

std::optional<VelodyneTree> read_velodyne_json(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  VelodyneTree tree;
  flatten(json, "", 0, tree);
  return tree;
}

const char* to_string(VelodyneReturns returns) {
  static constexpr std::array<const char*, 3> words = {"Strongest", "Last", "Dual"};
  return words.at(static_cast<std::size_t>(returns));
}

bool VelodyneSettings::any() const {
  return rpm || returns || fov_start_deg || fov_end_deg || host_address || host_port || host_telemetry_port;
}

VelodynePlan plan(const VelodyneTree& tree, const VelodyneSettings& wanted) {
  VelodynePlan result;
  for (const Field& field : setting_fields(wanted)) plan_field(tree, field, result);
  for (const Field& field : host_fields(wanted)) plan_field(tree, field, result);
  return result;
}

}  // namespace lidard
