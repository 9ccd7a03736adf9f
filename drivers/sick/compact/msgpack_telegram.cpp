// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/bytes.h"
#include "drivers/sick/compact/compact_telegram.h"

namespace lidard::sick {
namespace {

// Markers of the MessagePack specification (github.com/msgpack/msgpack, spec.md).
constexpr std::uint8_t fixmap = 0x80, fixarray = 0x90, fixstr = 0xa0;
constexpr std::uint8_t unused = 0xc1;
constexpr std::uint8_t bin8 = 0xc4, ext8 = 0xc7, float32 = 0xca, float64 = 0xcb;
constexpr std::uint8_t uint8 = 0xcc, int8 = 0xd0, fixext1 = 0xd4, str8 = 0xd9;
constexpr std::uint8_t array16 = 0xdc, map16 = 0xde;
constexpr std::uint8_t negative_fixint = 0xe0;

bool in(std::uint8_t marker, std::uint8_t first, std::size_t count) {
  return marker >= first && marker < first + count;
}

/// Number of bytes after a marker; `first` is the marker for 8 bits, the next ones mean 16, 32, 64.
std::size_t width_of(std::uint8_t marker, std::uint8_t first) { return 1U << (marker - first); }

/// Reads MessagePack without copying or allocating. Every function returns whether the next value was
/// complete and of its kind; after a failure the position is undefined.
class MsgpackReader {
 public:
  explicit MsgpackReader(ByteView bytes) : bytes_(bytes) {}

  /// Number of key and value pairs that follow.
  bool map(std::uint64_t& pairs) { return count(fixmap, map16, pairs); }
  /// Number of values that follow.
  bool array(std::uint64_t& values) { return count(fixarray, array16, values); }

  bool unsigned_integer(std::uint64_t& value) {
    if (!has(1)) return false;
    const std::uint8_t marker = bytes_.u8(at_++);
    if (marker < fixmap) {
      value = marker;
      return true;
    }
    if (in(marker, uint8, 4)) return big(width_of(marker, uint8), value);
    if (!in(marker, int8, 4)) return false;
    const std::size_t width = width_of(marker, int8);
    // A non-negative signed number is accepted too.
    // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): the width is 1, 2, 4 or 8.
    return big(width, value) && value >> (8 * width - 1) == 0;
  }

  /// Any integer or floating-point number.
  bool number(double& value) {
    if (!has(1)) return false;
    const std::uint8_t marker = bytes_.u8(at_);
    std::uint64_t raw = 0;
    if (marker == float32 || marker == float64) {
      ++at_;
      if (!big(marker == float32 ? 4 : 8, raw)) return false;
      value = marker == float64 ? float_of_bits<double>(raw)
                                : static_cast<double>(float_of_bits<float>(static_cast<std::uint32_t>(raw)));
      return true;
    }
    if (marker >= negative_fixint) {
      ++at_;
      value = static_cast<double>(marker) - 256;
      return true;
    }
    if (!unsigned_integer(raw)) return false;
    value = static_cast<double>(raw);
    return true;
  }

  bool binary(ByteView& value) {
    if (!has(1)) return false;
    const std::uint8_t marker = bytes_.u8(at_++);
    std::uint64_t length = 0;
    if (!in(marker, bin8, 3) || !big(width_of(marker, bin8), length) || !has(length)) return false;
    value = bytes_.sub(at_, length);
    at_ += length;
    return true;
  }

  /// Any value with its contents.
  bool skip() {
    std::uint64_t open = 1;
    while (open > 0) {
      --open;
      if (!skip_one(open)) return false;
      // A value has at least one byte: reject a count beyond the remaining bytes.
      if (open > bytes_.size() - at_) return false;
    }
    return true;
  }

  bool next_is_map() const {
    if (!has(1)) return false;
    const std::uint8_t marker = bytes_.u8(at_);
    return in(marker, fixmap, 16) || in(marker, map16, 2);
  }

