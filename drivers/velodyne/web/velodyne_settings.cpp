// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/velodyne_settings.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <nlohmann/json.hpp>

namespace lidard {
namespace {

using Json = nlohmann::json;

constexpr std::size_t longest_text = 128;

/// The text of a reported number or word; empty: not reported.
std::string reported(const Json& snapshot, const std::string& pointer) {
  const Json::json_pointer path(pointer);
  if (!snapshot.contains(path)) return {};
  const Json& value = snapshot[path];
  if (value.is_number()) return value.dump();
  if (!value.is_string()) return {};
  std::string text = value.get<std::string>().substr(0, longest_text);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// A field of a form that changes settings, which the snapshot reports at the same path.
struct Field {
  const char* name;  // for people
  const char* form;  // path of the form and of its section in the snapshot
  const char* field;
  std::optional<std::string> wanted;
};

std::optional<std::string> word(const std::optional<VelodyneReturns>& returns) {
  static constexpr std::array<const char*, 3> spelled = {"Strongest", "Last", "Dual"};
  if (!returns) return std::nullopt;
  return spelled.at(static_cast<std::size_t>(*returns));
}

template <class Integer>
std::optional<std::string> digits(const std::optional<Integer>& number) {
  return number ? std::optional<std::string>(std::to_string(*number)) : std::nullopt;
}

/// The sensor accepts 0 to 359, and 359 as the end of a full turn (VLP-16 user manual 63-9243 Rev D, section
/// 10.2).
std::string fov_text(const std::string& degrees) { return degrees == "360" ? "359" : degrees; }

/// Forms and fields: 63-9243 Rev D, section 10.2; names of the reported settings: tier4/nebula,
/// UniBwTAS/velodyne. The address is last, since the stream moves away with it.
std::vector<Field> fields(const VelodyneSettings& wanted) {
  const auto address = wanted.host_address ? std::optional(wanted.host_address->to_string()) : std::nullopt;
  return {{"rpm", "", "rpm", digits(wanted.rpm)},
          {"returns", "", "returns", word(wanted.returns)},
          {"fov start", "/fov", "start", digits(wanted.fov_start_deg)},
          {"fov end", "/fov", "end", digits(wanted.fov_end_deg)},
          {"host port", "/host", "dport", digits(wanted.host_port)},
          {"host telemetry_port", "/host", "tport", digits(wanted.host_telemetry_port)},
          {"host address", "/host", "addr", address}};
}

void plan_field(const Json& snapshot, const Field& field, VelodynePlan& plan) {
  if (!field.wanted) return;
  const std::string form = field.form;
  const std::string now = reported(snapshot, "/config" + form + "/" + field.field);
  if (now.empty()) {
    plan.unknown.emplace_back(field.name);
    return;
  }
  const bool is_fov = form == "/fov";
  const std::string wanted = is_fov ? fov_text(*field.wanted) : *field.wanted;
  if (lower(is_fov ? fov_text(now) : now) == lower(wanted)) return;
  plan.changes.push_back({"/cgi/setting" + form, std::string(field.field) + "=" + wanted,
                          std::string(field.name) + ": " + now + " -> " + wanted});
}

}  // namespace

bool VelodyneSettings::any() const {
  return rpm || returns || fov_start_deg || fov_end_deg || host_address || host_port || host_telemetry_port;
}

std::optional<VelodynePlan> plan(const std::string& snapshot, const VelodyneSettings& wanted) {
  const Json json = Json::parse(snapshot, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  VelodynePlan result;
  result.serial = reported(json, "/info/serial");
  for (const Field& field : fields(wanted)) plan_field(json, field, result);
  return result;
}

}  // namespace lidard
