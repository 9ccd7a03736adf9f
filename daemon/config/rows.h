// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/yaml_reader.h"
#include "drivers/key.h"

namespace lidard {

/// Description of the key's valid values, for messages: "a number from 0 to 9 m".
std::string expected_of(const Key& key);
/// The value of `key` in `yaml`, checked against the row; empty if it is missing.
std::optional<KeyValue> read_value(const Mapping& yaml, const Key& key);
/// Reads a single value.
KeyValue read_value(const Value& value, const Key& key);
void write_tree(YAML::Emitter& yaml, const KeyValue& value);
/// Writes name and value; nothing for "not set".
void write_value(YAML::Emitter& yaml, std::string_view name, const KeyValue& value);
bool operator==(const KeyValue& a, const KeyValue& b);
/// Writes a comment with the behaviour without an optional key.
void write_remark(YAML::Emitter& yaml, const Key& key);

/// Adds the names of keys in a file, without duplicates.
template <class Owner>
void add_names(const Keys<Owner>& keys, std::vector<std::string>& names) {
  for (const auto& key : keys) {
    if (std::find(names.begin(), names.end(), key.name) != names.end()) continue;
    names.emplace_back(key.name);
    if (key.kind == KeyKind::angle) names.push_back(std::string(key.name) + "_deg");
  }
}
template <class Owner>
Mapping mapping_of(const Value& value, const Keys<Owner>& keys, Mistakes& mistakes) {
  std::vector<std::string> names;
  add_names(keys, names);
  return {value, {names.begin(), names.end()}, &mistakes};
}

template <class Owner>
void read_keys(const Mapping& yaml, const Keys<Owner>& keys, Owner& owner, Mistakes& mistakes);

/// Reads a mapping of these keys.
template <class Owner>
void read_mapping(const Value& value, const Keys<Owner>& keys, Owner& owner) {
  Mistakes mistakes;
  read_keys(mapping_of(value, keys, mistakes), keys, owner, mistakes);
  mistakes.throw_if_any();
}

/// Reads the keys below `key`.
template <class Owner>
void read_section(const Value& value, const KeyOf<Owner>& key, Owner& owner) {
  if (key.short_form && value.node().IsScalar()) {
    const auto& first = key.inner.front();
    first.set(owner, read_value(value, first));
  } else {
    read_mapping(value, key.inner, owner);
  }
}

/// Reads the key from `yaml`, if present, unless its section reads it.
template <class Owner>
void read_key(const Mapping& yaml, const KeyOf<Owner>& key, Owner& owner) {
  if (key.kind == KeyKind::special) return;
  if (key.kind == KeyKind::section) {
    if (const auto value = yaml.find(key.name)) read_section(*value, key, owner);
    return;
  }
  Key limited = key;
  if (key.most) limited.highest = key.most(owner);
  if (const auto value = read_value(yaml, limited); value && key.set) key.set(owner, *value);
}
/// Reads the keys; a mistake in one is kept in `mistakes` and leaves `owner` unchanged.
template <class Owner>
void read_keys(const Mapping& yaml, const Keys<Owner>& keys, Owner& owner, Mistakes& mistakes) {
  for (const auto& key : keys) {
    // A limit that depends on other keys is not known while one of them is wrong.
    if (!key.most || !mistakes.any()) mistakes.attempt([&] { read_key(yaml, key, owner); });
  }
}

/// Writes every key with its value, or the behaviour without a value.
template <class Owner>
void write_keys(YAML::Emitter& yaml, const Keys<Owner>& keys, const Owner& owner) {
  for (const auto& key : keys) {
    if (key.shown && !key.shown(owner)) continue;
    const KeyMap inside = shown_values(key.inner, owner);
    const KeyValue value = shown_value(key, owner);
    if (std::any_of(inside.begin(), inside.end(), [](const auto& one) { return one.second.is_set(); })) {
      yaml << YAML::Key << std::string(key.name) << YAML::Value;
      if (key.flow) yaml << YAML::Flow;
      yaml << YAML::BeginMap;
      write_keys(yaml, key.inner, owner);
      yaml << YAML::EndMap;
    } else if (!value.is_set() && !key.remark.empty()) {
      write_remark(yaml, key);
    } else {
      write_value(yaml, key.name, value.is_set() ? value : key.otherwise);
    }
  }
}

/// True if `a` and `b` have the same values of all keys.
template <class Owner>
bool same_keys(const Keys<Owner>& keys, const Owner& a, const Owner& b) {
  return std::all_of(keys.begin(), keys.end(), [&](const KeyOf<Owner>& key) {
    return shown_value(key, a) == shown_value(key, b) && same_keys(key.inner, a, b);
  });
}

}  // namespace lidard
