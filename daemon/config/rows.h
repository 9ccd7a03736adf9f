// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "drivers/document.h"
#include "drivers/key.h"

namespace YAML {
class Emitter;
}

namespace lidard {

/// A mapping of these keys. Unknown and repeated ones are left out, and are mistakes.
Mapping mapping_of(const Value& value, const std::vector<Key>& keys, Mistakes& mistakes);

/// Reads a single value, checked against the row.
KeyValue read_value(const Value& value, const Key& key);
/// Reads the key, if it is present, into a structure of the type that its table is for.
void read_row(const Mapping& yaml, const Key& key, void* owner);
/// Reads the keys; a mistake in one is kept in `mistakes` and leaves `owner` unchanged.
template <class Owner>
void read_keys(const Mapping& yaml, const Keys<Owner>& keys, Owner& owner, Mistakes& mistakes) {
  for (const Key& key : keys) mistakes.attempt([&] { read_row(yaml, key, &owner); });
}

/// False for a key that means nothing with the others as they are: it is not shown. A section with such keys
/// has an overload.
template <class Owner>
bool applies(const Key& /*key*/, const Owner& /*owner*/) {
  return true;
}
/// The value to show; empty if it is not set. A section has those of its keys that are set.
template <class Owner>
KeyValue shown_value(const Key& key, const Owner& owner);
/// The values of the keys that apply.
template <class Owner>
KeyMap shown_values(const std::vector<Key>& keys, const Owner& owner) {
  KeyMap map;
  for (const Key& key : keys) {
    if (applies(key, owner)) map.emplace_back(key.name, shown_value(key, owner));
  }
  return map;
}
/// A value as it is shown: an infinite number, and an empty text that is no value of the key, are not.
KeyValue as_shown(KeyValue value, const Key& key);
template <class Owner>
KeyValue shown_value(const Key& key, const Owner& owner) {
  return as_shown(key.kind == KeyKind::section ? shown_values(key.inner, owner) : key.get(&owner), key);
}

void write_tree(YAML::Emitter& yaml, const KeyValue& value);
/// Writes the key with its value; without one the behaviour, as a comment or as the value for "not set".
void write_row(YAML::Emitter& yaml, const Key& key, const KeyValue& value);
template <class Owner>
void write_keys(YAML::Emitter& yaml, const Keys<Owner>& keys, const Owner& owner) {
  for (const Key& key : keys) {
    if (applies(key, owner)) write_row(yaml, key, shown_value(key, owner));
  }
}

bool operator==(const KeyValue& a, const KeyValue& b);

}  // namespace lidard
