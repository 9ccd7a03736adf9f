// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/base/bytes.h"
#include "core/base/time.h"

namespace lidard::velodyne {

/// Length of the telemetry (position) packet, VLP-16 user manual 63-9243 Rev D, section 9.3.1.6.
constexpr std::size_t telemetry_size = 512;

/// What the sensor says of the pulse per second of its receiver (63-9243 Rev D, section 9.3.1.6).
enum class Pps : std::uint8_t { absent = 0, synchronising = 1, locked = 2, error = 3 };

/// Temperatures and the calibration of the receivers: sensors with newer firmware (VLP-32C user manual
/// 63-9325 Rev B, p. 60). Unverified: no public capture holds them.
struct SensorHealth {
  int top_board_c = 0;
  int bottom_board_c = 0;
  int at_calibration_c = 0;
  int since_calibration_k = 0;  ///< change since the last calibration
  std::uint32_t calibration_age_s = 0;
  std::uint8_t calibration_reason = 0;  ///< 0 none, 1 power-on, 2 manual, 3 temperature, 4 periodic
  std::uint8_t calibration_flags = 0;   ///< bit 0 in progress, 1 temperature limit, 2 period exceeded
  bool shut_down = false;               ///< too hot or too cold to run
  int at_shutdown_c = 0;
  int at_power_up_c = 0;
};

/// The inertial unit of an HDL-32E: three gyros, each beside a two-axis accelerometer. Each 16-bit word holds
/// its kind (0 gyro, 1 temperature, 2 and 3 acceleration) in the upper four bits, which all HDL-32E captures
/// show; the value in the lower twelve.
struct RawImu {
  std::array<double, 3> gyro_rad_s{};
  std::array<double, 3> temperature_c{};
  std::array<double, 3> accel_x{};  ///< m/s²
  std::array<double, 3> accel_y{};  ///< m/s²

  /// In the sensor's axes, as kaarta/velodyne combines them. Unverified but for the length of gravity and
  /// which way is up; the zero-rate offset of the gyros (30 deg/s in one unit) is not taken off.
  std::array<double, 3> angular_velocity() const { return {gyro_rad_s[1], -gyro_rad_s[0], gyro_rad_s[2]}; }
  std::array<double, 3> linear_acceleration() const {
    return {(accel_y[0] - accel_x[2]) / 2, (accel_y[1] + accel_y[2]) / 2, (accel_x[0] + accel_x[1]) / 2};
  }
};

/// One telemetry packet. Any 512 bytes can be read; what they cannot mean is left out.
struct Telemetry {
  std::uint32_t toh_us = 0;            ///< since the top of the hour of the sensor's clock; may exceed 3600 s
  std::uint8_t pps = 0;                ///< as sent; see Pps
  std::optional<SensorHealth> health;  ///< empty: the firmware does not tell (all its bytes are 0)
  std::optional<RawImu> imu;           ///< empty: not an HDL-32E's
  std::string_view nmea;               ///< up to the first NUL, as sent; lives as long as the packet

  bool is(Pps state) const { return pps == static_cast<std::uint8_t>(state); }
};

/// nullopt unless it has 512 bytes.
std::optional<Telemetry> read_telemetry(ByteView packet);

/// `a - b` of two times that count within the hour, the shorter way round: within half an hour.
Span hour_difference(Span a, Span b);

}  // namespace lidard::velodyne
