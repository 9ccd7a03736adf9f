// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/bytes.h"
#include "core/base/counters.h"
#include "core/base/float_bits.h"
#include "drivers/stream_buffer.h"

namespace lidard::sick {

/// Echoes of a beam that are read; picoScan100 and multiScan100 send three at most.
constexpr std::size_t max_echoes = 5;
/// Scan lines of one telegram; a multiScan100 has 16 layers.
constexpr std::size_t max_lines = 64;
/// Segments of one frame; picoScan100 and multiScan100 send 12 at most.
constexpr std::size_t max_segments = 64;
/// Beams of one line; a full turn in steps of 0.02 deg.
constexpr std::size_t max_beams = 18000;

/// Nanoseconds since 1970 must fit into 63 bits.
constexpr std::uint64_t latest_device_us = 9'000'000'000'000'000;

/// Type of a column's elements, all little-endian.
enum class Element : std::uint8_t { u8, u16, u32, f32 };

/// Location of one quantity of a line's beams in the telegram.
struct Column {
  const std::uint8_t* data = nullptr;  ///< of the first beam; nullptr: not sent
  std::uint32_t stride = 0;            ///< bytes from beam to beam
  Element element = Element::u16;

  bool sent() const { return data != nullptr; }
  /// The value of a beam on the wire.
  double operator[](std::size_t beam) const {
    const std::uint8_t* at = data + beam * stride;
    const ByteView bytes(at, 4);
    switch (element) {
      case Element::u8:
        return *at;
      case Element::u16:
        return at[0] | at[1] << 8U;
      case Element::u32:
        return bytes.le32(0);
      case Element::f32:
        return static_cast<double>(float_of_bits<float>(bytes.le32(0)));
    }
    return 0;
  }
};

/// One line of a segment: the beams of one layer. Angles in rad, counter-clockwise from the front (REP 103).
struct SegmentLine {
  std::uint64_t start_us = 0, stop_us = 0;  ///< device time of the first and the last beam
  double elevation = 0;                     ///< upwards
  double theta_start = 0, theta_stop = 0;   ///< azimuth of the first and the last beam, as announced
  std::size_t beams = 0;
  std::size_t echoes = 0;
  double metres = 0.001;                    ///< one step of the distance
  std::array<Column, max_echoes> distance;  ///< 0: no echo
  std::array<Column, max_echoes> rssi;
  Column properties;      ///< bit 0: reflector
  Column theta;           ///< azimuth of each beam
  double theta_zero = 0;  ///< azimuth = (theta - theta_zero) * theta_step
  double theta_step = 1;  ///< rad

  /// Azimuth of a beam from its column, else interpolated between the announced ends.
  double azimuth(std::size_t beam) const {
    if (theta.sent()) return (theta[beam] - theta_zero) * theta_step;
    if (beams < 2) return theta_start;
    return theta_start +
           (theta_stop - theta_start) * static_cast<double>(beam) / static_cast<double>(beams - 1);
  }
  /// Device time of a beam, us.
  double time_us(std::size_t beam) const {
    const double share = beams < 2 ? 0 : static_cast<double>(beam) / static_cast<double>(beams - 1);
    return static_cast<double>(stop_us - start_us) * share;  // after start_us
  }
};

/// The part of a frame in one telegram of either format. It refers to the telegram's bytes.
struct Segment {
  std::uint64_t counter = 0;  ///< of telegrams
  std::uint64_t frame = 0;
  std::uint64_t index = 0;    ///< within the frame
  std::uint32_t sender = 0;   ///< serial number
  std::uint32_t version = 0;  ///< of the Compact format; 0: MSGPACK
  std::size_t line_count = 0;
  std::array<SegmentLine, max_lines> lines;

