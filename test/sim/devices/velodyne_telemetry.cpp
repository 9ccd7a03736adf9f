// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/velodyne_telemetry.h"

#include <cmath>
#include <cstdio>
#include <ctime>

#include "test/sim/devices/wire.h"

namespace lidard::sim {
namespace {

// Velodyne 63-9243 ch. 9.3.2, and VeloView's vtkVelodyneHDLPositionReader for the offsets.
constexpr std::size_t position_bytes = 512;
constexpr std::size_t hour_stamp_at = 0xc6;
constexpr std::size_t pps_at = 0xca;
constexpr std::size_t nmea_at = 0xce;
// Velodyne 63-9325 p. 60.
constexpr std::size_t top_at = 0xbb;
constexpr std::size_t bottom_at = 0xbc;
constexpr std::size_t calibrated_at = 0xbd;
// HDL-32E: three times gyro, temperature, accelerations x and y in 12 bits; scales and axes as in
// kaarta/velodyne (unverified).
constexpr std::size_t inertial_at = 14;
constexpr double degrees_per_count = 0.1453;
constexpr double g_per_count = 0.001221;

void put_inertial(Wire& wire) {
  const long warm = std::lround((30.0 - 25) / degrees_per_count);
  const long one_g = std::lround(1 / g_per_count);
  for (std::size_t i = 0; i < 3; ++i) {
    wire.put16(inertial_at + 8 * i + 2, static_cast<std::uint64_t>(warm));
    // The vertical acceleration is the mean of the x of sensors 1 and 2.
    if (i < 2) wire.put16(inertial_at + 8 * i + 4, static_cast<std::uint64_t>(one_g));
  }
}

}  // namespace

std::vector<std::uint8_t> position_packet(const PositionState& state) {
  Wire wire(position_bytes);
  if (state.kind == VelodyneTelemetry::inertial) put_inertial(wire);
  if (state.kind == VelodyneTelemetry::temperatures) {
    wire.put8(top_at, 41);
    wire.put8(bottom_at, 38);
    wire.put8(calibrated_at, 40);
  }
  wire.put32(hour_stamp_at, state.device_us);
  wire.put8(pps_at, state.pps_locked ? 2 : 0);
  const std::string sentence = gprmc(state.utc, state.pps_locked);
  wire.copy(nmea_at, sentence.data(), sentence.size());
  return wire.take();
}

std::string gprmc(Stamp time, bool valid) {
  const std::time_t second = static_cast<std::time_t>(time.ns / 1'000'000'000);
  std::tm utc{};
  gmtime_r(&second, &utc);
  char when[2][16];
  std::strftime(when[0], sizeof when[0], "%H%M%S", &utc);
  std::strftime(when[1], sizeof when[1], "%d%m%y", &utc);
  const std::string body = std::string("GPRMC,") + when[0] + (valid ? ",A" : ",V") +
                           ",0000.0000,N,00000.0000,E,000.0,000.0," + when[1] + ",000.0,E";
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof end, "*%02X\r\n", sum & 0xffU);
  return "$" + body + end;
}

}  // namespace lidard::sim
