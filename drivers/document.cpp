// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/document.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "core/base/angle.h"
#include "core/base/number_text.h"

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

[[noreturn]] void fail_at(const Location& location, const std::string& what, const std::string& expected) {
  throw ConfigError(location, what + "; expected " + expected);
}

Location location_of(const DocumentNode& node, const Location& otherwise) {
  return node.line == 0 ? otherwise : Location{otherwise.file, node.line, node.column};
}

bool is_name(const DocumentNode& key) { return key.kind == DocumentNode::Kind::text && !key.text.empty(); }

/// Rejects keys that are not plain text or repeated; `seen` has the earlier keys.
void check_key(const DocumentNode& key, const Location& location, const Value& parent,
               const std::string& prefix, std::map<std::string, Location>& seen) {
  if (!is_name(key))
    fail_at(location, "a key of " + (prefix.empty() ? "the file" : parent.path()) + " is not a name",
            "a name before the colon");
  const auto [earlier, is_new] = seen.emplace(key.text, location);
  if (!is_new)
    fail_at(
        location,
        prefix + shorten(key.text) + " is given twice, first in line " + std::to_string(earlier->second.line),
        "it once");
}

/// `<<: *anchor`, or a list of them: https://yaml.org/type/merge.html
bool is_merge(const DocumentNode& key) { return is_name(key) && key.text == "<<"; }

}  // namespace

std::string printable(std::string text) {
  for (char& c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) c = '?';
  }
  return text;
}

Value::Value(DocumentNode::Ptr node, Location location, Location key_location, std::string path)
    : node_(std::move(node)),
      location_(std::move(location)),
      key_location_(std::move(key_location)),
      path_(std::move(path)) {}

void Value::fail(const std::string& what, const std::string& expected) const {
  fail_at(location_, (path_.empty() ? "the file" : path_) + " " + what, expected);
}

void Value::fail_at_key(const std::string& what, const std::string& expected) const {
  fail_at(key_location_, (path_.empty() ? "the file" : path_) + " " + what, expected);
}

std::string Value::quoted() const {
  if (is_text()) return '"' + shorten(node_->text) + '"';
  if (is_list()) return "a list";
  return is_map() ? "a mapping" : "empty";
}

std::string Value::text(const std::string& expected) const {
  if (!is_text() || node_->text.empty()) fail("is " + (is_text() ? "empty" : quoted()), expected);
  return node_->text;
}

std::string Value::text_or_empty() const {
  if (is_null()) return {};
  return is_text() && node_->text.empty() ? std::string() : text();
}

std::optional<double> Value::as_number() const {
  return is_text() ? parse_number(node_->text) : std::nullopt;
}

double Value::number(double lowest, double highest, std::string_view unit) const {
  const std::string expected = "a number from " + number_text(lowest) + " to " + number_text(highest) +
                               (unit.empty() ? "" : " ") + std::string(unit);
  const auto number = as_number();
  if (!number) fail("is " + quoted(), expected);
  if (!std::isfinite(*number)) fail("is not finite", expected);
  if (*number < lowest || *number > highest) fail("is " + number_text(*number), expected);
  return *number;
}

long Value::integer(long lowest, long highest) const {
  const std::string expected =
      "a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest);
  const auto number = as_number();
  if (!number || !(std::abs(*number) < 1e15) || *number != std::floor(*number))
    fail("is " + quoted(), expected);
  const auto whole = static_cast<long>(*number);
  if (whole < lowest || whole > highest) fail("is " + std::to_string(whole), expected);
  return whole;
}

bool Value::is_boolean() const { return is_text() && truth_of(node_->text).has_value(); }

bool Value::boolean() const {
  if (!is_boolean()) fail("is " + quoted(), "true or false");
  return *truth_of(node_->text);
}

