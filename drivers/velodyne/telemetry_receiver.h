// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/base/device_clock.h"
#include "drivers/driver.h"
#include "drivers/velodyne/nmea.h"
#include "drivers/velodyne/telemetry.h"

namespace lidard::velodyne {

/// What follows from the sensor's claims about its clock and from what its receiver says.
enum class ClockClaim : std::uint8_t {
  none,    ///< free-running and says so
  agrees,  ///< no pulse, but the clock agrees with the receiver (HDL-32E of 2012)
  synchronising,
  synchronised,  ///< pulse and receiver agree
  pps_error,
  no_time,     ///< pulse locked, but no usable sentence: which second it marks is not known
  other_time,  ///< pulse locked, but the clock shows another time than the receiver
  unknown,     ///< a pulse state that no document names
  silent       ///< no telemetry any more
};

/// Takes a sensor's telemetry packets: hands on positions, time references and inertial samples, and judges
/// for diagnostics whether the sensor's clock is what it claims to be.
///
/// A fix goes out once per sentence; the sensor repeats a sentence until the next one. A time reference goes
/// out with it if the sentence is valid, has a date (RMC) and its age is known: to the microsecond if the
/// sensor is synchronised (source "gps_pps"); else by the arrival of its first packet, late by what the
/// receiver needs to send it ("gps_nmea").
class TelemetryReceiver {
 public:
  explicit TelemetryReceiver(const DriverConfig& config);

  /// One packet of telemetry_size bytes; Reject::size if it is not. Keeps `info` up to date, at most once per
  /// second unless something changes.
  Reject receive(ByteView payload, Stamp arrival, DriverOutput& out, DeviceInfo& info);
  /// Time passed: what an old packet claimed is no longer so.
  void tick(Stamp now, DeviceInfo& info);
  /// Forgets the stream, keeps what diagnostics count.
  void restart();

  ClockClaim claim() const { return claim_; }
  std::uint64_t bad_sentences() const { return bad_sentences_; }

 private:
  bool take_sentence(std::string_view text);
  void advance_clock(std::uint32_t toh_us, Stamp arrival);
  ClockClaim judge(const Telemetry& telemetry) const;
  void send_sentence(DriverOutput& out, bool age_known);
  void send_imu(const RawImu& raw, DriverOutput& out);
  void describe(const Telemetry& telemetry, Stamp arrival, DeviceInfo& info);
  void set_claim(ClockClaim claim, DeviceInfo& info);
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
  std::uint8_t described_pps_ = 0;
  ReusedMessage<GnssFix> fix_;
  ReusedMessage<TimeReference> reference_;
  ReusedMessage<ImuSample> imu_;
};

}  // namespace lidard::velodyne
