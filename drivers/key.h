// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/number_text.h"
#include "core/base/pose.h"
#include "core/base/time.h"
#include "drivers/address.h"

namespace lidard {

struct KeyValue;
using KeyList = std::vector<KeyValue>;
using KeyMap = std::vector<std::pair<std::string, KeyValue>>;

/// A value of a key: not set, a truth value, a number in the key's unit, a text, a pose, or several of them.
struct KeyValue : std::variant<std::monostate, bool, double, std::string, Pose, KeyList, KeyMap> {
  using variant::variant;
  bool is_set() const { return index() != 0; }
};

/// Kind of a key's value. `section`: nested keys. `special`: parsed by the enclosing section.
enum class KeyKind : std::uint8_t {
  flag,
  whole,
  number,
  angle,
  word,
  text,
  topic,
  frame,
  pose,
  section,
  special
};

/// Why a value is rejected ({} stands for the value as written), and what is expected.
struct Rejection {
  std::string what, expected;
};

/// Properties of a configuration key, whatever structure it belongs to.
struct Key {
  std::string_view name;
  KeyKind kind = KeyKind::special;
  std::string_view meaning;  ///< one line, for the reference
  double lowest = 0, highest = 0;
  std::string_view unit;                ///< of a number; an angle is in rad, or in degrees as `name`_deg
  std::vector<std::string_view> words;  ///< allowed
  std::string_view form;                ///< form of a text or a special value, for messages
  std::string_view preset;              ///< description of a default that depends on other things
  std::string_view remark;              ///< the behaviour while the key is not set
  KeyValue otherwise;                   ///< the value that means "not set", if there is one
  bool required = false;
  bool may_be_empty = false;  ///< an empty text means none
  bool short_form = false;    ///< a section: a single value stands for its first key
  bool flow = false;          ///< a section is written in one line
  bool live = false;          ///< it can be changed while the daemon runs
  std::optional<Rejection> (*rejection)(const KeyValue& value) = nullptr;  ///< a further check of a value
};

inline KeyValue key_value(bool value) { return value; }
template <class Number, std::enable_if_t<std::is_arithmetic_v<Number>, int> = 0>
KeyValue key_value(Number value) {
  return static_cast<double>(value);
}
/// The division gives the shortest text of a decimal fraction.
inline KeyValue key_value(Span value) { return static_cast<double>(value.count()) / 1e9; }
inline KeyValue key_value(const std::string& value) { return value; }
inline KeyValue key_value(const std::vector<std::string>& value) {
  return KeyList(value.begin(), value.end());
}
inline KeyValue key_value(const Pose& value) { return value; }
inline KeyValue key_value(const IpAddress& value) { return value.to_string(); }
template <class T>
KeyValue key_value(const std::optional<T>& value) {
  return value ? key_value(*value) : KeyValue();
}

/// Stores a value in a member. `value` must be of the right kind (a valid address for an IpAddress).
template <class T>
void store_value(const KeyValue& value, T& member) {
  if constexpr (std::is_same_v<T, Span>)
    member = span_from_seconds(std::get<double>(value));
  else if constexpr (std::is_same_v<T, IpAddress>)
    member = IpAddress::parse(std::get<std::string>(value)).value_or(IpAddress());
  else if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>)
    member = static_cast<T>(std::get<double>(value));
  else
    member = std::get<T>(value);
}
template <class T>
void store_value(const KeyValue& value, std::optional<T>& member) {
  member.reset();
  if (value.is_set()) store_value(value, member.emplace());
}

/// A key of the structure `Owner`: one row of a table. The member functions add properties to the row.
template <class Owner>
struct KeyOf : Key {
  std::function<KeyValue(const Owner&)> get;
  std::function<void(Owner&, const KeyValue&)> set;
  std::function<bool(const Owner&)> shown;   ///< false: the key has no meaning now; empty: always shown
  std::function<double(const Owner&)> most;  ///< the highest number, where it depends on other keys
  std::vector<KeyOf> inner;                  ///< of a section

  KeyOf&& of_form(std::string_view text) && { return form = text, std::move(*this); }
  KeyOf&& by_default(std::string_view text) && { return preset = text, std::move(*this); }
  KeyOf&& unless_set(std::string_view text) && { return remark = text, std::move(*this); }
  KeyOf&& or_else(const KeyValue& value) && { return otherwise = value, std::move(*this); }
  KeyOf&& or_empty() && { return may_be_empty = true, std::move(*this); }
  KeyOf&& needed() && { return required = true, std::move(*this); }
  KeyOf&& as_angle() && { return kind = KeyKind::angle, unit = "rad", std::move(*this); }
  KeyOf&& in_short() && { return short_form = true, std::move(*this); }
  KeyOf&& in_one_line() && { return flow = true, std::move(*this); }
  KeyOf&& shown_if(std::function<bool(const Owner&)> when) && {
    return shown = std::move(when), std::move(*this);
  }
  KeyOf&& checked(std::optional<Rejection> (*check)(const KeyValue&)) && {
    return rejection = check, std::move(*this);
  }
};

template <class Owner>
using Keys = std::vector<KeyOf<Owner>>;

