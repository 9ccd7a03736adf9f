// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/counters.h"
#include "core/base/device_clock.h"
#include "core/base/time.h"
#include "drivers/driver_base.h"
#include "drivers/sick/cola/cola_row.h"
#include "drivers/sick/cola/cola_stream.h"

namespace lidard::sick {

/// One output channel of LMDscandata: DIST1...5, RSSI1...5, ANGL1, VANG1, REFL1 ...
struct ColaChannel {
  std::array<char, 5> letters{};
  float scale = 1, offset = 0;  ///< value = raw * scale + offset (DIST: mm)
  double start_deg = 0;         ///< of the first value, as the device counts
  double step_deg = 0;
  bool wide = true;                   ///< 16 bits, else 8
  std::vector<std::uint16_t> values;  ///< raw

  std::string_view name() const { return {letters.data(), letters.size()}; }
  double value(std::size_t i) const { return static_cast<double>(values[i]) * scale + offset; }
};

/// Names of the channels of each echo.
constexpr std::array<std::string_view, 5> distance_names = {"DIST1", "DIST2", "DIST3", "DIST4", "DIST5"};
constexpr std::array<std::string_view, 5> intensity_names = {"RSSI1", "RSSI2", "RSSI3", "RSSI4", "RSSI5"};

/// The telegram LMDscandata (SICK 8014631 chapter 4.3.4; SICK 8013796, LMS500, p. 81-83), read from the
/// first field to the last. Keeps its memory from telegram to telegram.
struct ColaScan {
  static constexpr std::size_t most_channels = 24;
  static constexpr std::size_t most_encoders = 4;
  struct Encoder {
    std::int32_t position = 0;  ///< ticks
    std::int16_t speed = 0;     ///< ticks/mm
  };

  std::uint32_t serial = 0;
  std::array<std::uint8_t, 2> status{};  ///< 0 0: no error
  std::uint16_t telegram_counter = 0, scan_counter = 0;
  std::uint32_t start_us = 0;     ///< since the device started; wraps after 71.6 min
  std::uint32_t transmit_us = 0;  ///< time of transmission, same clock
  std::int16_t layer = 0;         ///< 1/100 deg downwards on MRS1000, else reserved
  double scan_hz = 0;             ///< telegrams (scans, or layers) per second
  double measurement_hz = 0;      ///< measurements per second
  std::array<Encoder, most_encoders> encoders{};
  std::size_t encoder_count = 0;
  std::array<ColaChannel, most_channels> channels{};
  std::size_t channel_count = 0;
  std::array<char, 256> name_text{};
  std::size_t name_size = 0;

  std::string_view name() const { return {name_text.data(), name_size}; }
  /// The channel of that name ("DIST1"), or nullptr.
  const ColaChannel* channel(std::string_view name) const;
  /// Number of channels DIST1, DIST2, ...; a device may be set to send a later echo without the first one.
  std::size_t echo_count() const;
  /// The index in distance_names of the k-th echo that the telegram holds.
  std::size_t echo(std::size_t k) const;
  /// Its distances.
  const ColaChannel& distance(std::size_t k) const { return *channel(distance_names.at(echo(k))); }
  /// Its intensities, or nullptr. An LMS4000 that is set to remission in percent sends REFL1 (SICK 8027168 p.
  /// 55).
  const ColaChannel* intensity(std::size_t k) const;
};

/// The scan as SOPAS ET subscribes to it: the layout of LMDscandata (recorded from a TiM781S).
constexpr std::string_view monitor_scan = "LMDscandatamon";
/// True for "sSN LMDscandata", the polled "sRA LMDscandata" and both of LMDscandatamon.
bool is_cola_scan(const ColaTelegram& telegram);
/// Reads a scan in either dialect. Returns its fault, or Reject::none; `scan` is complete only then.
Reject parse_cola_scan(const ColaTelegram& telegram, ColaScan& scan);

/// The microseconds since start-up in the telegrams, unwrapped and mapped to host time.
class ColaClock {
 public:
  explicit ColaClock(ClockMode mode) : clock_(mode) {}

