// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/moving.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "core/base/nearest.h"
#include "core/base/number_text.h"
#include "daemon/config/values.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return text;
}

/// Compares parameters: 600 equals 600.0, and True equals true.
bool same_value(const std::string& a, const std::string& b) {
  const auto x = number_in<double>(a), y = number_in<double>(b);
  return x && y ? *x == *y : lower(a) == lower(b);
}

bool is_idle(const std::string& value, std::string_view idle) {
  const auto values = split_words(idle);
  return value.empty() || std::any_of(values.begin(), values.end(), [&](const std::string& one) {
           return one == "*" || same_value(value, one);
         });
}

std::string code_words(std::string_view list) {
  std::string text;
  for (const auto& word : split_words(list)) text.append(text.empty() ? "`" : ", `").append(word).append("`");
  return text;
}

void write_package(std::ostream& out, const MovedPackage& package) {
  out << "\n## " << package.name << "\n\nRead from " << package.source << ".\n"
      << "\n| parameter | key | what becomes of it |\n|---|---|---|\n";
  for (const MovedParameter& row : package.parameters)
    out << "| " << code_words(row.names) << " | " << (row.key.empty() ? "–" : code_words(row.key)) << " | "
        << row.remark << " |\n";
  out << "\n| topic or service | type | here |\n|---|---|---|\n";
  for (const MovedTopic& row : package.topics)
    out << "| " << code_words(row.name) << " | " << row.type << " | " << row.ours << " |\n";
}

KeyValue as_intensity_filter(const std::string& value) {
  return std::strtod(value.c_str(), nullptr) > 0 ? KeyValue(KeyMap{{"intensity_min", value}}) : KeyValue();
}

KeyValue true_if_true(const std::string& value) {
  return lower(value) == "true" || value == "1" ? KeyValue(true) : KeyValue();
}

KeyValue true_if_1(const std::string& value) { return value == "1" ? KeyValue(true) : KeyValue(); }
KeyValue copied_unless_0(const std::string& value) { return value == "0" ? KeyValue() : copied(value); }

/// A conversion and its name in the table.
struct Conversion {
  std::string_view name;
  KeyValue (*convert)(const std::string& value);
};
constexpr Conversion conversions[] = {
    {"", nullptr},       {"copy", copied},          {"unless_0", copied_unless_0},
    {"if_1", true_if_1}, {"if_true", true_if_true}, {"intensity", as_intensity_filter}};

constexpr const char table[] =
#include "config/moving_over.tsv"
    ;

bool is_name_of(std::string_view list, const std::string& name) {
  const auto words = split_words(list);
  return std::any_of(words.begin(), words.end(), [&](const std::string& one) {
    return one.back() == '*' ? name.compare(0, one.size() - 1, one, 0, one.size() - 1) == 0 : one == name;
  });
}

/// The word of the package that the node is called by, with or without _node; empty: none.
std::string word_of(const MovedPackage& package, const std::string& node) {
  const std::string name = lower(node.substr(node.rfind('/') + 1));
  for (const std::string& word : split_words(package.packages)) {
    if (name == lower(word) || name == lower(word) + "_node") return word;
  }
  return {};
}

/// The cells of a row; missing cells are empty.
std::array<std::string_view, 6> cells_of(std::string_view row) {
  std::array<std::string_view, 6> cells;
  for (std::string_view& one : cells) {
    one = row.substr(0, row.find('\t'));
    row.remove_prefix(std::min(row.size(), one.size() + 1));
  }
  return cells;
}

std::vector<MovedPackage> read_table() {
  std::vector<MovedPackage> packages;
  for (std::string_view rest(table); !rest.empty();) {
    const std::string_view row = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), row.size() + 1));
    const auto [kind, a, b, c, d, e] = cells_of(row);
    if (kind == "package") packages.push_back({a, b, c, d, e, {}, {}});
    if (kind == "topic") packages.back().topics.push_back({a, b, c});
    if (kind != "parameter") continue;
    for (const Conversion& one : conversions) {
      if (one.name == c) packages.back().parameters.push_back({a, b, one.convert, d, e});
    }
  }
  return packages;
}

}  // namespace

const std::vector<MovedPackage>& moved_packages() {
  static const std::vector<MovedPackage> packages = read_table();
  return packages;
}

const MovedPackage& moved_package(std::string_view name) {
  for (const MovedPackage& package : moved_packages()) {
    if (package.name == name) return package;
  }
  throw std::out_of_range(std::string(name));
}

const MovedPackage* package_of(const std::string& node, const NodeParameters& parameters, std::string& word) {
  constexpr std::string_view common =
      "frame_id angle_* range_* min_range max_range scan_time time_offset port skip intensity use_sim_time";
  const MovedPackage* best = nullptr;
  std::size_t most = 1;
  for (const MovedPackage& package : moved_packages()) {
    std::size_t signs = 0, unknown = 0;
    bool has_needed = false;
    for (const auto& one : parameters) {
      const bool is_known = std::any_of(package.parameters.begin(), package.parameters.end(),
                                        [&](const auto& row) { return is_name_of(row.names, one.first); });
      has_needed = has_needed || is_name_of(package.needed, one.first);
      if (is_name_of(common, one.first)) continue;
      ++(is_known ? signs : unknown);
    }
    const std::string called = word_of(package, node);
    if (!called.empty()) return word = called, unknown > signs ? nullptr : &package;
    if (!has_needed || unknown > signs || signs < most) continue;
    best = signs == most ? nullptr : &package;  // several packages, or a single sign
    most = signs;
  }
  return best;
}

std::string moved_markdown() {
  std::ostringstream out;
  for (const MovedPackage& package : moved_packages()) write_package(out, package);
  return out.str();
}

