// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "daemon/config/config.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const KeyValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* number = std::get_if<double>(&value)) return number_text(*number);
  if (const auto* text = std::get_if<std::string>(&value)) return text->empty() ? "\"\"" : *text;
  return "";
}

std::string preset_of(const Key& key) {
  if (key.required) return "must be given";
  if (!key.preset.empty()) return std::string(key.preset);
  KeyValue value = key.value;
  const auto* number = std::get_if<double>(&value);
  if (number != nullptr && !std::isfinite(*number)) value = KeyValue();
  std::string text = text_of(value);
  if (text.empty() || (text == "\"\"" && !key.may_be_empty))
    text = key.remark.empty() ? text_of(key.otherwise) : std::string(key.remark);
  return text.empty() ? "none" : text;
}

/// Allowed values of the key.
std::string value_text(const Key& key) {
  if (!key.words.empty()) {
    std::string list;
    for (const Word& word : key.words) list.append(list.empty() ? "" : ", ").append(word.text);
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
      return std::string("keys of its own") +
             (key.style == SectionStyle::brief ? ", or the first of them" : "");
    default:
      return std::string(key.form);
  }
}

const char* kind_text(KeyKind kind) {
  constexpr const char* names[] = {"flag",  "whole", "number", "angle",   "word",   "text",
                                   "topic", "frame", "pose",   "section", "special"};
  return names[static_cast<std::size_t>(kind)];
}

/// A key for the reference; `trait`: of models that accept it; none: every source does.
Json json_of(const std::string& section, const Key& key, const std::string& preset,
             std::optional<Trait> trait) {
  Json json{{"section", section},       {"key", key.name},         {"kind", kind_text(key.kind)},
            {"value", value_text(key)}, {"default", preset},       {"meaning", key.meaning},
            {"live", key.live},         {"required", key.required}};
  if (key.highest > key.lowest) json.update({{"min", key.lowest}, {"max", key.highest}, {"unit", key.unit}});
  for (const Word& word : key.words) json["words"].push_back(word.text);
  if (!trait) return json;
  json["products"] = products_with(*trait);
  for (const Model& model : models()) {
    if (model.has(*trait)) json["models"].push_back(model.name);
  }
  return json;
}

/// Adds the keys of a structure to their section, and those below them to sections of their own.
void add(Json& sections, const std::string& name, const Keys& keys, std::optional<Trait> of_section = {}) {
  for (const Key& key : keys) {
    const std::optional<Trait> trait = key.trait ? key.trait : of_section;
    const std::string preset = key.kind == KeyKind::section ? "" : preset_of(key);
    sections[name].push_back(json_of(name, key, preset, trait));
    if (!key.inner.empty()) add(sections, name + "." + std::string(key.name), key.inner, trait);
  }
}
/// The keys of a section, with the defaults that `entry` has.
template <class Section>
void add(Json& sections, const std::string& name, Keys (*keys)(Section&), Section entry = {}) {
  add(sections, name, keys(entry));
}

/// All keys, by section.
Json all_sections() {
  Json all;
  add(all, "vehicle", vehicle_keys);
  add(all, "sensors.NAME", sensor_keys);
  add(all, "merged_scans.NAME", merged_keys);
  add(all, "merged_scans.NAME.source_settings.SOURCE", source_keys);
  add(all, "merged_clouds.NAME", merged_cloud_keys);
  add(all, "virtual_scans.NAME", virtual_keys, default_virtual_scan());
  add(all, "blackbox", black_box_keys);
  return all;
}

/// The text in a manual page: a leading dot or quote would be a roff request.
std::string roff(const std::string& text) {
  std::string safe = text.find_first_of(".'") == 0 ? "\\&" : "";
  for (const char c : text) safe += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
  const std::string dots = "…";  // Latin-1 has none
  for (std::size_t at; (at = safe.find(dots)) != std::string::npos;)
    safe.replace(at, dots.size(), "\\[u2026]");
  return safe;
}

/// For people: the meaning names the products that have a key, and what can be changed while the daemon runs.
void print_text(KeysFormat format, std::ostream& out) {
  const bool markdown = format == KeysFormat::markdown, man = format == KeysFormat::man;
  const Json all = all_sections();
  for (const auto& [section, keys] : all.items()) {
    if (markdown)
      out << "\n## `" << section << "`\n\n| key | value | default | meaning |\n|---|---|---|---|\n";
    else
      out << (man ? ".SS " + roff(section) : section) << '\n';
    for (const Json& key : keys) {
      const std::string name = key["key"], value = key["value"], preset = key["default"];
      std::string meaning = key["meaning"];
      const std::string products = section == "sensors.NAME" ? key.value("products", "") : "";
      if (!products.empty()) meaning += " (" + products + ")";
      if (key["live"]) meaning += " [live]";
      if (markdown)
        out << "| `" << name << "` | " << value << " | " << preset << " | " << meaning << " |\n";
      else if (man)
        out << ".TP\n.B " << roff(name) << '\n'
            << roff(meaning) << ".\n"
            << roff(value) << (preset.empty() ? "" : "; default: ") << roff(preset) << ".\n";
      else
        out << "  " << name << ": " << value << (preset.empty() ? "" : " (default: " + preset + ")")
            << "\n      " << meaning << '\n';
    }
  }
}

}  // namespace

int run_keys(KeysFormat format, std::ostream& out) {
  if (format == KeysFormat::json) {
    Json list = Json::array();
    for (const Json& keys : all_sections()) list.insert(list.end(), keys.begin(), keys.end());
    out << list.dump(2) << '\n';
    return 0;
  }
  if (format == KeysFormat::markdown)
    out << "# Configuration keys\n\n"
           "Printed by `lidard keys --markdown` from the tables that the parser reads. "
           "Lengths are in m, times in s, angles in rad.\n"
           "`[live]`: can be changed while the daemon runs, with dynamic_reconfigure.\n";
  print_text(format, out);
  return 0;
}

}  // namespace lidard
