// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/base/bytes.h"
#include "core/base/device_clock.h"
#include "core/base/time.h"
#include "drivers/driver.h"
#include "drivers/velodyne/nmea.h"

namespace lidard::velodyne {

/// Length of the telemetry (position) packet, VLP-16 user manual 63-9243 Rev D, section 9.3.1.6.
constexpr std::size_t telemetry_size = 512;

/// State of the receiver's pulse per second as reported by the sensor (63-9243 Rev D, section 9.3.1.6).
enum class Pps : std::uint8_t { absent = 0, synchronising = 1, locked = 2, error = 3 };

/// Temperatures and the calibration of the receivers: sensors with newer firmware (VLP-32C user manual
/// 63-9325 Rev B, p. 60). Unverified: no public capture holds them.
struct SensorHealth {
  int top_board_c = 0;
  int bottom_board_c = 0;
  int since_calibration_k = 0;  ///< change since the last calibration
  std::uint32_t calibration_age_s = 0;
  bool shut_down = false;  ///< too hot or too cold to run
};

/// The inertial unit of an HDL-32E: three gyros, each beside a two-axis accelerometer. A 16-bit word holds
/// its kind (0 gyro, 1 temperature, 2 and 3 acceleration) in the upper four bits (as in all HDL-32E captures)
/// and the value in the lower twelve.
struct RawImu {
  std::array<double, 3> gyro_rad_s{};
  std::array<double, 3> temperature_c{};
  std::array<double, 3> accel_x{};  ///< m/s²
  std::array<double, 3> accel_y{};  ///< m/s²

  /// In the sensor's axes, as combined by kaarta/velodyne. Unverified except for length and direction of
  /// gravity; the zero-rate offset of the gyros (30 deg/s in one unit) is not removed.
  std::array<double, 3> angular_velocity() const { return {gyro_rad_s[1], -gyro_rad_s[0], gyro_rad_s[2]}; }
  std::array<double, 3> linear_acceleration() const {
    return {(accel_y[0] - accel_x[2]) / 2, (accel_y[1] + accel_y[2]) / 2, (accel_x[0] + accel_x[1]) / 2};
  }
};

/// One telemetry packet. Any 512 bytes can be parsed; impossible values are dropped.
struct Telemetry {
  std::uint32_t toh_us = 0;            ///< since the top of the hour of the sensor's clock; may exceed 3600 s
  std::uint8_t pps = 0;                ///< as sent; see Pps
  std::optional<SensorHealth> health;  ///< empty: not sent by the firmware (all bytes are 0)
  std::optional<RawImu> imu;           ///< empty: not an HDL-32E's
  std::string_view nmea;               ///< up to the first NUL, as sent; valid as long as the packet

  bool is(Pps state) const { return pps == static_cast<std::uint8_t>(state); }
};

/// nullopt unless it has 512 bytes.
std::optional<Telemetry> read_telemetry(ByteView packet);

/// State of the sensor's clock, from its own report and the receiver's sentences.
enum class ClockClaim : std::uint8_t {
  none,    ///< free-running, as reported
  agrees,  ///< no pulse, but the clock agrees with the receiver (HDL-32E of 2012)
  synchronising,
  synchronised,  ///< pulse and receiver agree
  pps_error,
  no_time,     ///< pulse locked, but no usable sentence: its second is unknown
  other_time,  ///< pulse locked, but the clock shows another time than the receiver
  unknown,     ///< an undocumented pulse state
  silent       ///< telemetry has stopped
};

/// Parses a sensor's telemetry packets: publishes positions, time references and inertial samples, and checks
/// the reported state of the sensor's clock.
///
/// A fix is published once per sentence; the sensor repeats a sentence until the next one. A time reference
/// is published with it if the sentence is valid, has a date (RMC) and a known age: exact to the microsecond
/// if the sensor is synchronised (source "gps_pps"), otherwise by the arrival of the first packet, late by
/// the receiver's delay ("gps_nmea").
class TelemetryReceiver {
 public:
  explicit TelemetryReceiver(const DriverConfig& config);

  /// Parses a packet; Reject::size unless it has telemetry_size bytes. Updates `info` on changes and once per
  /// second.
  Reject receive(const Packet& packet, FrameReceiver& out, DeviceInfo& info);
  /// Advances the time: an old packet expires.
  void tick(Stamp now, DeviceInfo& info);
  /// DriverConfig::time_offset, from the next packet on.
  void set_time_offset(Span offset) { time_offset_ = offset; }
  /// Resets the stream; keeps the counters.
  void restart();

  ClockClaim claim() const { return claim_; }
  std::uint64_t bad_sentences() const { return bad_sentences_; }

 private:
  bool store_sentence(std::string_view text);
  void advance_clock(std::uint32_t toh_us, Stamp arrival);
  ClockClaim judge(const Telemetry& telemetry) const;
  void send_sentence(FrameReceiver& out, bool age_known);
  void send_imu(const RawImu& raw, FrameReceiver& out);
  void describe(const Telemetry& telemetry, const Packet& packet, DeviceInfo& info);
  void set_claim(ClockClaim claim, DeviceInfo& info);
  void judge_expectation(Stamp now, DeviceInfo& info);
  Stamp host_time(Span device) const { return clock_.to_host(device) + time_offset_; }

  bool has_imu_;
  Span time_offset_;
  DeviceClock clock_;
  bool in_stream_ = false;
  Span toh_{0};
  Span device_{0};  // toh_ without the jumps at the top of the hour
  Stamp last_arrival_{};
  Stamp last_described_{};

  std::array<char, 128> text_{};
  std::size_t text_size_ = 0;
  NmeaReading nmea_;
  std::uint64_t sentences_ = 0;  // of this stream
  Stamp sentence_arrival_{};
  Span sentence_age_{0};  // by the sensor's clock, when its first packet was stamped
  std::uint64_t bad_sentences_ = 0;

  ClockClaim claim_ = ClockClaim::none;
  bool expects_pps_, warned_unsynchronised_ = false;
  std::optional<Stamp> unsynchronised_since_;
  std::uint8_t described_pps_ = 0;
  ReusedMessage<GnssFix> fix_;
  ReusedMessage<TimeReference> reference_;
  ReusedMessage<ImuSample> imu_;
};

}  // namespace lidard::velodyne
