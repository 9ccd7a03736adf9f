// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/yaml_reader.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "core/base/angle.h"
#include "core/base/nearest.h"
#include "core/base/number_text.h"
#include "daemon/config/config.h"

namespace lidard {
namespace {

constexpr std::size_t longest_quote = 40;

std::string shorten(const std::string& text) {
  return printable(text.substr(0, longest_quote)) + (text.size() > longest_quote ? "…" : "");
}

/// Parses the complete text as a number, independent of the locale.
std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<bool> truth_of(std::string_view word) {
  for (const char* yes : {"true", "True", "TRUE", "yes", "Yes", "on", "On"}) {
    if (word == yes) return true;
  }
  for (const char* no : {"false", "False", "FALSE", "no", "No", "off", "Off"}) {
    if (word == no) return false;
  }
  return std::nullopt;
}

[[noreturn]] void fail_at(const Place& place, const std::string& what, const std::string& expected) {
  throw ConfigError(place, what + "; expected " + expected);
}

Place place_of(const YAML::Mark& mark, const Place& otherwise) {
  if (mark.is_null()) return otherwise;
  return {otherwise.file, mark.line + 1, mark.column + 1};
}

Value element(const Value& parent, const YAML::Node& node, std::size_t index) {
  const Place place = place_of(node.Mark(), parent.place());
  return {node, place, place, parent.path() + "[" + std::to_string(index) + "]"};
}

/// Rejects keys that are not plain text or repeated; `seen` has the earlier keys.
void check_key(const YAML::Node& key, const Place& place, const Value& parent, const std::string& prefix,
               std::map<std::string, Place>& seen) {
  if (!key.IsScalar() || key.Scalar().empty())
    fail_at(place, "a key of " + (prefix.empty() ? "the file" : parent.path()) + " is not a name",
            "a name before the colon");
  const auto [earlier, is_new] = seen.emplace(key.Scalar(), place);
  if (!is_new)
    fail_at(place,
            prefix + shorten(key.Scalar()) + " is given twice, first in line " +
                std::to_string(earlier->second.line),
            "it once");
}

/// `<<: *anchor`, or a list of them: https://yaml.org/type/merge.html
template <class Entry>
bool is_merge(const Entry& entry) {
  return entry.first.IsScalar() && entry.first.Scalar() == "<<";
}

/// The mapping, followed by those that it merges, nearest first. `count` limits the expansion of nested
/// anchors.
std::vector<YAML::Node> with_merged(const Value& value, const YAML::Node& map, std::size_t& count) {
  constexpr std::size_t most = 100;
  const std::string expected = "an alias of a mapping, like `<<: *scanner`, or a list of them";
  std::vector<YAML::Node> all{map};
  for (const auto& entry : map) {
    if (!is_merge(entry)) continue;
    std::vector<YAML::Node> sources;
    if (!entry.second.IsSequence()) sources.push_back(entry.second);
    for (const auto& one : entry.second) {
      if (entry.second.IsSequence()) sources.push_back(one);
    }
    for (const YAML::Node& source : sources) {
      const Place place = place_of(entry.first.Mark(), value.place());
      const std::string key = (value.path().empty() ? "" : value.path() + ".") + "<<";
      if (!source.IsMap()) fail_at(place, key + " merges what is no mapping", expected);
      if (++count > most) fail_at(place, key + " merges more than 100 mappings", expected);
      for (YAML::Node& inner : with_merged(value, source, count)) all.push_back(inner);
    }
  }
  return all;
}

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
    fail_at(entry.key_place(), entry.path() + " is a key of former versions", std::string(instead));
  std::string_view near = ours_for(entry.path());
  if (near.empty()) near = nearest_word(key, known_keys);
  fail_at(entry.key_place(), "unknown key " + entry.path(),
          near.empty() ? comma_list(known_keys) : std::string(near));
}

// A configuration is a few kB, a calibration some 100 kB.
constexpr std::size_t largest_file = 1U << 20U;  // bytes

}  // namespace

std::string printable(std::string text) {
  for (char& c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) c = '?';
  }
  return text;
}

Value::Value(const YAML::Node& node, Place place, Place key_place, std::string path)
    : node_(node), place_(std::move(place)), key_place_(std::move(key_place)), path_(std::move(path)) {}

void Value::fail(const std::string& what, const std::string& expected) const {
  fail_at(place_, (path_.empty() ? "the file" : path_) + " " + what, expected);
}

void Value::fail_at_key(const std::string& what, const std::string& expected) const {
  fail_at(key_place_, (path_.empty() ? "the file" : path_) + " " + what, expected);
}

std::string Value::quoted() const {
  if (node_.IsScalar()) return '"' + shorten(node_.Scalar()) + '"';
  if (node_.IsSequence()) return "a list";
  return node_.IsMap() ? "a mapping" : "empty";
}

std::string Value::text(const std::string& expected) const {
  if (!node_.IsScalar() || node_.Scalar().empty())
    fail("is " + (node_.IsScalar() ? "empty" : quoted()), expected);
  return node_.Scalar();
}

std::string Value::text_or_empty() const {
  if (is_null()) return {};
  return node_.IsScalar() && node_.Scalar().empty() ? std::string() : text();
}

