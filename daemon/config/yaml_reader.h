// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <yaml-cpp/yaml.h>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/config/config_error.h"

namespace lidard {

/// A full turn, rounded up. A larger angle in rad is rejected as degrees written by mistake.
constexpr double most_turn_rad = 6.284;

/// The replacement of a key of former versions, by its path like merged_scans.m.fuse; empty: there was no
/// such key.
std::string_view instead_of(const std::string& path);

/// The key that stands for one of other drivers, like sensors.a.hostname; empty: not known.
std::string_view ours_for(const std::string& path);

/// Text from elsewhere on one line: control characters become question marks.
std::string printable(std::string text);

/// A YAML value with its place and path. Every reader throws ConfigError `file:line:column: what; expected
/// …`.
class Value {
 public:
  Value(const YAML::Node& node, Place place, Place key_place, std::string path);

  const YAML::Node& node() const { return node_; }
  /// Where the value begins.
  const Place& place() const { return place_; }
  /// Where its key begins, or the value if it has no key.
  const Place& key_place() const { return key_place_; }
  /// Its path from the top of the file, "sensors.roof.ip_port".
  const std::string& path() const { return path_; }
  /// Throws "place: path what; expected …".
  [[noreturn]] void fail(const std::string& what, const std::string& expected) const;
  /// The same at the key, if the value must not be there.
  [[noreturn]] void fail_at_key(const std::string& what, const std::string& expected) const;
  /// The value in a few printable characters, for messages.
  std::string quoted() const;

  bool is_null() const { return node_.IsNull(); }
  /// A scalar's text; `expected` is for the message.
  std::string text(const std::string& expected = "a text") const;
  /// The same, but it may be empty.
  std::string text_or_empty() const;
  /// A finite number within the limits; `unit` is named in messages.
  double number(double lowest, double highest, const char* unit) const;
  /// A whole number within the limits.
  long integer(long lowest, long highest) const;
  bool boolean() const;
  bool is_boolean() const;
  /// The elements of a list.
  std::vector<Value> items(const std::string& expected) const;
  /// A list of exactly `count` numbers.
  std::vector<double> numbers(std::size_t count, double limit, const char* unit) const;
  /// A list of names, or one text with names separated by blanks (as in ira_laser_tools).
  std::vector<Value> names(const std::string& expected) const;

 private:
  YAML::Node node_;
  Place place_;
  Place key_place_;
  std::string path_;
};

/// A YAML mapping with known keys. Unknown and repeated keys are mistakes.
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

/// The entries of a mapping with names chosen by the user, in the order of the file. Keys that are not plain
/// text or repeated are mistakes; with `mistakes` only these entries are left out.
std::vector<std::pair<std::string, Value>> named_entries(const Value& value, Mistakes* mistakes = nullptr);

/// The value of `key` or `key`_deg, or the mapping itself if both are missing; for messages.
Value value_at(const Value& mapping, std::string_view key);

/// Parses one YAML document; throws ConfigError for syntax errors and more than one document.
Value parse_yaml(const std::string& text, const std::string& file);

/// The content of a file of at most 1 MiB; throws ConfigError `path: what; expected …` with the expected kind
/// of file.
std::string read_file(const std::string& path, const std::string& expected);

}  // namespace lidard
