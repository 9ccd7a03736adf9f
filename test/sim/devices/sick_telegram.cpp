// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/sick_telegram.h"

#include <algorithm>
#include <boost/crc.hpp>
#include <cmath>

#include "test/sim/devices/wire.h"

namespace lidard::sim {
namespace {

constexpr std::uint32_t start_mark = 0x02020202;

void add8(Wire& wire, std::uint64_t value) { wire.put8(wire.size(), value); }
void add16(Wire& wire, std::uint64_t value) { wire.put16(wire.size(), value); }
void add32(Wire& wire, std::uint64_t value) { wire.put32(wire.size(), value); }
void add64(Wire& wire, std::uint64_t value) { wire.put64(wire.size(), value); }
void add_float(Wire& wire, double value) {
  const auto single = static_cast<float>(value);
  wire.copy(wire.size(), &single, sizeof single);
}
void add_bytes(Wire& wire, const SickBytes& bytes) { wire.copy(wire.size(), bytes.data(), bytes.size()); }

std::uint32_t crc_of(const SickBytes& bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

std::uint64_t theta_count(double theta) {
  return static_cast<std::uint64_t>(std::lround(theta * 5215) + 16384);
}

void add_beam(Wire& wire, const SickSegment& segment, const SickBeam& beam, std::uint32_t version) {
  for (const SickEcho& echo : beam.echoes) {
    add16(wire, static_cast<std::uint64_t>(std::lround(echo.mm / segment.scale)));
    if (segment.with_rssi) add16(wire, echo.rssi);
  }
  if (version < 4 && segment.with_theta) add16(wire, theta_count(beam.theta));
  if (segment.with_properties) add8(wire, beam.reflector ? 1 : 0);
  if (version >= 4 && segment.with_theta) add16(wire, theta_count(beam.theta));
}

/// A module without the size of its successor, and where that goes.
Wire module_of(const SickSegment& segment, const std::vector<SickLine>& lines, std::uint32_t version,
               std::size_t& next_at) {
  Wire wire;
  add64(wire, segment.index);
  add64(wire, segment.frame);
  add32(wire, segment.sender);
  add32(wire, lines.size());
  add32(wire, lines.front().beams.size());
  add32(wire, lines.front().beams.front().echoes.size());
  for (const SickLine& line : lines) add64(wire, line.start_us);
  for (const SickLine& line : lines) add64(wire, line.stop_us);
  for (const SickLine& line : lines) add_float(wire, line.elevation);
  for (const SickLine& line : lines) add_float(wire, line.theta_start);
  for (const SickLine& line : lines) add_float(wire, line.theta_stop);
  if (version >= 4) add_float(wire, segment.scale);
  next_at = wire.size();
  add32(wire, 0);
  add8(wire, 1);
  add8(wire, segment.with_rssi ? 3 : 1);
  add8(wire, (segment.with_properties ? 1U : 0U) | (segment.with_theta ? 2U : 0U));
  add8(wire, 0);
  for (std::size_t b = 0; b < lines.front().beams.size(); ++b) {
    for (const SickLine& line : lines) add_beam(wire, segment, line.beams[b], version);
  }
  return wire;
}

// MessagePack, as far as the telegrams use it.
void pack_uint(Wire& wire, std::uint64_t value) {
  if (value < 0x80) return add8(wire, value);
  const int width = value < 0x100 ? 0 : value < 0x10000 ? 1 : value < 0x100000000 ? 2 : 3;
  add8(wire, 0xccU + static_cast<unsigned>(width));
  for (int byte = (1 << width) - 1; byte >= 0; --byte) add8(wire, value >> 8 * byte & 0xffU);
}
void pack_float(Wire& wire, double value) {
  const auto single = static_cast<float>(value);
  SickBytes bytes(4);
  std::copy_n(reinterpret_cast<const std::uint8_t*>(&single), 4, bytes.rbegin());
  add8(wire, 0xca);
  add_bytes(wire, bytes);
}
void pack_map(Wire& wire, std::size_t pairs) { add8(wire, 0x80U + pairs); }
void pack_array(Wire& wire, std::size_t values) {
  if (values < 16) return add8(wire, 0x90U + values);
  add8(wire, 0xdc);
  add8(wire, values >> 8U);
  add8(wire, values & 0xffU);
}
void pack_key(Wire& wire, std::uint64_t key, std::uint64_t value) {
  pack_uint(wire, key);
  pack_uint(wire, value);
}
void pack_column(Wire& wire, const Wire& values, std::size_t size, std::uint64_t type) {
  pack_map(wire, 5);
  pack_key(wire, 0x12, values.size() / size);
  pack_key(wire, 0x13, size);
  pack_key(wire, 0x14, 0x30);
  pack_uint(wire, 0x15);
  pack_array(wire, 1);
  pack_uint(wire, type);
  pack_uint(wire, 0x11);
  add8(wire, 0xc5);
  add8(wire, values.size() >> 8U);
  add8(wire, values.size() & 0xffU);
  add_bytes(wire, values.bytes());
}

/// One value of each beam of a line.
template <class Put>
Wire column_of(const SickLine& line, Put&& put) {
  Wire values;
  for (const SickBeam& beam : line.beams) put(values, beam);
  return values;
}

void pack_echoes(Wire& wire, const SickLine& line, std::uint64_t key, bool rssi) {
  const std::size_t echoes = line.beams.front().echoes.size();
  pack_uint(wire, key);
  pack_array(wire, echoes);
  for (std::size_t e = 0; e < echoes; ++e) {
    const Wire values = column_of(line, [&](Wire& to, const SickBeam& beam) {
      if (rssi)
        add16(to, beam.echoes[e].rssi);
      else
        add_float(to, beam.echoes[e].mm);
    });
    pack_column(wire, values, rssi ? 2 : 4, rssi ? 0x34 : 0x31);
  }
}

void pack_line(Wire& wire, const SickSegment& segment, const SickLine& line) {
  pack_map(wire, 2);
  pack_key(wire, 0x10, 0x70);
  pack_uint(wire, 0x11);
  pack_map(wire, 8U + (segment.with_theta ? 1U : 0U) + (segment.with_rssi ? 1U : 0U) +
                     (segment.with_properties ? 1U : 0U));
  pack_key(wire, 0x71, line.start_us);
  pack_key(wire, 0x72, line.stop_us);
  pack_uint(wire, 0x73);
  pack_float(wire, line.theta_start);
  pack_uint(wire, 0x74);
  pack_float(wire, line.theta_stop);
  if (segment.with_theta) {
    pack_uint(wire, 0x50);
    pack_column(wire, column_of(line, [](Wire& to, const SickBeam& beam) { add_float(to, beam.theta); }), 4,
                0x31);
  }
  Wire phi;
  add_float(phi, line.elevation);
  pack_uint(wire, 0x51);
  pack_column(wire, phi, 4, 0x31);
  pack_echoes(wire, line, 0x52, false);
  if (segment.with_rssi) pack_echoes(wire, line, 0x53, true);
  if (segment.with_properties) {
    pack_uint(wire, 0x54);
    pack_array(wire, 1);
    const auto put = [](Wire& to, const SickBeam& beam) { add8(to, beam.reflector ? 1 : 0); };
    pack_column(wire, column_of(line, put), 1, 0x33);
  }
  pack_key(wire, 0x77, line.beams.size());
  pack_key(wire, 0x78, line.beams.front().echoes.size());
}

SickBytes with_crc(Wire& wire) {
  add32(wire, crc_of(wire.bytes()));
  return wire.take();
}

}  // namespace

SickBytes compact_scan(const SickSegment& segment, std::uint32_t version) {
  std::vector<Wire> modules;
  std::vector<std::size_t> next_at(segment.modules.size());
  for (std::size_t i = 0; i < segment.modules.size(); ++i)
    modules.push_back(module_of(segment, segment.modules[i], version, next_at[i]));
  for (std::size_t i = 0; i + 1 < modules.size(); ++i) modules[i].put32(next_at[i], modules[i + 1].size());
  Wire wire;
  add32(wire, start_mark);
  add32(wire, 1);
  add64(wire, segment.counter);
  add64(wire, segment.transmit_us);
  add32(wire, version);
  add32(wire, modules.front().size());
  for (const Wire& module : modules) add_bytes(wire, module.bytes());
  return with_crc(wire);
}

SickBytes compact_imu(std::uint64_t time_us, const std::array<float, 3>& acceleration,
                      const std::array<float, 3>& rate, const std::array<float, 4>& wxyz) {
  Wire wire;
  add32(wire, start_mark);
  add32(wire, 2);
  add32(wire, 1);
  for (const float value : acceleration) add_float(wire, static_cast<double>(value));
  for (const float value : rate) add_float(wire, static_cast<double>(value));
  for (const float value : wxyz) add_float(wire, static_cast<double>(value));
  add64(wire, time_us);
  return with_crc(wire);
}

SickBytes msgpack_scan(const SickSegment& segment) {
  Wire payload;
  pack_map(payload, 2);
  pack_key(payload, 0x10, 0x90);
  pack_uint(payload, 0x11);
  pack_map(payload, 8);
  pack_key(payload, 0xb0, segment.counter);
  pack_key(payload, 0xb1, segment.transmit_us);
  pack_key(payload, 0x91, segment.index);
  pack_key(payload, 0x92, segment.frame);
  pack_uint(payload, 0x93);
  add8(payload, 0xc3);
  pack_key(payload, 0x94, segment.sender);
  std::size_t lines = 0;
  for (const auto& module : segment.modules) lines += module.size();
  pack_uint(payload, 0xa0);
  pack_array(payload, lines);
  for (std::size_t i = 1; i <= lines; ++i) pack_uint(payload, i);
  pack_uint(payload, 0x96);
  pack_array(payload, lines);
  for (const auto& module : segment.modules) {
    for (const SickLine& line : module) pack_line(payload, segment, line);
  }
  Wire wire;
  add32(wire, start_mark);
  add32(wire, payload.size());
  add_bytes(wire, payload.bytes());
  add32(wire, crc_of(payload.bytes()));
  return wire.take();
}

}  // namespace lidard::sim