  /// Device time of the last beam, us; the telegram was sent later.
  std::uint64_t stop_us() const {
    std::uint64_t last = 0;
    for (std::size_t i = 0; i < line_count; ++i) last = lines[i].stop_us > last ? lines[i].stop_us : last;
    return last;
  }
  std::uint64_t start_us() const {
    std::uint64_t first = lines[0].start_us;
    for (std::size_t i = 1; i < line_count; ++i)
      first = lines[i].start_us < first ? lines[i].start_us : first;
    return first;
  }
};

/// False for impossible values of a line: decreasing or too long times, invalid angles.
inline bool is_plausible(const SegmentLine& line) {
  constexpr std::uint64_t longest_us = 2'000'000;
  constexpr double farthest = 7;  // rad: a segment of a multiScan100 may extend beyond pi
  if (line.start_us > latest_device_us || line.stop_us < line.start_us) return false;
  if (line.stop_us - line.start_us > longest_us) return false;
  for (const double angle : {line.elevation, line.theta_start, line.theta_stop}) {
    if (!(std::fabs(angle) <= farthest)) return false;
  }
  return line.metres > 0 && line.metres < 1;
}

/// Type of a telegram of picoScan100, multiScan100 or LRS4000. The numbers are those on the wire (SICK
/// KaitaiStructDescriptions, compact_frame.ksy); msgpack has none.
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

/// Longest accepted telegram; a UDP datagram is at most 64 KiB, and three echoes of a full turn need less.
constexpr std::size_t max_telegram = 256 * 1024UL;

/// Head of the telegram that starts at some bytes.
struct TelegramHead {
  Reject reject = Reject::none;  ///< why no telegram starts here
  TelegramType type = TelegramType::scan;
  std::size_t length = 0;  ///< of the telegram with its checksum; 0: more bytes are needed
};
TelegramHead read_head(ByteView bytes);

/// True if the checksum at the end of the telegram is right.
bool checksum_is_right(ByteView telegram, TelegramType type);

/// Parses a complete scan telegram (type 1) with a verified checksum. `out` refers to its bytes.
Reject parse_compact_scan(ByteView telegram, Segment& out);

/// Type 2: SICK KaitaiStructDescriptions, type_2_imu.ksy.
struct ImuTelegram {
  std::array<double, 3> acceleration{};      ///< m/s^2, with gravity
  std::array<double, 3> angular_velocity{};  ///< rad/s
  std::array<double, 4> orientation{};       ///< quaternion w, x, y, z
  std::uint64_t time_us = 0;                 ///< device time
};
Reject parse_imu(ByteView telegram, ImuTelegram& out);

/// Type 4: SICK KaitaiStructDescriptions, type_4_encoder.ksy.
struct EncoderTelegram {
  std::uint64_t transmit_us = 0;
  std::uint64_t frame = 0;
  std::uint32_t ticks = 0;
  std::array<std::uint32_t, 2> reference_ticks{};
  double speed = 0;           ///< in the unit configured in the device
  std::uint64_t tick_us = 0;  ///< device time of the last change
};
Reject parse_encoder(ByteView telegram, EncoderTelegram& out);

/// A complete telegram whose checksum is right.
struct Telegram {
  ByteView bytes;
  TelegramType type = TelegramType::scan;
};

/// Finds telegrams in a stream of bytes that may begin anywhere and have holes. After bytes that are no
/// telegram with a valid checksum it searches for the next start mark.
class TelegramStream {
 public:
  explicit TelegramStream(Counters& counters) : counters_(counters) {}

  void add(ByteView chunk) { buffer_.add(chunk); }
  /// The next complete telegram, valid until the next call of add() or interrupt().
  bool next(Telegram& telegram);
  /// Drops an incomplete telegram after missing bytes or the end of the connection.
  void interrupt();

 private:
  void skip_to_mark();

  Counters& counters_;
  StreamBuffer buffer_;
  bool in_step_ = false;  // a telegram ended directly before the unread bytes
};

/// Parses a complete MSGPACK telegram (start mark, length, map, checksum) with a verified checksum. `out`
/// refers to its bytes.
Reject parse_msgpack(ByteView telegram, Segment& out);

/// Parses a telegram without start mark, length and checksum.
Reject parse_msgpack_payload(ByteView payload, Segment& out);

/// Parses a scan telegram of either format; Reject::magic for every other telegram.
inline Reject parse_scan(const Telegram& telegram, Segment& out) {
  return telegram.type == TelegramType::msgpack ? parse_msgpack(telegram.bytes, out)
                                                : parse_compact_scan(telegram.bytes, out);
}

}  // namespace lidard::sick
