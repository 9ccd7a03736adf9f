// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>

namespace lidard {

/// Why there is no value: a sentence with the remedy.
struct Reason {
  std::string text;
};

/// A value, or the reason why there is none.
template <class Value>
class Expected {
 public:
  Expected(Value value) : value_(std::move(value)) {}
  Expected(Reason reason) : reason_(std::move(reason.text)) {}

  explicit operator bool() const { return value_.has_value(); }
  /// Throws std::bad_optional_access where there is none.
  Value& value() { return value_.value(); }
  const Value& operator*() const { return *value_; }
  const Value* operator->() const { return &*value_; }
  const std::string& reason() const { return reason_; }

 private:
  std::optional<Value> value_;
  std::string reason_;
};

}  // namespace lidard
