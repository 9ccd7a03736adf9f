// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "daemon/config/key_tables.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

/// A key for the reference.
struct Entry {
  Key key;
  std::string preset;
  const SensorGroup* group;  // of models that accept it; nullptr: not a key of sensors
  bool inner;                // below a key of the same models
};
struct Section {
  std::string name;
  std::vector<Entry> entries;
};

std::string text_of(const KeyValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* number = std::get_if<double>(&value)) return number_text(*number);
  if (const auto* text = std::get_if<std::string>(&value)) return text->empty() ? "\"\"" : *text;
  return "";
}

template <class Owner>
std::string preset_of(const KeyOf<Owner>& key, const Owner& owner) {
  if (key.required) return "must be given";
  if (!key.preset.empty()) return std::string(key.preset);
  KeyValue value = key.get ? key.get(owner) : KeyValue();
  const auto* number = std::get_if<double>(&value);
  if (number != nullptr && !std::isfinite(*number)) value = KeyValue();
  std::string text = text_of(value);
  if (text.empty() || (text == "\"\"" && !key.may_be_empty))
    text = key.remark.empty() ? text_of(key.otherwise) : std::string(key.remark);
  return text.empty() ? "none" : text;
}

class Reference {
 public:
  std::vector<Section> sections;

  template <class Owner>
  void add(const std::string& name, const Keys<Owner>& keys, const Owner& owner,
           const SensorGroup* group = nullptr, bool inner = false) {
    auto known =
        std::find_if(sections.begin(), sections.end(), [&](const auto& s) { return s.name == name; });
    if (known == sections.end()) known = sections.insert(known, {name, {}});
    const auto index = known - sections.begin();
    for (const auto& key : keys) {
      const std::string preset = key.kind == KeyKind::section ? "" : preset_of(key, owner);
      sections[static_cast<std::size_t>(index)].entries.push_back({key, preset, group, inner});
      if (!key.inner.empty()) add(name + "." + std::string(key.name), key.inner, owner, group, true);
    }
  }
};

std::vector<Section> all_sections() {
  Reference all;
  all.add("vehicle", vehicle_keys(), VehicleConfig());
  for (const SensorGroup& group : sensor_groups())
    all.add("sensors.NAME", group.keys, SensorConfig(), &group);
  all.add("merged_scans.NAME", merged_keys(), MergedScanConfig());
  all.add("merged_scans.NAME.source_settings.SOURCE", source_keys(), SourceSettings());
  all.add("merged_clouds.NAME", merged_cloud_keys(), MergedCloudConfig());
  all.add("virtual_scans.NAME", virtual_keys(), default_virtual_scan());
  all.add("merged_scans.NAME.also.TOPIC, virtual_scans.NAME.also.TOPIC", also_key().inner, AlsoScanConfig());
  all.add("blackbox", black_box_keys(), BlackBoxConfig());
  return all.sections;
}

/// Allowed values of the key.
std::string value_text(const Key& key) {
  if (!key.words.empty()) {
    std::string list;
    for (const auto word : key.words) list.append(list.empty() ? "" : ", ").append(word);
    return list;
  }
  const std::string limits = printed("%.6g", key.lowest) + " to " + printed("%.6g", key.highest);
  switch (key.kind) {
    case KeyKind::flag:
      return "true, false";
    case KeyKind::whole:
      return "whole number, " + limits;
    case KeyKind::number:
      return limits + (key.unit.empty() ? "" : " ") + std::string(key.unit);
    case KeyKind::angle:
      return (key.highest > key.lowest ? limits + " rad" : std::string(key.form)) + "; as " +
             std::string(key.name) + "_deg in degrees";
    case KeyKind::topic:
      return "a topic";
    case KeyKind::frame:
      return "a tf frame";
    case KeyKind::pose:
      return "{xyz: [x, y, z], rpy_deg: [roll, pitch, yaw]}; m, or rpy in rad";
    case KeyKind::section:
      return key.short_form ? "keys of its own, or " + std::string("the first of them") : "keys of its own";
    default:
      return std::string(key.form);
  }
}

/// The meaning, with models and conditions.
std::string meaning_text(const Entry& entry) {
  std::string text(entry.key.meaning);
  if (entry.group != nullptr && !entry.inner && !entry.group->models.empty())
    text.append(" (").append(entry.group->models).append(")");
  return text + (entry.key.live ? " [live]" : "");
}

void print_table(std::ostream& out) {
  for (const Section& section : all_sections()) {
    out << section.name << '\n';
    for (const Entry& entry : section.entries) {
      out << "  " << entry.key.name << ": " << value_text(entry.key);
      if (!entry.preset.empty()) out << " (default: " << entry.preset << ')';
      out << "\n      " << meaning_text(entry) << '\n';
    }
  }
}

void print_markdown(std::ostream& out) {
  const auto cell = [](std::string text) {
    for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2))
      text.insert(at, 1, '\\');
    return text;
  };
  out << "# Configuration keys\n\n"
         "Printed by `lidard keys --markdown` from the tables that the parser reads. Lengths are in m, times "
         "in s, "
         "angles in rad.\n`[live]`: can be changed while the daemon runs, with dynamic_reconfigure.\n";
  for (const Section& section : all_sections()) {
    out << "\n## `" << section.name << "`\n\n| key | value | default | meaning |\n|---|---|---|---|\n";
    for (const Entry& entry : section.entries)
      out << "| `" << entry.key.name << "` | " << cell(value_text(entry.key)) << " | " << cell(entry.preset)
          << " | " << cell(meaning_text(entry)) << " |\n";
  }
}

const char* kind_text(KeyKind kind) {
  constexpr const char* names[] = {"flag",  "whole", "number", "angle",   "word",   "text",
                                   "topic", "frame", "pose",   "section", "special"};
  return names[static_cast<std::size_t>(kind)];
}

nlohmann::ordered_json json_of(const Section& section, const Entry& entry) {
  const Key& key = entry.key;
  nlohmann::ordered_json json{
      {"section", section.name},  {"key", key.name},         {"kind", kind_text(key.kind)},
      {"value", value_text(key)}, {"default", entry.preset}, {"meaning", key.meaning},
      {"live", key.live},         {"required", key.required}};
  if (key.highest > key.lowest) json.update({{"min", key.lowest}, {"max", key.highest}, {"unit", key.unit}});
  if (!key.words.empty()) json["words"] = key.words;
  if (entry.group == nullptr || entry.group->takes == nullptr) return json;
  for (const Model& model : models()) {
    if (entry.group->takes(model)) json["models"].push_back(model.name);
  }
  return json;
}

void print_json(std::ostream& out) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Section& section : all_sections()) {
    for (const Entry& entry : section.entries) list.push_back(json_of(section, entry));
  }
  out << list.dump(2) << '\n';
}

}  // namespace

int run_keys(KeysFormat format, std::ostream& out) {
  switch (format) {
    case KeysFormat::table:
      print_table(out);
      break;
    case KeysFormat::markdown:
      print_markdown(out);
      break;
    case KeysFormat::json:
      print_json(out);
      break;
  }
  return 0;
}

}  // namespace lidard