double Value::number(double lowest, double highest, const char* unit) const {
  const std::string expected = "a number from " + number_text(lowest) + " to " + number_text(highest) +
                               (*unit == '\0' ? "" : " ") + unit;
  const auto number = node_.IsScalar() ? parse_number(node_.Scalar()) : std::nullopt;
  if (!number) fail("is " + quoted(), expected);
  if (!std::isfinite(*number)) fail("is not finite", expected);
  if (*number < lowest || *number > highest) fail("is " + number_text(*number), expected);
  return *number;
}

long Value::integer(long lowest, long highest) const {
  const std::string expected =
      "a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest);
  const auto number = node_.IsScalar() ? parse_number(node_.Scalar()) : std::nullopt;
  if (!number || !(std::abs(*number) < 1e15) || *number != std::floor(*number))
    fail("is " + quoted(), expected);
  const auto whole = static_cast<long>(*number);
  if (whole < lowest || whole > highest) fail("is " + std::to_string(whole), expected);
  return whole;
}

bool Value::is_boolean() const { return node_.IsScalar() && truth_of(node_.Scalar()).has_value(); }

bool Value::boolean() const {
  if (!is_boolean()) fail("is " + quoted(), "true or false");
  return *truth_of(node_.Scalar());
}

std::vector<Value> Value::items(const std::string& expected) const {
  if (!node_.IsSequence()) fail("is " + quoted(), expected);
  std::vector<Value> values;
  for (const auto& node : node_) values.push_back(element(*this, node, values.size()));
  return values;
}

std::vector<double> Value::numbers(std::size_t count, double limit, const char* unit) const {
  const std::string expected = "a list of " + std::to_string(count) + " numbers in " + unit;
  const std::vector<Value> values = items(expected);
  if (values.size() != count) fail("has " + std::to_string(values.size()) + " elements", expected);
  std::vector<double> list;
  list.reserve(count);
  for (const Value& value : values) list.push_back(value.number(-limit, limit, unit));
  return list;
}

std::vector<Value> Value::names(const std::string& expected) const {
  if (is_null()) return {};
  if (node_.IsSequence()) return items(expected);
  const std::string all = node_.IsScalar() ? node_.Scalar() : text(expected);
  std::vector<Value> values;
  const char* blanks = " \t\r\n";
  for (std::size_t begin = all.find_first_not_of(blanks); begin != std::string::npos;) {
    const std::size_t end = std::min(all.find_first_of(blanks, begin), all.size());
    values.push_back(element(*this, YAML::Node(all.substr(begin, end - begin)), values.size()));
    begin = all.find_first_not_of(blanks, end);
  }
  return values;
}

Mapping::Mapping(const Value& value, const std::vector<std::string_view>& known_keys, Mistakes* mistakes)
    : self_(value) {
  Mistakes own;
  Mistakes& all = mistakes != nullptr ? *mistakes : own;
  for (auto& one : named_entries(value, &all)) {
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
    angle = value.number(rad ? -most_turn_rad : -400, rad ? most_turn_rad : 400, unit.c_str()) * to_rad;
  });
  return angle;
}

std::vector<std::pair<std::string, Value>> named_entries(const Value& value, Mistakes* mistakes) {
  std::vector<std::pair<std::string, Value>> entries;
  if (value.is_null()) return entries;
  if (!value.node().IsMap()) value.fail("is " + value.quoted(), "a mapping (`key: value` lines)");
  const std::string prefix = value.path().empty() ? "" : value.path() + ".";
  std::map<std::string, Place> seen;
  std::size_t merged = 0;
  Mistakes own;
  Mistakes& all = mistakes != nullptr ? *mistakes : own;
  for (const YAML::Node& map : with_merged(value, value.node(), merged)) {
    // Nearer keys override merged ones; a repeated key is a mistake only within one mapping.
    const std::map<std::string, Place> nearer = seen;
    for (const auto& entry : map) {
      if (is_merge(entry) || (entry.first.IsScalar() && nearer.count(entry.first.Scalar()) != 0)) continue;
      const Place key_place = place_of(entry.first.Mark(), value.key_place());
      if (!all.attempt([&] { check_key(entry.first, key_place, value, prefix, seen); })) continue;
      // The parser gives a missing value the place of the next token.
      const Place place = entry.second.IsNull() ? key_place : place_of(entry.second.Mark(), key_place);
      const std::string& key = entry.first.Scalar();
      entries.emplace_back(key, Value(entry.second, place, key_place, prefix + shorten(key)));
    }
  }
  own.throw_if_any();
  return entries;
}

Value value_at(const Value& mapping, std::string_view key) { return Mapping(mapping, {}).where(key); }

std::string read_file(const std::string& path, const std::string& expected) {
  // One that waits for a writer would hold up a reload, and with it the end of the daemon.
  std::error_code ignored;
  if (std::filesystem::is_fifo(path, ignored) && path.rfind("/dev/", 0) != 0)
    throw ConfigError(path + ": is a pipe, not a file; expected " + expected);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text;
  if (file) {
    text.resize(largest_file + 1);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
  }
  if (!file.is_open() || file.bad() || (file.fail() && !file.eof()))
    throw ConfigError(path + ": cannot be read: " + std::strerror(errno != 0 ? errno : EIO) + "; expected " +
                      expected);
  if (text.size() > largest_file) throw ConfigError(path + ": is larger than 1 MiB; expected " + expected);
  return text;
}

}  // namespace lidard
