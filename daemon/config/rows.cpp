// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/rows.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/config/values.h"

namespace lidard {
namespace {

/// "a, b or c".
std::string list_of(const std::vector<Word>& words) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i)
    list.append(i == 0 ? "" : i + 1 == words.size() ? " or " : ", ").append(words[i].text);
  return list;
}

/// Description of the key's valid values, for messages.
std::string expected_of(const Key& key) {
  if (!key.form.empty()) return std::string(key.form);
  return key.kind == KeyKind::word ? list_of(key.words) : "a text";
}

/// Normalizes YAML's words for true and false, .inf and .nan.
std::string read_word(const Value& value, const Key& key) {
  const std::string expected = expected_of(key);
  std::string text = value.text(expected);
  const auto is_known = [&](std::string_view word) {
    return std::any_of(key.words.begin(), key.words.end(),
                       [&](const Word& known) { return known.text == word; });
  };
  if (is_known(text)) return text;
  if (text.front() == '.' && is_known(text.substr(1))) return text.substr(1);
  if (is_known("true") && value.is_boolean()) return value.boolean() ? "true" : "false";
  value.fail("is " + value.quoted(), expected);
}

KeyValue read_plain(const Value& value, const Key& key) {
  switch (key.kind) {
    case KeyKind::flag:
      return value.boolean();
    case KeyKind::whole:
      return static_cast<double>(value.integer(std::lround(key.lowest), std::lround(key.highest)));
    case KeyKind::number:
    case KeyKind::angle:
      return value.number(key.lowest, key.highest, key.unit);
    case KeyKind::word:
      return read_word(value, key);
    case KeyKind::pose:
      return read_pose(value);
    default:
      break;
  }
  if (key.may_be_empty && value.text_or_empty().empty()) return std::string();
  if (key.kind == KeyKind::topic) return read_topic(value);
  if (key.kind == KeyKind::frame) return read_frame(value);
  return value.text(expected_of(key));
}

/// The value in a message: a number as parsed, others as written.
std::string quoted(const Value& value, const KeyValue& read) {
  const double* const number = std::get_if<double>(&read);
  return number == nullptr ? value.quoted() : number_text(*number);
}

KeyMap tree_of(const Pose& pose) {
  // Further digits are rounding errors of the conversion to a matrix and back.
  const auto rounded = [](double degrees) { return std::round(degrees * 1e9) / 1e9; };
  const Eigen::Vector3d rpy = (rpy_of(pose) * deg_per_rad).unaryExpr(rounded);
  const auto list = [](const Eigen::Vector3d& v) { return KeyList{v.x(), v.y(), v.z()}; };
  return {{"xyz", list(pose.translation())}, {"rpy_deg", list(rpy)}};
}

KeyValue shown_value(const Key& key) {
  if (key.kind == KeyKind::section) {
    KeyMap values = shown_values(key.inner);
    return values.empty() ? KeyValue() : KeyValue(std::move(values));
  }
  const auto* const text = std::get_if<std::string>(&key.value);
  const auto* const number = std::get_if<double>(&key.value);
  const bool is_empty = text != nullptr && text->empty() && !key.may_be_empty;
  return is_empty || (number != nullptr && !std::isfinite(*number)) ? KeyValue() : key.value;
}

}  // namespace

Mapping mapping_of(const Value& value, const Keys& keys, Mistakes& mistakes) {
  std::vector<std::string> names;
  for (const Key& key : keys) {
    names.emplace_back(key.name);
    if (key.kind == KeyKind::angle) names.push_back(names.back() + "_deg");
  }
  return known_mapping(value, {names.begin(), names.end()}, mistakes);
}

KeyValue read_value(const Value& value, const Key& key) {
  KeyValue read = read_plain(value, key);
  if (key.rejection == nullptr) return read;
  if (auto rejection = key.rejection(read)) {
    const std::size_t gap = rejection->what.find("{}");
    if (gap != std::string::npos) rejection->what.replace(gap, 2, quoted(value, read));
    value.fail(rejection->what, rejection->expected);
  }
  return read;
}

void read_key(const Mapping& yaml, const Key& key) {
  const auto value =
      key.required && key.can_be_read() ? yaml.require(key.name, expected_of(key)) : yaml.find(key.name);
  if (key.kind == KeyKind::angle) {
    const auto angle = yaml.angle(std::string(key.name));
    if (angle && key.can_be_read()) key.set(*angle);
  } else if (key.kind == KeyKind::section && value) {
    const bool is_brief = key.style == SectionStyle::brief && value->is_text();
    if (is_brief) return key.inner.front().set(read_value(*value, key.inner.front()));
    read_section(*value, key.inner);
  } else if (key.can_be_read() && value) {
    key.reader ? key.reader(*value) : key.set(read_value(*value, key));
  }
}

void read_keys(const Mapping& yaml, const Keys& keys, Mistakes& mistakes) {
  for (const Key& key : keys) mistakes.attempt([&] { read_key(yaml, key); });
}

Mapping read_section(const Value& value, const Keys& keys) {
  Mistakes mistakes;
  Mapping yaml = mapping_of(value, keys, mistakes);
  read_keys(yaml, keys, mistakes);
  mistakes.throw_if_any();
  return yaml;
}

KeyMap shown_values(const Keys& keys) {
  KeyMap map;
  for (const Key& key : keys) {
    KeyValue value = shown_value(key);
    if (key.applies && value.is_set()) map.emplace_back(key.name, std::move(value));
  }
  return map;
}

void write_tree(YAML::Emitter& yaml, const KeyValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) yaml << (*flag ? "true" : "false");
  if (const auto* number = std::get_if<double>(&value)) yaml << number_text(*number);
  if (const auto* text = std::get_if<std::string>(&value)) yaml << *text;
  if (const auto* list = std::get_if<KeyList>(&value)) {
    yaml << YAML::Flow << YAML::BeginSeq;
    for (const KeyValue& one : *list) write_tree(yaml, one);
    yaml << YAML::EndSeq;
  }
  if (const auto* pose = std::get_if<Pose>(&value)) write_tree(yaml << YAML::Flow, tree_of(*pose));
  if (const auto* map = std::get_if<KeyMap>(&value)) {
    yaml << YAML::BeginMap;
    for (const auto& [name, one] : *map) {
      write_tree(yaml << YAML::Key << name << YAML::Value, one);
    }
    yaml << YAML::EndMap;
  }
}

void write_keys(YAML::Emitter& yaml, const Keys& keys) {
  for (const Key& key : keys) {
    if (!key.applies) continue;
    const std::string name(key.name);
    KeyValue value = shown_value(key);
    if (!value.is_set() && !key.remark.empty())
      yaml << YAML::Newline << YAML::Comment(name + ": " + std::string(key.remark));
    if (!value.is_set() && key.remark.empty()) value = key.otherwise;
    if (!value.is_set()) continue;
    yaml << YAML::Key << name << YAML::Value;
    if (key.style == SectionStyle::one_line) yaml << YAML::Flow;
    write_tree(yaml, value);
  }
}

bool operator==(const KeyValue& a, const KeyValue& b) {
  const auto same = [&](const auto& one) {
    const auto& other = std::get<std::decay_t<decltype(one)>>(b);
    if constexpr (std::is_same_v<std::decay_t<decltype(one)>, Pose>)
      return one.matrix() == other.matrix();
    else
      return one == other;
  };
  return a.index() == b.index() && std::visit(same, a);
}

}  // namespace lidard