std::vector<Value> Value::items(const std::string& expected) const {
  if (!is_list()) fail("is " + quoted(), expected);
  std::vector<Value> values;
  for (const auto& item : node_->items) values.push_back(element(item, values.size()));
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
  if (is_list()) return items(expected);
  const std::string all = is_text() ? node_->text : text(expected);
  std::vector<Value> values;
  const char* blanks = " \t\r\n";
  for (std::size_t begin = all.find_first_not_of(blanks); begin != std::string::npos;) {
    const std::size_t end = std::min(all.find_first_of(blanks, begin), all.size());
    DocumentNode word{DocumentNode::Kind::text, 0, 0, all.substr(begin, end - begin)};
    values.push_back(element(std::make_shared<DocumentNode>(std::move(word)), values.size()));
    begin = all.find_first_not_of(blanks, end);
  }
  return values;
}

Value Value::element(DocumentNode::Ptr node, std::size_t index) const {
  const Location location = location_of(*node, location_);
  return {std::move(node), location, location, path_ + "[" + std::to_string(index) + "]"};
}

std::vector<DocumentNode::Ptr> Value::with_merged(const DocumentNode::Ptr& map, std::size_t& count) const {
  constexpr std::size_t most = 100;
  const std::string expected = "an alias of a mapping, like `<<: *scanner`, or a list of them";
  std::vector<DocumentNode::Ptr> all{map};
  for (const auto& [key, value] : map->entries) {
    if (!is_merge(*key)) continue;
    const bool is_list = value->kind == DocumentNode::Kind::list;
    for (const auto& source : is_list ? value->items : std::vector<DocumentNode::Ptr>{value}) {
      const Location location = location_of(*key, location_);
      const std::string path = (path_.empty() ? "" : path_ + ".") + "<<";
      if (source->kind != DocumentNode::Kind::map)
        fail_at(location, path + " merges what is no mapping", expected);
      if (++count > most) fail_at(location, path + " merges more than 100 mappings", expected);
      for (auto& inner : with_merged(source, count)) all.push_back(std::move(inner));
    }
  }
  return all;
}

std::vector<std::pair<std::string, Value>> Value::entries(Mistakes* mistakes) const {
  std::vector<std::pair<std::string, Value>> entries;
  if (is_null()) return entries;
  if (!is_map()) fail("is " + quoted(), "a mapping (`key: value` lines)");
  const std::string prefix = path_.empty() ? "" : path_ + ".";
  std::map<std::string, Location> seen;
  std::size_t merged = 0;
  Mistakes own;
  Mistakes& all = mistakes != nullptr ? *mistakes : own;
  for (const auto& map : with_merged(node_, merged)) {
    // Nearer keys override merged ones; a repeated key is a mistake only within one mapping.
    const std::map<std::string, Location> nearer = seen;
    for (const auto& entry : map->entries) {
      const DocumentNode& key = *entry.first;
      const bool is_text = key.kind == DocumentNode::Kind::text;
      if (is_merge(key) || (is_text && nearer.count(key.text) != 0)) continue;
      const Location key_location = location_of(key, key_location_);
      if (!all.attempt([&] { check_key(key, key_location, *this, prefix, seen); })) continue;
      // The parser gives a missing value the location of the next token.
      const bool is_missing = entry.second->kind == DocumentNode::Kind::null;
      const Location location = is_missing ? key_location : location_of(*entry.second, key_location);
      entries.emplace_back(key.text, Value(entry.second, location, key_location, prefix + shorten(key.text)));
    }
  }
  own.throw_if_any();
  return entries;
}

void Value::add_texts(int depth, std::vector<std::string>& texts) const {
  if (is_text()) texts.push_back(node_->text);
  if (depth == 0) return;
  const auto add = [&](const DocumentNode::Ptr& node) {
    Value(node, {}, {}, {}).add_texts(depth - 1, texts);
  };
  for (const auto& item : node_->items) add(item);
  for (const auto& entry : node_->entries) add(entry.second);
}

Mapping::Mapping(Value value, Entries entries, bool is_complete)
    : self_(std::move(value)), entries_(std::move(entries)), is_complete_(is_complete) {}

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

Mapping Mapping::inside(std::string_view key) const { return Mapping(find(key).value()); }

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

Value value_at(const Value& mapping, std::string_view key) { return Mapping(mapping).where(key); }

}  // namespace lidard
