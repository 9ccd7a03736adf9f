// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/telemetry.h"

#include <algorithm>

#include "core/base/angle.h"

namespace lidard::velodyne {
namespace {

// Offsets of 63-9325 Rev B, p. 60; those from 0xC6 on hold for every model (measured on VLP-16 and HDL-32E).
constexpr std::size_t health_offset = 0xBB;
constexpr std::size_t calibration_end = 0xC6;
constexpr std::size_t toh_offset = 0xC6;
constexpr std::size_t pps_offset = 0xCA;
constexpr std::size_t thermal_offset = 0xCB;
constexpr std::size_t nmea_offset = 0xCE;
constexpr std::size_t nmea_size = 128;

// HDL-32E user manual, appendix B, and VeloView's vtkVelodyneHDLPositionReader.
constexpr std::size_t imu_offset = 14;
constexpr double gyro_step = 0.09766 / 180 * pi_d;  // rad/s
constexpr double temperature_step_c = 0.1453;
constexpr double temperature_at_zero_c = 25;
constexpr double accel_step = 0.001221 * 9.80665;  // m/s²

int signed8(std::uint8_t byte) { return static_cast<std::int8_t>(byte); }
int signed16(std::uint16_t word) { return static_cast<std::int16_t>(word); }
int signed12(std::uint16_t word) { return signed16(static_cast<std::uint16_t>(word << 4U)) / 16; }

std::optional<SensorHealth> read_health(ByteView p) {
  const auto tells = [&p](std::size_t begin, std::size_t end) {
    return std::any_of(p.begin() + begin, p.begin() + end, [](std::uint8_t b) { return b != 0; });
  };
  if (!tells(health_offset, calibration_end) && !tells(thermal_offset, nmea_offset)) return std::nullopt;
  SensorHealth health;
  health.top_board_c = signed8(p.u8(0xBB));
  health.bottom_board_c = signed8(p.u8(0xBC));
  health.at_calibration_c = signed8(p.u8(0xBD));
  health.since_calibration_k = signed16(p.le16(0xBE));
  health.calibration_age_s = p.le32(0xC0);
  health.calibration_reason = p.u8(0xC4);
  health.calibration_flags = p.u8(0xC5);
  health.shut_down = p.u8(thermal_offset) != 0;
  health.at_shutdown_c = signed8(p.u8(0xCC));
  health.at_power_up_c = signed8(p.u8(0xCD));
  return health;
}

std::optional<RawImu> read_imu(ByteView p) {
  RawImu imu;
  for (std::size_t unit = 0; unit < 3; ++unit) {
    std::array<int, 4> value{};
    for (unsigned kind = 0; kind < 4; ++kind) {
      const std::uint16_t word = p.le16(imu_offset + unit * 8 + kind * 2);
      if (word >> 12U != kind) return std::nullopt;
      value[kind] = signed12(word);
    }
    imu.gyro_rad_s[unit] = value[0] * gyro_step;
    imu.temperature_c[unit] = temperature_at_zero_c + value[1] * temperature_step_c;
    imu.accel_x[unit] = value[2] * accel_step;
    imu.accel_y[unit] = value[3] * accel_step;
  }
  return imu;
}

}  // namespace

std::optional<Telemetry> read_telemetry(ByteView packet) {
  if (packet.size() != telemetry_size) return std::nullopt;
  Telemetry telemetry;
  telemetry.toh_us = packet.le32(toh_offset);
  telemetry.pps = packet.u8(pps_offset);
  telemetry.health = read_health(packet);
  telemetry.imu = read_imu(packet);
  const std::string_view field = packet.sub(nmea_offset, nmea_size).text();
  telemetry.nmea = field.substr(0, field.find('\0'));
  return telemetry;
}

Span hour_difference(Span a, Span b) {
  constexpr Span hour = std::chrono::hours(1);
  const Span difference = (a - b) % hour;
  if (difference > hour / 2) return difference - hour;
  return difference <= -hour / 2 ? difference + hour : difference;
}

}  // namespace lidard::velodyne
