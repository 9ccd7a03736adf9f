// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/bytes.h"
#include "core/base/counters.h"
#include "drivers/stream_buffer.h"

namespace lidard::hokuyo {

/// CRC-16/KERMIT (polynomial 0x1021 reflected, start 0) of the text between STX and the checksum.
std::uint16_t uam_crc(std::string_view text);
/// A request of the AR family, e.g. "AR02": STX, length, command, checksum, ETX.
std::string uam_request(std::string_view command);
/// `digits` hexadecimal digits at `at`; empty if one of them is none.
std::optional<std::uint32_t> uam_number(std::string_view text, std::size_t at, std::size_t digits);

/// A frame from STX to ETX.
struct UamFrame {
  std::string_view text;         ///< a view into the reader's buffer
  Reject reject = Reject::none;  ///< why it is not readable; the text is empty then
};

/// Cuts a stream into frames STX length ... CRC ETX. Text outside of frames (SCIP answers on the same
/// connection) is skipped.
class UamReader {
 public:
  explicit UamReader(Counters& counters) : counters_(counters) {}
  void interrupt();
  void add(ByteView bytes) { buffer_.add(bytes); }
  /// The next frame, valid until the next call of add() or interrupt().
  bool next(UamFrame& frame);

 private:
  bool skip_to_frame();

  Counters& counters_;
  StreamBuffer buffer_;
  bool torn_ = true;
};

/// Where the distances begin, and how many bytes of a frame are none of them.
constexpr std::size_t uam_distances_at = 50;
constexpr std::size_t uam_tail = 5;

}  // namespace lidard::hokuyo
