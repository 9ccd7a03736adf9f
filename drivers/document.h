// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/config_error.h"

namespace lidard {

/// A full turn, rounded up. A larger angle in rad is rejected as degrees written by mistake.
constexpr double most_turn_rad = 6.284;

/// A value of a file as its parser made it: nothing, a text, a list or a mapping. A value may be used at
/// several locations of a file, but never inside of itself.
struct DocumentNode {
  enum class Kind : std::uint8_t { null, text, list, map };
  using Ptr = std::shared_ptr<const DocumentNode>;
  Kind kind = Kind::null;
  int line = 0, column = 0;  ///< from 1; 0: not known
  std::string text{};
  std::vector<Ptr> items{};                    ///< of a list
  std::vector<std::pair<Ptr, Ptr>> entries{};  ///< of a mapping: keys, which may be repeated, and values
};

/// Text from elsewhere on one line: control characters become question marks.
std::string printable(std::string text);

/// A value of a file with its location and path. Every reader throws ConfigError `file:line:column: what;
/// expected …`.
class Value {
 public:
  Value(DocumentNode::Ptr node, Location location, Location key_location, std::string path);

  /// Where the value begins.
  const Location& location() const { return location_; }
  /// Where its key begins, or the value if it has no key.
  const Location& key_location() const { return key_location_; }
  /// Its path from the top of the file, "sensors.roof.ip_port".
  const std::string& path() const { return path_; }
  /// Throws "location: path what; expected …".
  [[noreturn]] void fail(const std::string& what, const std::string& expected) const;
  /// The same at the key, if the value must not be there.
  [[noreturn]] void fail_at_key(const std::string& what, const std::string& expected) const;
  /// The value in a few printable characters, for messages.
  std::string quoted() const;

  bool is_null() const { return node_->kind == DocumentNode::Kind::null; }
  bool is_text() const { return node_->kind == DocumentNode::Kind::text; }
  bool is_list() const { return node_->kind == DocumentNode::Kind::list; }
  bool is_map() const { return node_->kind == DocumentNode::Kind::map; }
  /// A text; `expected` is for the message.
  std::string text(const std::string& expected = "a text") const;
  /// The same, but it may be empty.
  std::string text_or_empty() const;
  /// A finite number within the limits; `unit` is named in messages.
  double number(double lowest, double highest, std::string_view unit) const;
  /// A whole number within the limits.
  long integer(long lowest, long highest) const;
  bool boolean() const;
  bool is_boolean() const;
  /// The number that the text is; empty if it is none.
  std::optional<double> as_number() const;
  /// The elements of a list.
  std::vector<Value> items(const std::string& expected) const;
  /// A list of exactly `count` numbers.
  std::vector<double> numbers(std::size_t count, double limit, const char* unit) const;
  /// A list of names, or one text with names separated by blanks (as in ira_laser_tools).
  std::vector<Value> names(const std::string& expected) const;
  /// The entries of a mapping, which is empty for null, in the order of the file and with those that `<<`
  /// merges. Keys that are no names or repeated are mistakes; with `mistakes` only these entries are left
  /// out.
  std::vector<std::pair<std::string, Value>> entries(Mistakes* mistakes = nullptr) const;
  /// The texts in the value and in what it holds, down to `depth` levels.
  void add_texts(int depth, std::vector<std::string>& texts) const;

 private:
  Value element(DocumentNode::Ptr node, std::size_t index) const;
  /// The mapping, followed by those that it merges, nearest first; `count` limits nested ones.
  std::vector<DocumentNode::Ptr> with_merged(const DocumentNode::Ptr& map, std::size_t& count) const;

  DocumentNode::Ptr node_;
  Location location_;
  Location key_location_;
  std::string path_;
};

/// A mapping, with any keys.
class Mapping {
 public:
  using Entries = std::vector<std::pair<std::string, Value>>;
  /// A value of null is an empty mapping.
  explicit Mapping(const Value& value) : Mapping(value, value.entries(), true) {}
  /// Of the entries of `value` those that are left; not `is_complete`: mistakes were left out.
  Mapping(Value value, Entries entries, bool is_complete);

  const Value& self() const { return self_; }
  /// The value of `key`; empty if it is missing.
  std::optional<Value> find(std::string_view key) const;
  /// The same; throws `… is missing; expected` if it is missing.
  Value require(std::string_view key, const std::string& expected) const;
  /// Throws "location: path what; expected …" for a missing key; without a text if it may be one of the
  /// unknown keys.
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
  const Entries& entries() const { return entries_; }

 private:
  const Value* entry(std::string_view key) const;

  Value self_;
  Entries entries_;
  bool is_complete_;
};

/// The value of `key` or `key`_deg, or the mapping itself if both are missing; for messages.
Value value_at(const Value& mapping, std::string_view key);

/// Parses the text of a file to its outermost value; throws ConfigError. `file` is for messages.
using DocumentParser = Value (*)(const std::string& text, const std::string& file);

}  // namespace lidard
