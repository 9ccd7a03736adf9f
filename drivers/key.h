// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
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
#include "drivers/traits.h"

namespace lidard {

class Value;
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

/// A word that a key may have, and the enumerator (or truth value) that it stands for.
struct Word {
  template <class Choice>
  constexpr Word(std::string_view word, Choice choice) : text(word), value(static_cast<int>(choice)) {}
  std::string_view text;
  int value;
};

/// Kind and limits of a key's values.
struct Form {
  KeyKind kind = KeyKind::special;
  double lowest = 0, highest = 0;
  std::string_view unit{};    ///< of a number; an angle is in rad, or in degrees as `name`_deg
  std::string_view form{};    ///< of a text, a word or a special value, for messages
  std::vector<Word> words{};  ///< allowed; if several mean one value, the last one is written
  std::optional<Rejection> (*rejection)(const KeyValue& value) = nullptr;  ///< a further check of a value
};

/// What holds while a key is missing.
struct Missing {
  std::string_view preset{};  ///< description of a default that depends on other things
  std::string_view remark{};  ///< the behaviour while no value is set
  KeyValue otherwise{};       ///< the value that means "not set", if there is one
  bool required = false;
  bool may_be_empty = false;  ///< an empty text means none
};

/// How a section is written: a line for each key, or all in one line; `brief`: a single value may stand for
/// its first key.
enum class SectionStyle : std::uint8_t { lines, one_line, brief };

/// A member as the value of its key. Words stand for enumerators, and for true and false where a flag has
/// some.
template <class T>
KeyValue member_value(const T& member, const Form& form) {
  [[maybe_unused]] const auto word = [&](int choice) {
    KeyValue found;
    for (const Word& one : form.words) {
      if (one.value == choice) found = std::string(one.text);
    }
    return found;
  };
  if constexpr (std::is_enum_v<T>)
    return word(static_cast<int>(member));
  else if constexpr (std::is_same_v<T, bool>)
    return form.words.empty() ? KeyValue(member) : word(static_cast<int>(member));
  else if constexpr (std::is_arithmetic_v<T>)
    return static_cast<double>(member);
  else if constexpr (std::is_same_v<T, Span>)
    return static_cast<double>(member.count()) / 1e9;  // gives the shortest text of a decimal fraction
  else if constexpr (std::is_same_v<T, IpAddress>)
    return member.to_string();
  else if constexpr (std::is_same_v<T, std::vector<std::string>>)
    return KeyList(member.begin(), member.end());
  else
    return member;
}
template <class T>
KeyValue member_value(const std::optional<T>& member, const Form& form) {
  return member ? member_value(*member, form) : KeyValue();
}

/// Stores the value of a key, which is of the right kind, in its member.
template <class T>
void set_member(T& member, const KeyValue& value, const Form& form) {
  if constexpr (std::is_enum_v<T> || std::is_same_v<T, bool>) {
    if (const auto* flag = std::get_if<bool>(&value)) member = static_cast<T>(*flag);
    const auto* text = std::get_if<std::string>(&value);
    for (const Word& word : form.words) {
      if (text != nullptr && word.text == *text) member = static_cast<T>(word.value);
    }
  } else if constexpr (std::is_arithmetic_v<T>) {
    member = static_cast<T>(std::get<double>(value));
  } else if constexpr (std::is_same_v<T, Span>) {
    member = span_from_seconds(std::get<double>(value));
  } else if constexpr (std::is_same_v<T, IpAddress>) {
    member = IpAddress::parse(std::get<std::string>(value)).value_or(IpAddress());
  } else if constexpr (std::is_same_v<T, std::string>) {
    member = form.kind == KeyKind::whole ? number_text(std::get<double>(value)) : std::get<T>(value);
  } else {
    member = std::get<T>(value);
  }
}
template <class T>
void set_member(std::optional<T>& member, const KeyValue& value, const Form& form) {
  member.reset();
  if (value.is_set()) set_member(member.emplace(), value, form);
}

struct Key;
/// The keys of a section, in the order in which they are read and written.
using Keys = std::vector<Key>;

/// A key of the configuration. A function for each section makes the keys of one structure: with the values
/// that it has at that time, and bound to its members, so that they must not outlive it.
struct Key : Form, Missing {
  std::string_view name;
  std::string_view meaning;  ///< one line, for the reference
  KeyValue value;
  std::optional<Trait> trait{};  ///< of a sensor: the models that accept it; none: every source
  bool live = false;             ///< it can be changed while the daemon runs
  bool applies = true;  ///< false: it means nothing with the other keys as they are, and is not shown
  SectionStyle style = SectionStyle::lines;
  Keys inner;                                                ///< of a section
  std::function<void(const KeyValue&, const Form&)> setter;  ///< of a member
  std::function<void(const Value&)> reader;                  ///< of a value of a form of its own

