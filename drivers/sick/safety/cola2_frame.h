// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/bytes.h"

namespace lidard::sick {

/// One CoLa 2 telegram (SICK 8022708 p. 28-30). No checksum; numbers of the header big endian, of the data
/// little endian.
struct Cola2Telegram {
  std::uint32_t session = 0;  ///< 0 in the request that opens one
  std::uint16_t request = 0;  ///< repeated in the answer
  char type = 0;  ///< 'O' open, 'C' close, 'R' read, 'M' method; 'A' answer of a method, 'F' refusal
  char mode = 0;  ///< 'X' session request, 'I' by index, 'A' answer
  ByteView data;

  bool is(char t, char m) const { return type == t && mode == m; }
};

/// The telegram as bytes.
std::vector<std::uint8_t> encode_cola2(const Cola2Telegram& telegram);

/// Telegrams out of a stream in chunks of any size; what is no telegram is skipped and counted.
class Cola2Stream {
 public:
  void add(ByteView chunk) { buffer_.insert(buffer_.end(), chunk.begin(), chunk.end()); }
  /// False when no whole telegram is there. The view is valid until the next call.
  bool next(Cola2Telegram& telegram);
  void clear();
  std::uint64_t skipped_bytes() const { return skipped_; }

 private:
  std::size_t garbage() const;
  void skip(std::size_t count);
  void drop(std::size_t count);

  std::vector<std::uint8_t> buffer_;
  std::size_t used_ = 0;  // bytes of the telegram given out last
  std::uint64_t skipped_ = 0;
};

}  // namespace lidard::sick
