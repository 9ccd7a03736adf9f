// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/document.h"

namespace lidard {

/// A full turn, rounded up. A larger angle in rad is rejected as degrees written by mistake.
constexpr double most_turn_rad = 6.284;

/// A mapping with known keys. Unknown and repeated keys are mistakes.
class Mapping {
 public:
  /// A value of null is an empty mapping. Without known keys any key is allowed. With `mistakes` only the
  /// unknown and repeated keys are left out, and it keeps their mistakes.
  Mapping(const Value& value, const std::vector<std::string_view>& known_keys, Mistakes* mistakes = nullptr);

  const Value& self() const { return self_; }
  /// The value of `key`; empty if it is missing.
  std::optional<Value> find(std::string_view key) const;
  /// The same; throws `… is missing; expected` if it is missing.
  Value require(std::string_view key, const std::string& expected) const;
  /// Throws "place: path what; expected …" for a missing key; without a text if it may be one of the unknown
  /// keys.
  [[noreturn]] void fail_missing(const std::string& what, const std::string& expected) const;
  /// False if there are unknown or repeated keys.
  bool is_complete() const { return is_complete_; }
  /// The value of `key` or `key`_deg, or the mapping itself if both are missing; for messages.
  const Value& where(std::string_view key) const;
  /// The same of the first of these keys that is present.
  const Value& where_first(std::initializer_list<std::string_view> keys) const;
  /// True if `key` or `key`_deg is present.
  bool has(std::string_view key) const { return &where(key) != &self_; }
  /// `key` in rad or `key`_deg in degrees.
  std::optional<double> angle(const std::string& key) const;
  /// `key` in rad or `key`_deg in degrees; `read` gets the value and the factor to rad.
  void in_rad(const std::string& key, const std::function<void(const Value&, double)>& read) const;
  /// The mapping at `key`, with any keys.
  Mapping inside(std::string_view key) const;
  /// The present keys with their values, in the order of the file.
  const std::vector<std::pair<std::string, Value>>& entries() const { return entries_; }

 private:
  const Value* entry(std::string_view key) const;

  Value self_;
  std::vector<std::pair<std::string, Value>> entries_;
  bool is_complete_ = true;
};

/// The value of `key` or `key`_deg, or the mapping itself if both are missing; for messages.
Value value_at(const Value& mapping, std::string_view key);

}  // namespace lidard