  bool at_end() const { return at_ == bytes_.size(); }

 private:
  bool has(std::size_t n) const { return bytes_.has(at_, n); }

  /// Reads the number of elements of a map or an array; the marker for 32 bits follows that for 16 bits.
  bool count(std::uint8_t fix, std::uint8_t marker16, std::uint64_t& held) {
    if (!has(1)) return false;
    const std::uint8_t marker = bytes_.u8(at_++);
    held = marker & 0xfU;
    if (in(marker, fix, 16)) return true;
    return in(marker, marker16, 2) && big(marker == marker16 ? 2 : 4, held);
  }

  bool big(std::size_t width, std::uint64_t& value) {
    if (!has(width)) return false;
    value = 0;
    for (std::size_t i = 0; i < width; ++i) value = value << 8U | bytes_.u8(at_ + i);
    at_ += width;
    return true;
  }

  /// Skips one value; adds the number of contained values to `inner`.
  bool skip_one(std::uint64_t& inner) {
    if (!has(1)) return false;
    const std::uint8_t marker = bytes_.u8(at_);
    std::uint64_t held = 0;
    const bool is_map = next_is_map();
    if (is_map || in(marker, fixarray, 16) || in(marker, array16, 2)) {
      if (!(is_map ? map(held) : array(held))) return false;
      inner += (is_map ? 2 : 1) * held;
      return true;
    }
    ++at_;
    std::uint64_t length = 0;
    if (in(marker, fixstr, 32)) length = marker & 0x1fU;
    if (in(marker, uint8, 4)) length = width_of(marker, uint8);
    if (in(marker, int8, 4)) length = width_of(marker, int8);
    if (marker == float32 || marker == float64) length = marker == float32 ? 4 : 8;
    if (in(marker, fixext1, 5)) length = width_of(marker, fixext1) + 1;
    if (in(marker, bin8, 3) && !big(width_of(marker, bin8), length)) return false;
    if (in(marker, str8, 3) && !big(width_of(marker, str8), length)) return false;
    if (in(marker, ext8, 3)) {
      if (!big(width_of(marker, ext8), length)) return false;
      ++length;
    }
    if (marker == unused || !has(length)) return false;
    at_ += length;
    return true;
  }

