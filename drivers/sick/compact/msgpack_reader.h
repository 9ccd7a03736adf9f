// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/bytes.h"

namespace lidard::sick {

/// Walks through MessagePack bytes without copying or allocating. Every read says whether the next value was
/// of that kind and whole; after a failure the position means nothing.
class MsgpackReader {
 public:
  explicit MsgpackReader(ByteView bytes) : bytes_(bytes) {}

  /// Number of key and value pairs that follow.
  bool map(std::uint64_t& pairs);
  /// Number of values that follow.
  bool array(std::uint64_t& values);
  bool unsigned_integer(std::uint64_t& value);
  /// Any integer or floating-point number.
  bool number(double& value);
  bool binary(ByteView& value);
  /// Any value with all that it holds.
  bool skip();
  bool next_is_map() const;
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  bool has(std::size_t n) const { return bytes_.has(at_, n); }
  bool count(std::uint8_t fix, std::uint8_t marker16, std::uint64_t& held);
  bool big(std::size_t width, std::uint64_t& value);
  bool skip_one(std::uint64_t& inner);

  ByteView bytes_;
  std::size_t at_ = 0;
};

}  // namespace lidard::sick
