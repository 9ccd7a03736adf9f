// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/counters.h"
#include "drivers/sick/compact/segment.h"

namespace lidard::sick {

/// What a telegram of picoScan100, multiScan100 or LRS4000 is. The numbers are those on the wire (SICK
/// KaitaiStructDescriptions, compact_frame.ksy and its neighbours); msgpack has none.
enum class TelegramType : std::uint32_t {
  msgpack = 0,
  scan = 1,
  imu = 2,
  ambient_light = 3,
  encoder = 4,
  point_cloud = 5,
  multiscan200 = 6,
  imu_v2 = 7
};

/// Longer telegrams are none: an UDP datagram ends at 64 KiB, three echoes of a full turn need less.
constexpr std::size_t max_telegram = 256 * 1024;

/// What the begin of some bytes says of the telegram that starts there.
struct TelegramHead {
  Reject reject = Reject::none;  ///< no telegram starts here
  TelegramType type = TelegramType::scan;
  std::size_t length = 0;  ///< of the whole telegram with its checksum; 0: more bytes are needed to tell
};
TelegramHead read_head(ByteView bytes);

/// True if the checksum at the end of the whole telegram is right.
bool checksum_is_right(ByteView telegram, TelegramType type);

/// Parses a whole scan telegram (type 1) whose checksum was tested. `out` points into it.
Reject parse_compact_scan(ByteView telegram, Segment& out);

/// Type 2, as SICK KaitaiStructDescriptions type_2_imu.ksy has it.
struct ImuTelegram {
  std::array<double, 3> acceleration{};      ///< m/s^2, with gravity
  std::array<double, 3> angular_velocity{};  ///< rad/s
  std::array<double, 4> orientation{};       ///< quaternion w, x, y, z
  std::uint64_t time_us = 0;                 ///< device time
};
Reject parse_imu(ByteView telegram, ImuTelegram& out);

/// Type 4, as SICK KaitaiStructDescriptions type_4_encoder.ksy has it.
struct EncoderTelegram {
  std::uint64_t transmit_us = 0;
  std::uint64_t frame = 0;
  std::uint32_t ticks = 0;
  std::array<std::uint32_t, 2> reference_ticks{};
  double speed = 0;           ///< in the unit configured in the device
  std::uint64_t tick_us = 0;  ///< device time of the last change
};
Reject parse_encoder(ByteView telegram, EncoderTelegram& out);

/// Finds whole telegrams in a stream of bytes, joined anywhere and with holes: looks for the start mark again
/// wherever the bytes are no telegram with a right checksum.
class TelegramStream {
 public:
  /// Takes the next bytes and calls `take(telegram, type)` for each telegram that is whole; the view is valid
  /// during the call. Returns the last reason for which bytes were skipped inside what looked like a stream.
  template <class Take>
  Reject feed(ByteView chunk, Counters& counters, Take&& take);
  /// Bytes are missing, or the connection ended: half a telegram is worth nothing.
  void cut(Counters& counters);

 private:
  ByteView rest() const { return {buffer_.data() + at_, buffer_.size() - at_}; }
  void append(ByteView chunk);
  void skip_to_mark();

  std::vector<std::uint8_t> buffer_;
  std::size_t at_ = 0;
  bool in_step_ = false;  // the last telegram ended at at_
};

template <class Take>
Reject TelegramStream::feed(ByteView chunk, Counters& counters, Take&& take) {
  append(chunk);
  Reject last = Reject::none;
  for (;;) {
    const TelegramHead head = read_head(rest());
    Reject reason = head.reject;
    if (reason == Reject::none) {
      if (head.length == 0 || head.length > rest().size()) return last;
      const ByteView telegram = rest().sub(0, head.length);
      if (checksum_is_right(telegram, head.type)) {
        at_ += head.length;
        in_step_ = true;
        take(telegram, head.type);
        continue;
      }
      reason = Reject::checksum;
    }
    // Before the first telegram and behind a hole nothing else is to be expected.
    if (in_step_) {
      counters.reject(reason);
      last = reason;
    }
    in_step_ = false;
    skip_to_mark();
  }
}

/// Parses a whole MSGPACK telegram (start mark, length, map, checksum) whose checksum was tested. `out`
/// points into it.
Reject parse_msgpack(ByteView telegram, Segment& out);

/// Parses a telegram without start mark, length and checksum.
Reject parse_msgpack_payload(ByteView payload, Segment& out);

}  // namespace lidard::sick
