// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/driver.h"

namespace lidard::test {

using Bytes = std::vector<std::uint8_t>;

/// Appends fields one after the other, as the tables of SICK 8022708 list them: there are no offsets here
/// that could share a mistake with the parser.
class Writer {
 public:
  Bytes bytes;
  Writer& u8(std::uint32_t v) { return number(v, 1); }
  Writer& u16(std::uint32_t v) { return number(v, 2); }
  Writer& u24(std::uint32_t v) { return number(v, 3); }
  Writer& u32(std::uint32_t v) { return number(v, 4); }
  Writer& zeros(std::size_t n) {
    bytes.resize(bytes.size() + n);
    return *this;
  }
  Writer& append(const Bytes& more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
    return *this;
  }

 private:
  Writer& number(std::uint32_t v, int n) {
    for (int i = 0; i < n; ++i) bytes.push_back(static_cast<std::uint8_t>(v >> (8 * i)));
    return *this;
  }
};

struct RawBeam {
  std::uint16_t distance = 1408;
  std::uint8_t reflectivity = 26;
  std::uint8_t status = 1;
};

/// An instance of the data output; the defaults are the values of SICK 8022708 table 64 where it prints them.
struct Ms3Sample {
  std::uint8_t indicator = 'R', major = 2;
  std::uint32_t serial = 17479021, plug = 17469324, sequence = 0x261, scan = 0x27c;
  std::uint8_t channel = 0;
  std::uint32_t time_ms = 0x58d4;
  bool with_state = true, with_derived = true, with_measurement = true, with_intrusion = true,
       with_application = true, with_local_io = false;
  std::uint8_t state_flags = 1, errors = 0;
  std::uint32_t safe_paths = 0x55, non_safe_paths = 0xff, reset_paths = 0;
  std::array<std::uint8_t, 4> cases{{1, 0, 0, 0}};
  std::uint16_t factor = 1, scan_time_ms = 30;
  std::int32_t start = -44290624, step = 2151928;  // 1/4194304 deg: -10.5597, 0.51306
  std::uint32_t period_us = 43;
  std::vector<RawBeam> beams = std::vector<RawBeam>(48);
  std::array<Bytes, 24> intrusion;
  std::uint8_t standby_state = 2;
  int announced_beams = -1;  ///< -1: the truth

  Bytes instance() const;

 private:
  Bytes application() const;
};

inline Bytes Ms3Sample::application() const {
  Writer w;
  // Inputs: sources, flags, reserved; case numbers; flags; velocities; flags; reserved; standby; reserved.
  w.u32(3).u32(0xf).zeros(4);
  for (std::uint32_t i = 0; i < 20; ++i) w.u16(i == 0 ? cases[0] : 100 + i);
  w.u32(1).u16(0xfff6).u16(20).u8(0x33).zeros(3).zeros(10).u8(2).zeros(1).zeros(64);
  // Outputs: cut-off paths, safe, valid; case numbers; flags; standby state; reserved; velocities ...
  w.u32(0x11).u32(0x1).u32(0xfff);
  for (std::uint32_t i = 0; i < 20; ++i) w.u16(i == 0 ? cases[0] : 200 + i);
  w.u32(1).u8(standby_state).zeros(3).u16(0xff9c).u16(7).u8(0x11).zeros(3);
  for (std::uint32_t i = 0; i < 20; ++i) w.u16(0xffff - i);
  w.u32(0xfffff).zeros(7).u8(3).zeros(4);
  return w.bytes;
}

inline Bytes Ms3Sample::instance() const {
  std::array<Bytes, 6> blocks;
  if (with_state) {
    Writer w;
    w.u8(state_flags).u24(safe_paths).u24(non_safe_paths).u24(reset_paths);
    for (const auto number : cases) w.u8(number);
    blocks[0] = w.zeros(1).u8(errors).bytes;
  }
  const auto count = static_cast<std::uint32_t>(beams.size());
  if (with_derived) {
    Writer w;
    w.u16(factor).u16(announced_beams < 0 ? count : static_cast<std::uint32_t>(announced_beams));
    w.u16(scan_time_ms).zeros(2).u32(static_cast<std::uint32_t>(start)).u32(static_cast<std::uint32_t>(step));
    blocks[1] = w.u32(period_us).zeros(4).bytes;
  }
  if (with_measurement) {
    Writer w;
    w.u32(count);
    for (const RawBeam& b : beams) w.u16(b.distance).u8(b.reflectivity).u8(b.status);
    blocks[2] = w.bytes;
  }
  if (with_intrusion) {
    Writer w;
    for (const Bytes& path : intrusion) w.u32(static_cast<std::uint32_t>(path.size())).append(path);
    blocks[3] = w.bytes;
  }
  if (with_application) blocks[4] = application();
  if (with_local_io) blocks[5] = Bytes(64, 0xab);
  Writer head;
  head.u8(indicator).u8(major).u8(0).u8(0).u32(serial).u32(plug).u8(channel).zeros(3).u32(sequence).u32(scan);
  head.u16(0).zeros(2).u32(time_ms);
  std::uint32_t at = 76;
  Writer body;
  for (const Bytes& block : blocks) {
    head.u16(block.empty() ? 0 : at).u16(static_cast<std::uint32_t>(block.size()));
    // The manual allows holes between the blocks.
    if (!block.empty()) body.append(block).zeros(4);
    if (!block.empty()) at += static_cast<std::uint32_t>(block.size()) + 4;
  }
  return head.zeros(20).append(body.bytes).bytes;
}

/// A datagram of an instance (table 1).
inline Bytes ms3_datagram(std::uint32_t total, std::uint32_t identification, std::uint32_t offset,
                          const Bytes& data) {
  Writer w;
  for (const char c : std::string("MS3 MD")) w.u8(static_cast<std::uint8_t>(c));
  return w.u8(1).u8(0).u32(total).u32(identification).u32(offset).zeros(4).append(data).bytes;
}

/// The datagrams of an instance; a device puts 1436 bytes of it into each.
inline std::vector<Bytes> ms3_datagrams(const Bytes& instance, std::uint32_t identification,
                                        std::size_t piece = 1436) {
  std::vector<Bytes> list;
  for (std::size_t at = 0; at < instance.size(); at += piece) {
    const std::size_t end = std::min(instance.size(), at + piece);
    list.push_back(ms3_datagram(static_cast<std::uint32_t>(instance.size()), identification,
                                static_cast<std::uint32_t>(at),
                                Bytes(instance.begin() + static_cast<std::ptrdiff_t>(at),
                                      instance.begin() + static_cast<std::ptrdiff_t>(end))));
  }
  return list;
}

constexpr Stamp ms3_epoch{1'767'225'600'000'000'000};

/// A packet around bytes that must outlive it.
inline Packet packet_of(const Bytes& bytes, Stamp arrival = ms3_epoch, std::uint8_t host = 21) {
  return {ByteView(bytes.data(), bytes.size()),
          arrival,
          {IpAddress::v4(192, 168, 0, host), 50000},
          {IpAddress::v4(192, 168, 0, 1), 6060}};
}

}  // namespace lidard::test
