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
Mapping mapping_of(const Value& value, const Keys& keys, Mistakes& mistakes);
/// Reads a single value, checked against the key.
KeyValue read_value(const Value& value, const Key& key);
/// Reads the key, if it is present, into its member.
void read_key(const Mapping& yaml, const Key& key);
/// Reads the keys; a mistake in one is kept in `mistakes` and leaves its member unchanged.
void read_keys(const Mapping& yaml, const Keys& keys, Mistakes& mistakes);
/// Reads the keys of a mapping that has no others; throws all mistakes.
Mapping read_section(const Value& value, const Keys& keys);

/// The values of the keys that apply and are set. An infinite number, and an empty text that is no value of
/// the key, are as good as not set.
KeyMap shown_values(const Keys& keys);
void write_tree(YAML::Emitter& yaml, const KeyValue& value);
/// Writes the keys that apply; without a value the behaviour, as a comment or as the value for "not set".
void write_keys(YAML::Emitter& yaml, const Keys& keys);

bool operator==(const KeyValue& a, const KeyValue& b);

}  // namespace lidard
