// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
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

/// A key of the configuration: one row of a table, made as a KeyOf<Owner>.
struct Key : Form, Missing {
  std::string_view name;
  std::string_view meaning;      ///< one line, for the reference
  std::optional<Trait> trait{};  ///< of a sensor: the models that accept it; none: every source
  bool live = false;             ///< it can be changed while the daemon runs
  SectionStyle style = SectionStyle::lines;
  std::vector<Key> inner;  ///< of a section

  Key(Form limits, Missing without, std::string_view called, std::string_view help)
      : Form(std::move(limits)), Missing(std::move(without)), name(called), meaning(help) {}
  /// The value in a structure of the type that the table is for.
  KeyValue get(const void* owner) const {
    return read_ == nullptr ? KeyValue() : read_(static_cast<const char*>(owner) + offset_, *this);
  }
  /// Stores a value of the right kind (a valid address for an IpAddress). The enclosing section parses keys
  /// that cannot be set.
  void set(void* owner, const KeyValue& value) const {
    store_(static_cast<char*>(owner) + offset_, value, *this);
  }
  bool can_be_set() const { return store_ != nullptr; }
  /// The key of a structure that stands `bytes` behind the begin of another one, as a key of that one.
  void shift(std::ptrdiff_t bytes) {
    offset_ += bytes;
    for (Key& key : inner) key.shift(bytes);
  }

 protected:
  template <class Owner>
  static KeyValue call_getter(const void* owner, const Key& key) {
    return reinterpret_cast<KeyValue (*)(const Owner&)>(key.getter_)(*static_cast<const Owner*>(owner));
  }

  std::ptrdiff_t offset_ = 0;  // of the member in its structure
  KeyValue (*read_)(const void* member, const Key& key) = nullptr;
  void (*store_)(void* member, const KeyValue& value, const Key& key) = nullptr;
  void (*getter_)() = nullptr;  // a KeyValue (*)(const Owner&) in place of a member
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

/// A member of `Owner`, or of a structure inside of it: `offset` bytes behind its begin.
template <class Owner, class T>
struct Member {
  std::ptrdiff_t offset;
};
/// at(&Owner::inner, &Inner::member): the member at the end of the path.
template <class Owner, class T>
Member<Owner, T> at(T Owner::*member) {
  static const Owner probe{};
  return {reinterpret_cast<const char*>(&(probe.*member)) - reinterpret_cast<const char*>(&probe)};
}
template <class Owner, class Inner, class T>
Member<Owner, T> at(Inner Owner::*first, Member<Inner, T> rest) {
  return {at(first).offset + rest.offset};
}
template <class Owner, class Inner, class... Path>
auto at(Inner Owner::*first, Path... path) {
  return at(first, at(path...));
}

/// The value of a member, and how it is stored there.
template <class T>
struct Stored {
  static constexpr bool is_choice = std::is_enum_v<T> || std::is_same_v<T, bool>;

  static KeyValue read(const T& member, const Key& key) {
    if constexpr (is_choice) {
      KeyValue found;
      for (const Word& word : key.words) {
        if (word.value == static_cast<int>(member)) found = std::string(word.text);
      }
      if (std::is_enum_v<T> || !key.words.empty()) return found;
    }
    if constexpr (std::is_enum_v<T>)
      return {};
    else
      return key_value(member);
  }
  static void store(T& member, const KeyValue& value, const Key& key) {
    if constexpr (is_choice) {
      const auto* text = std::get_if<std::string>(&value);
      for (const Word& word : key.words) {
        if (text != nullptr && word.text == *text) member = static_cast<T>(word.value);
      }
    }
    if constexpr (std::is_same_v<T, Span>)
      member = span_from_seconds(std::get<double>(value));
    else if constexpr (std::is_same_v<T, IpAddress>)
      member = IpAddress::parse(std::get<std::string>(value)).value_or(IpAddress());
    else if constexpr (std::is_same_v<T, std::string>)
      member = key.kind == KeyKind::whole ? number_text(std::get<double>(value)) : std::get<T>(value);
    else if constexpr (std::is_same_v<T, bool>)
      member = key.words.empty() ? std::get<bool>(value) : member;
    else if constexpr (std::is_arithmetic_v<T>)
      member = static_cast<T>(std::get<double>(value));
    else if constexpr (std::is_same_v<T, Pose>)
      member = std::get<Pose>(value);
  }
};
template <class T>
struct Stored<std::optional<T>> {
  static KeyValue read(const std::optional<T>& member, const Key& key) {
    return member ? Stored<T>::read(*member, key) : KeyValue();
  }
  static void store(std::optional<T>& member, const KeyValue& value, const Key& key) {
    member.reset();
    if (value.is_set()) Stored<T>::store(member.emplace(), value, key);
  }
};

template <class Owner>
class Keys;

/// A key of the structure `Owner`: {name, member, form, meaning, missing}.
template <class Owner>
struct KeyOf : Key {
  template <class T>
  KeyOf(std::string_view called, Member<Owner, T> member, Form limits, std::string_view help,
        Missing without = {})
      : KeyOf(called, std::move(limits), help, std::move(without)) {
    offset_ = member.offset;
    read_ = [](const void* at, const Key& key) { return Stored<T>::read(*static_cast<const T*>(at), key); };
    if (kind == KeyKind::special) return;
    store_ = [](void* at, const KeyValue& value, const Key& key) {
      Stored<T>::store(*static_cast<T*>(at), value, key);
    };
  }
  template <class T>
  KeyOf(std::string_view called, T Owner::*member, Form limits, std::string_view help, Missing without = {})
      : KeyOf(called, at(member), std::move(limits), help, std::move(without)) {}
  /// A key that `getter` shows and the enclosing section parses.
  KeyOf(std::string_view called, KeyValue (*getter)(const Owner&), Form limits, std::string_view help,
        Missing without = {})
      : KeyOf(called, std::move(limits), help, std::move(without)) {
    getter_ = reinterpret_cast<void (*)()>(getter);
    read_ = call_getter<Owner>;
  }
  /// A section.
  template <class T>
  KeyOf(std::string_view called, T Owner::*member, Keys<T> keys, std::string_view help,
        SectionStyle written = SectionStyle::lines)
      : KeyOf(called, Form{KeyKind::section}, help, {}) {
    style = written;
    inner = std::move(keys);
    for (Key& key : inner) key.shift(at(member).offset);
  }

 private:
  KeyOf(std::string_view called, Form limits, std::string_view help, Missing without)
      : Key(std::move(limits), std::move(without), called, help) {}
};

/// The keys of the structure `Owner`, in the order in which they are read and written.
template <class Owner>
class Keys : public std::vector<Key> {
 public:
  Keys() = default;
  Keys(std::initializer_list<KeyOf<Owner>> rows) : std::vector<Key>(rows.begin(), rows.end()) {}
  Keys(std::initializer_list<Keys> parts) {
    for (const Keys& part : parts) insert(end(), part.begin(), part.end());
  }
};

/// The keys of a member as keys of its owner.
template <class Owner, class T>
Keys<Owner> within(T Owner::*member, const Keys<T>& keys) {
  Keys<Owner> lifted;
  lifted.assign(keys.begin(), keys.end());
  for (Key& key : lifted) key.shift(at(member).offset);
  return lifted;
}

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

}  // namespace keys
}  // namespace lidard
