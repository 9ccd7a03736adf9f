// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <yaml-cpp/yaml.h>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/time.h"

namespace lidard {

/// Where something stands in a file; line and column count from 1.
struct Place {
  std::string file;
  int line = 1;
  int column = 1;

  /// "file:line:column".
  std::string to_string() const;
};

/// One YAML value that knows where it stands and what it is called. Every reader throws ConfigError
/// `file:line:column: what; expected …`.
class Value {
 public:
  Value(YAML::Node node, Place place, Place key_place, std::string path);

  const YAML::Node& node() const { return node_; }
  /// Where the value begins.
  const Place& place() const { return place_; }
  /// Where its key begins; that of the value where it has none.
  const Place& key_place() const { return key_place_; }
  /// Its name from the top of the file, "sensors.roof.ip_port".
  const std::string& path() const { return path_; }
  /// Throws "place: path what; expected …".
  [[noreturn]] void fail(const std::string& what, const std::string& expected) const;
  /// The same at the key, for what is wrong with the presence of the value.
  [[noreturn]] void fail_at_key(const std::string& what, const std::string& expected) const;
  /// The value in a few printable characters, for messages.
  std::string quoted() const;

  bool is_null() const { return node_.IsNull(); }
  /// A scalar's text; `expected` says what it should have been.
  std::string text(const std::string& expected = "a text") const;
  /// The same, but it may be empty.
  std::string text_or_empty() const;
  /// A finite number within the limits; `unit` is named in messages.
  double number(double lowest, double highest, const char* unit) const;
  /// A whole number within the limits.
  long integer(long lowest, long highest) const;
  bool boolean() const;
  /// Seconds.
  Span duration(double lowest_s, double highest_s) const;
  /// The elements of a list.
  std::vector<Value> items(const std::string& expected) const;
  /// A list of exactly `count` numbers.
  std::vector<double> numbers(std::size_t count, double limit, const char* unit) const;
  /// A list of names, or one text with blanks between them (the way of ira_laser_tools).
  std::vector<Value> names(const std::string& expected) const;

 private:
  YAML::Node node_;
  Place place_;
  Place key_place_;
  std::string path_;
};

/// A YAML mapping whose keys are known beforehand. The constructor refuses unknown and doubled keys;
/// `finish()` refuses those that nobody read.
class Mapping {
 public:
  /// A value of null is an empty mapping.
  Mapping(const Value& value, std::vector<std::string_view> known_keys);

  const Value& self() const { return self_; }
  /// The value of `key`, which must be one of the known ones; empty if it is not there.
  std::optional<Value> find(std::string_view key);
  /// The same; throws `… is missing; expected` where it is not there.
  Value require(std::string_view key, const std::string& expected);
  /// The value of `key` or, where it is not there, the mapping itself: for messages.
  const Value& where(std::string_view key) const;
  bool has(std::string_view key) const { return values_.count(std::string(key)) != 0; }
  /// `key` in rad or `key`_deg in degrees.
  std::optional<double> angle(const std::string& key);
  /// `key` in rad or `key`_deg in degrees; `read` gets the value and the factor that makes it rad.
  void in_rad(const std::string& key, const std::function<void(const Value&, double)>& read);
  /// Throws for every key that is there and was not read: "path.key `why`; expected …".
  void finish(const std::function<std::pair<std::string, std::string>(const std::string& key)>& why) const;

 private:
  Value self_;
  std::vector<std::string_view> known_;
  std::map<std::string, Value, std::less<>> values_;
  std::vector<std::string> unread_;  // in the order of the file
};

/// The named entries of a mapping whose keys the user chooses, in the order of the file.
std::vector<std::pair<std::string, Value>> named_entries(const Value& value);

/// Parses one YAML document; throws ConfigError for syntax errors and more than one document.
Value parse_yaml(const std::string& text, const std::string& file);

}  // namespace lidard