  /// The key of a member; of kind `special` it is shown, and parsed by the enclosing section.
  template <class T>
  Key(std::string_view called, T& member, Form limits, std::string_view help, Missing without = {})
      : Key(called, member_value(member, limits), limits, help, std::move(without)) {
    if constexpr (!std::is_same_v<T, std::vector<std::string>>) {
      if (kind != KeyKind::special)
        setter = [&member](const KeyValue& given, const Form& of) { set_member(member, given, of); };
    }
  }
  /// A key that is shown with a value, and parsed by the enclosing section.
  Key(std::string_view called, KeyValue shown, Form limits, std::string_view help, Missing without = {})
      : Form(std::move(limits)),
        Missing(std::move(without)),
        name(called),
        meaning(help),
        value(std::move(shown)) {}
  /// A key that is shown with a value, and that `read` parses.
  Key(std::string_view called, KeyValue shown, std::function<void(const Value&)> read, Form limits,
      std::string_view help, Missing without = {})
      : Key(called, std::move(shown), std::move(limits), help, std::move(without)) {
    reader = std::move(read);
  }
  /// A section.
  Key(std::string_view called, Keys keys, std::string_view help, SectionStyle written = SectionStyle::lines)
      : Form{KeyKind::section}, name(called), meaning(help), style(written), inner(std::move(keys)) {}

  /// False: the enclosing section parses it.
  bool can_be_read() const { return setter != nullptr || reader != nullptr; }
  /// Stores a value of the right kind (a valid address for an IpAddress) in the member.
  void set(const KeyValue& given) const { setter(given, *this); }
};

/// What rows are made of.
namespace keys {

inline const Form flag{KeyKind::flag}, topic{KeyKind::topic}, frame{KeyKind::frame}, pose{KeyKind::pose};
/// A number, or a span of time in seconds.
inline Form number(double lowest, double highest, std::string_view unit) {
  return {KeyKind::number, lowest, highest, unit};
}
inline Form whole(double lowest, double highest,
                  std::optional<Rejection> (*rejection)(const KeyValue&) = nullptr) {
  return {KeyKind::whole, lowest, highest, {}, {}, {}, rejection};
}
/// An angle: `name` in rad, or `name`_deg in degrees. The parser rejects the wrong unit; the section checks
/// the limits.
inline Form angle(double lowest, double highest) { return {KeyKind::angle, lowest, highest, "rad"}; }
/// One of a few words; without a form for messages they are listed.
inline Form word(std::vector<Word> words, std::string_view form = {}) {
  return {KeyKind::word, 0, 0, {}, form, std::move(words)};
}
inline Form text(std::string_view form, std::optional<Rejection> (*rejection)(const KeyValue&) = nullptr) {
  return {KeyKind::text, 0, 0, {}, form, {}, rejection};
}
inline Form special(std::string_view form) { return {KeyKind::special, 0, 0, {}, form}; }

inline const Missing needed{{}, {}, {}, true};
/// An empty text means none.
inline const Missing or_none{{}, {}, {}, false, true};
inline Missing preset(std::string_view text) { return {text}; }
inline Missing remark(std::string_view text, KeyValue otherwise = {}) {
  return {{}, text, std::move(otherwise)};
}

/// Several lists of keys as one.
inline Keys join(std::initializer_list<Keys> parts) {
  Keys all;
  for (const Keys& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}
/// Keys that mean nothing, and are not shown, unless `applies`.
inline Keys only_if(bool applies, Keys list) {
  for (Key& key : list) key.applies = key.applies && applies;
  return list;
}

}  // namespace keys
}  // namespace lidard
