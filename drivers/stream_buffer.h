// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/bytes.h"

namespace lidard {

/// The unread bytes of a stream.
class StreamBuffer {
 public:
  /// Appends bytes; views of rest() are invalid afterwards.
  void add(ByteView bytes) {
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  /// Removes the first `count` bytes of rest().
  void drop(std::size_t count) { begin_ += count; }
  void clear() {
    bytes_.clear();
    begin_ = 0;
  }
  ByteView rest() const { return {bytes_.data() + begin_, bytes_.size() - begin_}; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t begin_ = 0;
};

}  // namespace lidard
