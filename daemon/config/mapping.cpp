// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/mapping.h"

#include <algorithm>

#include "core/base/angle.h"
#include "core/base/nearest.h"
#include "daemon/config/removed_keys.h"

namespace lidard {
namespace {

std::string comma_list(const std::vector<std::string_view>& words) {
  std::string list;
  for (auto word = words.begin(); word != words.end(); ++word) {
    if (std::find(words.begin(), word, *word) == word) list.append(list.empty() ? "" : ", ").append(*word);
  }
  return list.find(',') == std::string::npos ? list : "one of " + list;
}

[[noreturn]] void fail_unknown(const std::string& key, const Value& entry,
                               const std::vector<std::string_view>& known_keys) {
  if (const std::string_view instead = instead_of(entry.path()); !instead.empty())
    entry.fail_at_key("is a key of former versions", std::string(instead));
  std::string_view near = ours_for(entry.path());
  if (near.empty()) near = nearest_word(key, known_keys);
  throw ConfigError(entry.key_place(), "unknown key " + entry.path() + "; expected " +
                                           (near.empty() ? comma_list(known_keys) : std::string(near)));
}

}  // namespace

Mapping::Mapping(const Value& value, const std::vector<std::string_view>& known_keys, Mistakes* mistakes)
    : self_(value) {
  Mistakes own;
  Mistakes& all = mistakes != nullptr ? *mistakes : own;
  for (auto& one : value.entries(&all)) {
    const auto& [key, entry] = one;
    if (known_keys.empty() || std::find(known_keys.begin(), known_keys.end(), key) != known_keys.end())
      entries_.push_back(std::move(one));
    else
      all.attempt([&, &key = key, &entry = entry] { fail_unknown(key, entry, known_keys); });
  }
  is_complete_ = !all.any();
  own.throw_if_any();
}

const Value* Mapping::entry(std::string_view key) const {
  const auto found =
      std::find_if(entries_.begin(), entries_.end(), [&](const auto& one) { return one.first == key; });
  return found == entries_.end() ? nullptr : &found->second;
}

std::optional<Value> Mapping::find(std::string_view key) const {
  const Value* const value = entry(key);
  return value == nullptr ? std::nullopt : std::optional<Value>(*value);
}

Value Mapping::require(std::string_view key, const std::string& expected) const {
  const Value* const value = entry(key);
  if (value == nullptr) fail_missing("has no " + std::string(key), expected);
  return *value;
}

void Mapping::fail_missing(const std::string& what, const std::string& expected) const {
  if (!is_complete_) throw ConfigError(std::vector<ConfigError::Mistake>());
  self_.fail_at_key(what, expected);
}

const Value& Mapping::where(std::string_view key) const {
  const Value* value = entry(key);
  if (value == nullptr) value = entry(std::string(key) + "_deg");
  return value == nullptr ? self_ : *value;
}

const Value& Mapping::where_first(std::initializer_list<std::string_view> keys) const {
  const auto present = std::find_if(keys.begin(), keys.end(), [&](std::string_view key) { return has(key); });
  return present == keys.end() ? self_ : where(*present);
}

Mapping Mapping::inside(std::string_view key) const { return {find(key).value(), {}}; }

void Mapping::in_rad(const std::string& key, const std::function<void(const Value&, double)>& read) const {
  const auto rad = find(key);
  const auto deg = find(key + "_deg");
  if (rad && deg) deg->fail_at_key("is given beside " + key, "one of the two");
  if (rad) read(*rad, 1);
  if (deg) read(*deg, rad_per_deg);
}

std::optional<double> Mapping::angle(const std::string& key) const {
  std::optional<double> angle;
  in_rad(key, [&](const Value& value, double to_rad) {
    const bool rad = to_rad == 1;
    const std::string unit = rad ? "rad (degrees: " + key + "_deg)" : "degrees";
    angle = value.number(rad ? -most_turn_rad : -400, rad ? most_turn_rad : 400, unit) * to_rad;
  });
  return angle;
}

Value value_at(const Value& mapping, std::string_view key) { return Mapping(mapping, {}).where(key); }

}  // namespace lidard