std::string Sections::yaml() const {
  KeyMap filled;
  if (!vehicle.empty()) filled.emplace_back("vehicle", vehicle);
  for (const auto& [name, entries] :
       {std::pair("sensors", &sensors), {"merged_scans", &merged_scans}, {"virtual_scans", &virtual_scans}}) {
    if (!entries->empty()) filled.emplace_back(name, KeyMap(entries->begin(), entries->end()));
  }
  return yaml_text(filled);
}

std::vector<std::string> split_words(std::string_view list) {
  std::vector<std::string> words;
  std::istringstream stream{std::string(list)};
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

KeyValue* find_key(KeyMap& map, std::string_view key) {
  const auto found = std::find_if(map.begin(), map.end(), [&](const auto& one) { return one.first == key; });
  return found == map.end() ? nullptr : &found->second;
}

std::string text_of(KeyMap& map, std::string_view key) {
  const KeyValue* const value = find_key(map, key);
  const auto* const text = value == nullptr ? nullptr : std::get_if<std::string>(value);
  return text == nullptr ? std::string() : *text;
}

void erase_key(KeyMap& map, std::string_view key) {
  map.erase(std::remove_if(map.begin(), map.end(), [&](const auto& one) { return one.first == key; }),
            map.end());
}

std::string entry_name(const std::string& topic) {
  std::string name;
  for (const char c : topic) {
    const bool word = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    if (word || !name.empty()) name += word ? c : '_';
  }
  if (name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0) name.insert(0, "scan_");
  return name;
}

std::string unique_name(const std::string& name, std::set<std::string>& used) {
  std::string unique = name;
  for (int n = 2; !used.insert(unique).second; ++n) unique = name + "_" + std::to_string(n);
  return unique;
}

KeyValue copied(const std::string& value) { return value.empty() ? KeyValue() : KeyValue(value); }

KeyValue as_frame(const std::string& value) { return copied(without_slash(value)); }

const Model& model_named(const ModelNames& names, const std::string& parameter, const std::string& value) {
  if (const Model* const ours = find_model(value); ours != nullptr) return *ours;
  std::string known;
  for (const ModelName& one : names) {
    if (value == one.theirs) return *find_model(one.ours);
    known.append(known.empty() ? "" : ", ").append(one.theirs);
  }
  throw ConfigError("parameter ~" + parameter + " is '" + value +
                    "', which lidard does not support; expected one of " + known +
                    ", or a name from `lidard models`");
}

std::optional<std::string> Translation::find(const std::string& name) {
  known_.push_back(name);
  const auto found = left_.find(name);
  if (found == left_.end()) return std::nullopt;
  const std::string value = found->second;
  left_.erase(found);
  return value;
}

std::string Translation::text(const std::string& name, const std::string& missing) {
  return find(name).value_or(missing);
}

double Translation::number(const std::string& name, double missing) {
  const std::string given = text(name, "");
  if (given.empty()) return missing;
  const auto value = number_in<double>(given);
  if (!value || !std::isfinite(*value))
    throw ConfigError("parameter ~" + name + " is '" + given + "'; expected a number");
  return *value;
}

bool Translation::flag(const std::string& name, const std::string& missing) {
  const std::string given = lower(text(name, missing));
  if (given == "true" || given == "1") return true;
  if (given == "false" || given == "0" || given.empty()) return false;
  throw ConfigError("parameter ~" + name + " is '" + given + "'; expected true or false");
}

void Translation::report_without_counterpart(const MovedParameter& row) {
  constexpr std::size_t most = 6, longest = 40;  // what a reader looks at; a parameter may be a long list
  std::string given;
  std::size_t count = 0;
  bool idle = true;
  for (const std::string& name : given_names(row.names)) {
    const auto value = find(name);
    if (!value) continue;
    idle = idle && is_idle(*value, row.idle);
    if (++count > most) continue;
    const std::string text = value->size() > longest ? value->substr(0, longest) + "..." : *value;
    given.append(count == 1 ? "~" : ", ~").append(name + " (" + (text.empty() ? "empty" : text) + ")");
  }
  if (count == 0) return;
  if (count > most) given += " and " + std::to_string(count - most) + " more";
  (idle ? setup.remarks : setup.warnings)
      .push_back((count == 1 ? "parameter " + given + " has" : "parameters " + given + " have") +
                 " no effect: " + std::string(row.remark));
}

std::vector<std::string> Translation::given_names(std::string_view list) {
  std::vector<std::string> names;
  for (std::string& name : split_words(list)) {
    if (name.back() != '*') {
      names.push_back(std::move(name));
      continue;
    }
    name.pop_back();
    for (const auto& one : left_) {
      if (one.first.compare(0, name.size(), name) == 0) names.push_back(one.first);
    }
  }
  return names;
}

void Translation::move(std::string_view package, KeyMap& entry) {
  for (const MovedParameter& row : moved_package(package).parameters) {
    if (row.key.empty()) report_without_counterpart(row);
    if (row.key.empty() || row.convert == nullptr) continue;
    for (const std::string& name : given_names(row.names)) {
      const auto value = find(name);
      KeyValue key = value ? row.convert(*value) : KeyValue();
      if (key.is_set() && find_key(entry, row.key) == nullptr) entry.emplace_back(row.key, std::move(key));
    }
  }
}

DropinSetup Translation::finish() {
  const std::vector<std::string_view> names(known_.begin(), known_.end());
  for (const auto& [name, value] : left_) {
    const std::string near(nearest_word(name, names));
    warn("parameter ~" + name + " is not known and has no effect" +
         (near.empty() ? "" : "; did you mean ~" + near + "?"));
  }
  return std::move(setup);
}

}  // namespace lidard
