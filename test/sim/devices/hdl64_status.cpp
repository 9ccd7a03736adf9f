// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/hdl64_status.h"

#include <cmath>
#include <ctime>

#include "test/sim/devices/wire.h"

namespace lidard::sim {
namespace {

// Order and meaning: HDL-64E S3 manual 63-HDL64ES3 p. 32-38, velodyne_decoder hdl64e.py.
constexpr std::size_t cycle_packets = 16;
constexpr std::size_t bytes_per_cycle = 7;
constexpr std::size_t cycles = Hdl64Status::calibration_bytes / bytes_per_cycle;
constexpr std::size_t record_at = 7;
constexpr std::size_t record_bytes = 28;
constexpr std::size_t record_used = 21;
constexpr std::size_t tail_at = Hdl64Status::calibration_bytes - 28;
constexpr std::uint8_t temperature = 42;  // deg C

std::uint64_t hundredths(double degrees) {
  return static_cast<std::uint64_t>(std::llround(degrees * 100)) & 0xffffU;
}

void put_laser(Wire& wire, std::size_t id, const VelodyneLaser& laser) {
  const std::size_t at = record_at + id * record_bytes;
  wire.put8(at, id);
  wire.put16(at + 1, hundredths(laser.elevation_deg));
  wire.put16(at + 3, hundredths(laser.rot_correction_deg));
  // Distance corrections, offsets and focal values: this unit needs none.
  wire.put8(at + 20, 255);  // brightest intensity
}

// The checksum of S3 covers each record without its number and the unused rest (velodyne_decoder): CRC-16,
// polynomial 0x8005, most significant bit first, from 0.
std::uint16_t checksum(const std::vector<std::uint8_t>& bytes) {
  unsigned sum = 0;
  for (std::size_t record = record_at; record + record_bytes <= tail_at + bytes_per_cycle;
       record += record_bytes) {
    for (std::size_t i = 1; i < record_used; ++i) {
      sum ^= static_cast<unsigned>(bytes[record + i]) << 8U;
      for (int bit = 0; bit < 8; ++bit) sum = (sum & 0x8000U) != 0 ? (sum << 1U) ^ 0x8005U : sum << 1U;
      sum &= 0xffffU;
    }
  }
  return static_cast<std::uint16_t>(sum);
}

void put_tail(Wire& wire, const Hdl64State& state) {
  const std::uint8_t calibrated[] = {16, 11, 15, 12, 47, 47};  // 2016-11-15 12:47:47
  wire.copy(tail_at, calibrated, sizeof calibrated);
  wire.put8(tail_at + 6, 25);  // humidity, %
  wire.put16(tail_at + 7, static_cast<std::uint64_t>(std::lround(state.rpm)));
  wire.put16(tail_at + 9, 0);  // field of view
  wire.put16(tail_at + 11, 36000);
  wire.put16(tail_at + 13, 2685);  // hours of operation
  const std::uint8_t addresses[] = {192, 168, 3, 43, 192, 168, 3, 255};
  wire.copy(tail_at + 15, addresses, sizeof addresses);
  wire.put8(tail_at + 23, state.dual ? 2 : state.last ? 1 : 0);
  wire.put8(tail_at + 25, 0xa0);  // power level
}

// Types of the tail's special bytes; others count '1' to '7'.
std::uint8_t tail_type(std::size_t offset, std::uint8_t otherwise) {
  switch (offset) {
    case 7:
      return 0xfe;
    case 8:
      return 0xff;
    case 9:
      return 0xfc;
    case 10:
      return 0xfd;
    case 11:
      return 0xfa;
    case 12:
      return 0xfb;
    case 23:
      return 0xf9;
    case 25:
      return 0xf8;
    default:
      return otherwise;
  }
}

}  // namespace

Hdl64Status::Hdl64Status(const VelodyneLasers& lasers, const Hdl64State& state) : state_(state) {
  Wire wire(calibration_bytes);
  wire.copy(0, "UNIT#", 5);
  wire.put8(5, 24);  // noise thresholds of both blocks
  wire.put8(6, 24);
  for (std::size_t id = 0; id < lasers.size(); ++id) put_laser(wire, id, lasers[id]);
  put_tail(wire, state_);
  wire.put8(tail_at + 24, state_.s3 ? 0 : warnings());
  // S2 writes only the length.
  wire.put16(tail_at + 26, state_.s3 ? checksum(wire.bytes()) : calibration_bytes);
  calibration_ = wire.take();
}

std::uint8_t Hdl64Status::warnings() const { return state_.synchronised ? 0x60 : 0; }

std::array<std::uint8_t, 2> Hdl64Status::calibration_byte(std::size_t index) const {
  const std::size_t place = index % bytes_per_cycle;
  const std::size_t cycle = index / bytes_per_cycle;
  // The last quarter of a laser's record holds nothing, except for the last laser's, where the tail begins.
  if (state_.s3 && place == 0 && cycle % 4 == 0 && cycle != 0 && index < tail_at) return {'W', warnings()};
  const auto type = static_cast<std::uint8_t>('1' + place);
  return {index < tail_at ? type : tail_type(index - tail_at, type), calibration_[index]};
}

std::array<std::uint8_t, 2> Hdl64Status::at(std::size_t number, Stamp now) const {
  const std::size_t place = number % cycle_packets;
  const std::size_t cycle = number / cycle_packets % cycles;
  if (place >= 9) return calibration_byte(cycle * bytes_per_cycle + place - 9);
  const std::time_t second = static_cast<std::time_t>(now.ns / 1'000'000'000);
  std::tm utc{};
  gmtime_r(&second, &utc);
  const int values[] = {utc.tm_hour,
                        utc.tm_min,
                        utc.tm_sec,
                        utc.tm_mday,
                        utc.tm_mon + 1,
                        utc.tm_year % 100,
                        state_.synchronised ? 'A' : 0,
                        temperature,
                        state_.s3 ? 0xe3 : 0x47};
  return {static_cast<std::uint8_t>("HMSDNYGTV"[place]), static_cast<std::uint8_t>(values[place])};
}

}  // namespace lidard::sim