template <class Owner>
Keys<Owner> joined(std::initializer_list<Keys<Owner>> parts) {
  Keys<Owner> all;
  for (const Keys<Owner>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// The value to show; empty if the key is not shown or not set.
template <class Owner>
KeyValue shown_value(const KeyOf<Owner>& key, const Owner& owner) {
  if (!key.get || (key.shown && !key.shown(owner))) return {};
  KeyValue value = key.get(owner);
  const auto* text = std::get_if<std::string>(&value);
  const auto* number = std::get_if<double>(&value);
  const bool is_none = (text != nullptr && text->empty() && !key.may_be_empty) ||
                       (number != nullptr && !std::isfinite(*number));
  return is_none ? KeyValue() : value;
}
template <class Owner>
KeyMap shown_values(const Keys<Owner>& keys, const Owner& owner) {
  KeyMap map;
  for (const auto& key : keys) map.emplace_back(key.name, shown_value(key, owner));
  return map;
}

/// The keys of a member as keys of its owner.
template <class Owner, class Member>
Keys<Owner> within(Member Owner::*member, const Keys<Member>& keys) {
  Keys<Owner> lifted;
  for (const KeyOf<Member>& key : keys) {
    KeyOf<Owner>& one = lifted.emplace_back();
    static_cast<Key&>(one) = key;
    if (key.get) one.get = [member, get = key.get](const Owner& owner) { return get(owner.*member); };
    if (key.set)
      one.set = [member, set = key.set](Owner& owner, const KeyValue& value) { set(owner.*member, value); };
    if (key.shown) one.shown = [member, when = key.shown](const Owner& owner) { return when(owner.*member); };
    if (key.most) one.most = [member, most = key.most](const Owner& owner) { return most(owner.*member); };
    one.inner = within(member, key.inner);
  }
  return lifted;
}

/// Rows of every kind.
namespace keys {

/// A key that `get` writes and the enclosing section parses.
template <class Owner>
KeyOf<Owner> special(std::string_view name, std::string_view form, std::function<KeyValue(const Owner&)> get,
                     std::string_view meaning) {
  KeyOf<Owner> key;
  key.name = name;
  key.form = form;
  key.meaning = meaning;
  key.get = std::move(get);
  return key;
}

template <class Owner, class Member>
KeyOf<Owner> of_kind(KeyKind kind, std::string_view name, Member Owner::*member, std::string_view meaning) {
  KeyOf<Owner> key;
  key.name = name;
  key.kind = kind;
  key.meaning = meaning;
  key.get = [member](const Owner& owner) { return key_value(owner.*member); };
  key.set = [member](Owner& owner, const KeyValue& value) { store_value(value, owner.*member); };
  return key;
}

template <class Owner, class Member>
KeyOf<Owner> flag(std::string_view name, Member Owner::*member, std::string_view meaning) {
  return of_kind(KeyKind::flag, name, member, meaning);
}

/// A number, or a span of time in seconds.
template <class Owner, class Member>
KeyOf<Owner> number(std::string_view name, Member Owner::*member, double lowest, double highest,
                    std::string_view unit, std::string_view meaning) {
  KeyOf<Owner> key = of_kind(KeyKind::number, name, member, meaning);
  key.lowest = lowest;
  key.highest = highest;
  key.unit = unit;
  return key;
}

template <class Owner, class Member>
KeyOf<Owner> whole(std::string_view name, Member Owner::*member, double lowest, double highest,
                   std::string_view meaning) {
  KeyOf<Owner> key = number(name, member, lowest, highest, "", meaning);
  key.kind = KeyKind::whole;
  return key;
}

/// An angle: `name` in rad, or `name`_deg in degrees. The parser rejects the wrong unit; the section checks
/// the limits.
template <class Owner, class Member>
KeyOf<Owner> angle(std::string_view name, Member Owner::*member, double lowest, double highest,
                   std::string_view meaning) {
  KeyOf<Owner> key = number(name, member, lowest, highest, "rad", meaning);
  key.kind = KeyKind::angle;
  return key;
}

template <class Choice>
using Words = std::vector<std::pair<std::string_view, Choice>>;

/// One of a few words, each for a value of the member. If several words mean one value, the last one is
/// written.
template <class Owner, class Member>
KeyOf<Owner> word(std::string_view name, Member Owner::*member, const Words<Member>& words,
                  std::string_view meaning) {
  KeyOf<Owner> key = special<Owner>(name, {}, {}, meaning);
  key.kind = KeyKind::word;
  for (const auto& one : words) key.words.push_back(one.first);
  key.get = [member, words](const Owner& owner) {
    KeyValue value;
    for (const auto& [text, choice] : words) {
      if (owner.*member == choice) value = std::string(text);
    }
    return value;
  };
  key.set = [member, words](Owner& owner, const KeyValue& value) {
    for (const auto& [text, choice] : words) {
      if (text == std::get<std::string>(value)) owner.*member = choice;
    }
  };
  return key;
}

template <class Owner, class Member>
KeyOf<Owner> text(std::string_view name, Member Owner::*member, std::string_view form,
                  std::string_view meaning) {
  return of_kind(KeyKind::text, name, member, meaning).of_form(form);
}
template <class Owner>
KeyOf<Owner> topic(std::string_view name, std::string Owner::*member, std::string_view meaning) {
  return of_kind(KeyKind::topic, name, member, meaning);
}
template <class Owner>
KeyOf<Owner> frame(std::string_view name, std::string Owner::*member, std::string_view meaning) {
  return of_kind(KeyKind::frame, name, member, meaning);
}

/// Keys beneath a key, of the same structure.
template <class Owner>
KeyOf<Owner> section(std::string_view name, Keys<Owner> inner, std::string_view meaning) {
  KeyOf<Owner> key = special<Owner>(name, {}, {}, meaning);
  key.kind = KeyKind::section;
  key.inner = std::move(inner);
  return key;
}

}  // namespace keys
}  // namespace lidard
