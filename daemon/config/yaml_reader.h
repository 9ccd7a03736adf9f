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

#include "daemon/config/mistakes.h"

namespace lidard {

/// A full turn as people round it. What is more and given in rad is taken for degrees written by mistake.
constexpr double most_turn_rad = 6.284;

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
  bool is_boolean() const;
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

/// A YAML mapping whose keys are known beforehand. Unknown and doubled keys are mistakes. Keys with which
/// something was wrong are in doubt: to ask for one ends with AlreadyNoted.
class Mapping {
 public:
  /// A value of null is an empty mapping. Without known keys any key may be there.
  Mapping(const Value& value, std::vector<std::string_view> known_keys, Mistakes& mistakes);

  const Value& self() const { return self_; }
  Mistakes& mistakes() const { return mistakes_; }
  /// The value of `key`; empty if it is not there.
  std::optional<Value> find(std::string_view key) const;
  /// The same; throws `… is missing; expected` where it is not there.
  Value require(std::string_view key, const std::string& expected) const;
  /// The value of `key` or of `key`_deg or, where neither is there, the mapping itself: for messages.
  const Value& where(std::string_view key) const;
  /// True if `key` or `key`_deg is there.
  bool has(std::string_view key) const { return &where(key) != &self_; }
  /// `key` in rad or `key`_deg in degrees.
  std::optional<double> angle(const std::string& key) const;
  /// `key` in rad or `key`_deg in degrees; `read` gets the value and the factor that makes it rad.
  void in_rad(const std::string& key, const std::function<void(const Value&, double)>& read) const;
  /// The mapping that `key` holds, with any keys.
  Mapping inside(std::string_view key) const;
  /// The keys that are there, in the order of the file.
  const std::vector<std::string>& keys() const { return keys_; }
  /// Notes the mistake that `read` throws as one of `key`, which is in doubt from then on.
  template <class Read>
  void attempt(std::string_view key, const Read& read) const {
    mistakes_.attempt(self_.place(), [&] {
      const Value& value = where(key);
      if (!mistakes_.attempt(value.place(), read)) mistakes_.doubt(value.path());
    });
  }
  /// Notes the mistake in how keys go together that `check` throws; does nothing while keys are missing or
  /// unknown.
  template <class Check>
  void attempt_rule(const Check& check) const {
    if (!mistakes_.is_in_doubt(self_.path())) mistakes_.attempt(self_.place(), check);
  }

 private:
  Value self_;
  Mistakes& mistakes_;
  std::map<std::string, Value, std::less<>> values_;
  std::vector<std::string> keys_;
};

/// The named entries of a mapping whose keys the user chooses, in the order of the file. Keys that are no
/// plain text or come twice are refused; where `mistakes` are gathered, only they are left out.
std::vector<std::pair<std::string, Value>> named_entries(const Value& value, Mistakes* mistakes = nullptr);

/// Parses one YAML document; throws ConfigError for syntax errors and more than one document.
Value parse_yaml(const std::string& text, const std::string& file);

/// The content of a file of at most 1 MiB; throws ConfigError `path: what; expected …`, where `expected` says
/// what kind of file it should have been.
std::string read_file(const std::string& path, const std::string& expected);

}  // namespace lidard