  /// Adds a telegram with its two times; `rest` of the measurement follows the start time; it is used if the
  /// device sends no time of transmission. A device that sends 0 has no clock: telegrams are placed by their
  /// arrivals, or `period` apart where these stand. Returns the unwrapped start time.
  Span observe(std::uint32_t start_us, std::uint32_t transmit_us, Span rest, Span period, Stamp arrival) {
    sends_time_ = start_us != 0 || (started_ && start_us_ != 0);
    if (!started_) {
      device_ = std::chrono::microseconds(start_us);
    } else if (!sends_time_) {
      device_ += clock_.stands(device_ + period + rest, arrival) ? period : arrival - arrival_;
    } else {
      const Span ahead = std::chrono::microseconds(start_us - start_us_);
      if (start_us < start_us_) ++wraps_;
      // A long silence may span several wraps.
      const double wraps = seconds(arrival - arrival_ - ahead) / seconds(wrap);
      device_ += ahead + wrap * static_cast<std::int64_t>(std::max(0.0, std::round(wraps)));
    }
    started_ = true;
    start_us_ = start_us;
    arrival_ = arrival;
    const Span way = std::chrono::microseconds(transmit_us - start_us);
    const bool is_sent = transmit_us != 0 && way <= longest_way;
    if (is_sent) shortest_way_ = std::min(shortest_way_.value_or(way), way);
    clock_.observe(device_ + (is_sent ? way : rest), arrival);
    return device_;
  }
  /// The shortest time from a telegram's start time to its transmission so far; none: the device sends none.
  const std::optional<Span>& shortest_way() const { return shortest_way_; }
  /// The device measures at another rate.
  void forget_ways() { shortest_way_.reset(); }
  /// The unwrapped time nearest to the last telegram.
  Span near_last(std::uint32_t time_us) const {
    return device_ + std::chrono::microseconds(static_cast<std::int32_t>(time_us - start_us_));
  }
  Stamp to_host(Span device) const { return clock_.to_host(device); }
  bool ready() const { return started_; }
  std::uint64_t steps() const { return clock_.steps(); }
  /// False if the device sends 0 instead of its time.
  bool sends_time() const { return sends_time_; }
  /// Number of overflows (one per 71.6 min).
  std::uint64_t wraps() const { return wraps_; }
  const DeviceClock& clock() const { return clock_; }
  /// The telegrams so far come once more; what they showed of the clock stays.
  void repeat() { started_ = false; }
  /// Forgets the time of the device, which may have restarted; its drift stays known.
  void restart() {
    started_ = false;
    forget_ways();
    clock_.restart();
  }
  /// Resets the clock for another device or recording with unrelated times.
  void reset() {
    started_ = false;
    forget_ways();
    clock_.reset();
  }

 private:
  static constexpr Span wrap = std::chrono::microseconds(std::int64_t{1} << 32);
  /// A longer time from measurement to transmission means that the field is empty.
  static constexpr Span longest_way = std::chrono::seconds(10);

  DeviceClock clock_;
  bool started_ = false, sends_time_ = true;
  std::optional<Span> shortest_way_;
  std::uint64_t wraps_ = 0;
  std::uint32_t start_us_ = 0;
  Span device_{0};
  Stamp arrival_;
};

/// How far the angles of a NAV deviate, as measured at the factory: the answer to MCAngleCompSin.
struct ColaAngleCompensation {
  double amplitude_deg = 0, phase_deg = 0, offset_deg = 0;
};
constexpr std::string_view angle_compensation = "MCAngleCompSin", contamination_state = "LCMstate";
/// Layout and examples: sick_scan_xd 3.9.0, angle_compensator.cpp: 32 bits each (NAV2xx), or 16, 32 and 16
/// bits (NAV3xx), in 1/10000 deg. CoLa A does not show the widths, so they follow from `kind` there.
Reject parse_cola_compensation(const ColaTelegram& telegram, AngleCompensation kind,
                               ColaAngleCompensation& out);

/// Bits of the status word, the second byte lowest. SICK 8013796 (LMS500) p. 81: 1, 2 and 4; SICK 8014631 has
/// 5, too. The laser is off: public library LMS5xxConnector; so the first scans of a recorded LMS111 and
/// LMS511 report.
namespace cola_status {
constexpr std::uint32_t error = 1, contaminated = 2, blind = 4, laser_off = 0x100;
}
SelfReport cola_self_report(std::uint32_t bits);

/// LFErec: the result of the device's field evaluation.
struct ColaFields {
  static constexpr std::size_t most = 48;
  struct Field {
    std::uint8_t number = 0;  ///< as configured in the device
    std::uint8_t result = 0;  ///< 0 invalid, 1 free, 2 infringed; an LMS511 also sent 3
  };
  std::array<Field, most> fields{};
  std::size_t count = 0;
  std::optional<std::uint32_t> time_us;  ///< device clock, of the last field
};

/// LIDoutputstate or LIDinputstate: the digital outputs or inputs.
struct ColaPins {
  static constexpr std::size_t most = 32;
  struct Pin {
    std::uint8_t state = 0;   ///< 0 inactive, 1 active, 2 not used
    std::uint32_t count = 0;  ///< changes so far; outputs only
  };
  std::array<Pin, most> pins{};
  std::size_t count = 0;
  std::optional<std::uint32_t> time_us;  ///< device clock; some devices send 0
};

/// InertialMeasurementUnit of an MRS1000, as measured, in the device's axes.
struct ColaImu {
  std::array<double, 3> acceleration{};      ///< m/s², at rest +g upwards
  std::array<double, 3> angular_velocity{};  ///< rad/s
  std::array<double, 4> orientation{};       ///< w x y z
  std::uint32_t time_us = 0;                 ///< device clock
};

/// Reads "sSN InertialMeasurementUnit" of CoLa B. Fields as in sick_scan_xd (sick_generic_imu.cpp), except
/// the time, which is the last word in recorded telegrams of an MRS1104. sick_scan_xd uses another order of
/// fields in CoLa A, of which no recording is known: such a telegram is Reject::version.
Reject parse_cola_imu(const ColaTelegram& telegram, ColaImu& imu);

/// Layouts: sick_scan_xd (sick_scan_messages.cpp), compared with recorded telegrams of LMS111, LMS511 and
/// TiM781S. Returns the fault, or Reject::none.
Reject parse_cola_fields(const ColaTelegram& telegram, ColaFields& fields);
Reject parse_cola_outputs(const ColaTelegram& telegram, ColaPins& pins);
Reject parse_cola_inputs(const ColaTelegram& telegram, ColaPins& pins);

}  // namespace lidard::sick
