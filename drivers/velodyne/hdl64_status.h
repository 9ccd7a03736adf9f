// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/velodyne/calibration.h"

namespace lidard::velodyne {

/// A date and time of the sensor's own clock.
struct SensorDate {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  std::string to_string() const;
};

/// The settings of an HDL-64E, sent once per round of the status bytes (about once per second).
struct Hdl64Settings {
  int rpm = 0;
  double fov_start_deg = 0, fov_end_deg = 0;
  std::uint8_t return_mode = 0;  ///< 0 strongest, 1 last, 2 both
};

/// The state that an HDL-64E reports besides the calibration.
struct Hdl64Info {
  bool is_s3 = false;              ///< it sends separate warning bytes
  std::optional<SensorDate> time;  ///< UTC with GPS
  std::optional<char> gps;         ///< 'A' PPS and NMEA, 'V' NMEA only, 'P' PPS only, '\0' none
  std::optional<int> temperature;  ///< °C
  std::optional<int> firmware;     ///< BCD: 0x47 is 4.07
  std::uint8_t warnings = 0;       ///< bits, see hdl64_warnings()
  std::optional<Hdl64Settings> settings;
};

/// Sentences for the warning bits that are set.
std::vector<std::string> hdl64_warnings(const Hdl64Info& info);
/// Key and value pairs for diagnostics.
std::vector<std::pair<std::string, std::string>> hdl64_details(const Hdl64Info& info);

/// Collects the last two bytes of the packets of an HDL-64E S2 or S3: one byte of status per packet, 16
/// packets per cycle, 260 cycles per round (63-HDL64ES3 Rev K, appendix E). An S1 sends neither status nor
/// calibration.
///
/// Later rounds fill the holes of lost packets: every byte is counted separately, and bytes between two
/// landmarks (the token "UNIT#" and the numbers of the lasers) count only if the second landmark is at its
/// expected position. The calibration is accepted when every byte was the same three times in succession or,
/// from an S3, when the checksum is right.
class Hdl64Status {
 public:
  /// Adds the last two bytes of the next packet.
  void add(std::uint8_t type, std::uint8_t value);
  /// Restarts the stream; keeps the data of the device.
  void restart();

  /// Empty until accepted; a new object after a change. Its model is `exact`.
  const std::shared_ptr<const Calibration>& calibration() const { return calibration_; }
  const Hdl64Info& info() const { return info_; }
  /// How often the position in the round was lost (many consecutive packets were missing).
  std::uint32_t resynchronisations() const { return resynchronisations_; }

 private:
  static constexpr int round_bytes = 1820;
  struct Byte {
    std::uint8_t value = 0;
    std::uint8_t times = 0;  // in succession
  };
  struct Pending {
    std::uint16_t position;
    std::uint8_t value;
  };

  void step_to(int slot);
  void read_status(std::uint8_t type, std::uint8_t value);
  void read_date(int slot, std::uint8_t value);
  void read_calibration(int index, std::uint8_t type, std::uint8_t value);
  bool follow_token(int index, std::uint8_t value);
  bool is_landmark_right(int index, std::uint8_t value);
  void lose_position();
  void commit();
  void finish_round();
  void read_settings();
  int times_known(int begin, int end) const;
  std::uint16_t le16(int position) const;
  bool is_checksum_right() const;
  bool is_trustworthy() const;
  LaserCalibration laser(int index) const;

  int slot_ = -1;   // of the last packet in its cycle; -1: none
  int cycle_ = -1;  // of the last packet in its round; -1: not known
  int token_ = 0;   // bits: characters of the token seen in this cycle
  int date_ = 0;    // bits: parts of the date seen in this cycle
  SensorDate date_parts_;
  std::array<Byte, round_bytes> bytes_{};
  std::array<Pending, round_bytes> pending_{};
  std::size_t pending_count_ = 0;
  std::uint32_t resynchronisations_ = 0;
  Hdl64Info info_;
  std::shared_ptr<const Calibration> calibration_;
};

}  // namespace lidard::velodyne