  ByteView bytes_;
  std::size_t at_ = 0;
};

// Keys and values of SICK's MSGPACK scan segments: msgpack_parser.cpp of SICKAG/sick_scan_xd,
// SICKAG/ScanSegmentAPI.
enum Key : std::uint64_t {
  key_class = 0x10,
  key_data = 0x11,
  key_count = 0x12,
  key_element_size = 0x13,
  key_endian = 0x14,
  key_element_types = 0x15,
  key_theta = 0x50,
  key_phi = 0x51,
  key_distances = 0x52,
  key_rssi = 0x53,
  key_properties = 0x54,
  key_start_time = 0x71,
  key_stop_time = 0x72,
  key_theta_start = 0x73,
  key_theta_stop = 0x74,
  key_beams = 0x77,
  key_echoes = 0x78,
  key_segment = 0x91,
  key_frame = 0x92,
  key_sender = 0x94,
  key_scans = 0x96,
  key_counter = 0xb0
};
constexpr std::uint64_t class_scan = 0x70, class_segment = 0x90;
constexpr std::uint64_t little_endian = 0x30;
constexpr std::uint64_t type_f32 = 0x31, type_u32 = 0x32, type_u8 = 0x33, type_u16 = 0x34;

bool element_of(std::uint64_t type, std::uint64_t size, Element& element) {
  const auto is = [&](std::uint64_t t, std::uint64_t bytes, Element e) {
    if (type != t || size != bytes) return false;
    element = e;
    return true;
  };
  return is(type_f32, 4, Element::f32) || is(type_u32, 4, Element::u32) || is(type_u16, 2, Element::u16) ||
         is(type_u8, 1, Element::u8);
}

/// A column and its number of values.
struct CountedColumn {
  Column column;
  std::uint64_t count = 0;
};

/// Calls `use(key)` for every pair of a map; it must read or skip the value.
template <class Use>
bool for_each_pair(MsgpackReader& reader, Use&& use) {
  std::size_t pairs = 0;
  if (!reader.map(pairs)) return false;
  for (std::size_t i = 0; i < pairs; ++i) {
    std::uint64_t key = 0;
    if (!reader.unsigned_integer(key) || !use(key)) return false;
  }
  return true;
}

/// An object is {class: .., data: ..}, in either order.
template <class UseData>
bool read_object(MsgpackReader& reader, std::uint64_t wanted, UseData&& use_data) {
  return for_each_pair(reader, [&](std::uint64_t key) {
    std::uint64_t name = 0;
    if (key == key_class) return reader.unsigned_integer(name) && name == wanted;
    return key == key_data ? use_data() : reader.skip();
  });
}

bool read_type(MsgpackReader& reader, std::uint64_t& type) {
  std::size_t types = 0;
  return reader.array(types) && types == 1 && reader.unsigned_integer(type);
}

bool read_column(MsgpackReader& reader, CountedColumn& out) {
  std::uint64_t size = 0, type = 0, endian = little_endian;
  ByteView bytes;
  const bool read = for_each_pair(reader, [&](std::uint64_t key) {
    if (key == key_count) return reader.unsigned_integer(out.count);
    if (key == key_element_size) return reader.unsigned_integer(size);
    if (key == key_endian) return reader.unsigned_integer(endian);
    if (key == key_element_types) return read_type(reader, type);
    return key == key_data ? reader.binary(bytes) : reader.skip();
  });
  if (!read || endian != little_endian || !element_of(type, size, out.column.element)) return false;
  if (out.count > max_beams || bytes.size() != out.count * size) return false;
  out.column.data = out.count > 0 ? bytes.data() : nullptr;
  out.column.stride = static_cast<std::uint32_t>(size);
  return true;
}

/// The columns of one line; their lengths are checked when the number of beams is known.
struct LineColumns {
  CountedColumn theta, phi, properties;
  std::array<CountedColumn, max_echoes> distance, rssi;
  std::size_t distances = 0, rssis = 0;
};

bool read_columns(MsgpackReader& reader, std::array<CountedColumn, max_echoes>& columns, std::size_t& count) {
  if (!reader.array(count) || count > max_echoes) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (!read_column(reader, columns[i])) return false;
  }
  return true;
}

/// The properties are a column or a list of at most one column.
bool read_properties(MsgpackReader& reader, CountedColumn& out) {
  if (reader.next_is_map()) return read_column(reader, out);
  std::size_t count = 0;
  if (!reader.array(count) || count > 1) return false;
  return count == 0 || read_column(reader, out);
}

bool read_line_map(MsgpackReader& reader, SegmentLine& line, LineColumns& columns) {
  std::uint64_t beams = 0, echoes = 0;
  const bool read = for_each_pair(reader, [&](std::uint64_t key) {
    if (key == key_start_time) return reader.unsigned_integer(line.start_us);
    if (key == key_stop_time) return reader.unsigned_integer(line.stop_us);
    if (key == key_theta_start) return reader.number(line.theta_start);
    if (key == key_theta_stop) return reader.number(line.theta_stop);
    if (key == key_beams) return reader.unsigned_integer(beams);
    if (key == key_echoes) return reader.unsigned_integer(echoes);
    if (key == key_theta) return read_column(reader, columns.theta);
    if (key == key_phi) return read_column(reader, columns.phi);
    if (key == key_distances) return read_columns(reader, columns.distance, columns.distances);
    if (key == key_rssi) return read_columns(reader, columns.rssi, columns.rssis);
    if (key == key_properties) return read_properties(reader, columns.properties);
    return reader.skip();
  });
  line.beams = beams;
  line.echoes = echoes;
  return read;
}

/// False if a column of floating-point numbers contains NaN.
bool is_finite(const Column& column, std::size_t beams) {
  for (std::size_t beam = 0; column.sent() && beam < beams; ++beam) {
    if (!std::isfinite(column[beam])) return false;
  }
  return true;
}

/// Stores the columns in the line if all of them have a value for every beam.
bool store_columns(const LineColumns& from, SegmentLine& line) {
  if (line.beams < 1 || line.beams > max_beams) return false;
  if (line.echoes < 1 || line.echoes != from.distances) return false;
  if (from.rssis != 0 && from.rssis != line.echoes) return false;
  const auto fits = [&](const CountedColumn& column) {
    return !column.column.sent() || column.count == line.beams;
  };
  for (std::size_t e = 0; e < line.echoes; ++e) {
    if (!from.distance[e].column.sent() || !fits(from.distance[e]) || !fits(from.rssi[e])) return false;
    if (!is_finite(from.rssi[e].column, line.beams)) return false;
    line.distance[e] = from.distance[e].column;
    line.rssi[e] = from.rssi[e].column;
  }
  if (!fits(from.theta) || !fits(from.properties)) return false;
  if (!is_finite(from.theta.column, line.beams)) return false;
  line.theta = from.theta.column;
  line.properties = from.properties.column;
  line.theta_zero = 0;
  line.theta_step = 1;
  line.metres = 0.001;
  line.elevation = from.phi.column.sent() && from.phi.count > 0 ? from.phi.column[0] : 0;
  return is_plausible(line);
}

bool read_scans(MsgpackReader& reader, Segment& out) {
  std::size_t scans = 0;
  if (!reader.array(scans) || scans < 1 || scans > max_lines) return false;
  out.line_count = 0;
  for (std::size_t i = 0; i < scans; ++i) {
    SegmentLine& line = out.lines[i];
    LineColumns columns;
    const auto read_data = [&] { return read_line_map(reader, line, columns); };
    if (!read_object(reader, class_scan, read_data) || !store_columns(columns, line)) return false;
    ++out.line_count;
  }
  return true;
}

bool read_segment_map(MsgpackReader& reader, Segment& out) {
  std::uint64_t sender = 0;
  const bool read = for_each_pair(reader, [&](std::uint64_t key) {
    if (key == key_counter) return reader.unsigned_integer(out.counter);
    if (key == key_segment) return reader.unsigned_integer(out.index);
    if (key == key_frame) return reader.unsigned_integer(out.frame);
    if (key == key_sender) return reader.unsigned_integer(sender);
    if (key == key_scans) return read_scans(reader, out);
    return reader.skip();
  });
  out.sender = static_cast<std::uint32_t>(sender);
  return read;
}

}  // namespace

Reject parse_msgpack_payload(ByteView payload, Segment& out) {
  out.version = 0;
  out.line_count = 0;
  out.counter = out.frame = out.index = 0;
  MsgpackReader reader(payload);
  if (!read_object(reader, class_segment, [&] { return read_segment_map(reader, out); }))
    return Reject::field;
  if (!reader.at_end()) return Reject::size;
  return out.line_count > 0 ? Reject::none : Reject::field;
}

Reject parse_msgpack(ByteView telegram, Segment& out) {
  const TelegramHead head = read_head(telegram);
  if (head.reject != Reject::none) return head.reject;
  if (head.type != TelegramType::msgpack) return Reject::magic;
  if (head.length == 0 || head.length != telegram.size()) return Reject::size;
  constexpr std::size_t head_bytes = 8, checksum_bytes = 4;
  return parse_msgpack_payload(telegram.sub(head_bytes, telegram.size() - head_bytes - checksum_bytes), out);
}

}  // namespace lidard::sick
