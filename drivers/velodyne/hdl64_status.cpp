// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/hdl64_status.h"

#include <algorithm>
#include <boost/crc.hpp>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/base/angle.h"
#include "core/base/number_text.h"

namespace lidard::velodyne {
namespace {

// Layout: 63-HDL64ES3 Rev K pp. 32-38; offsets of the settings: velodyne_decoder, hdl64e.py.
constexpr int slots_per_cycle = 16;
constexpr int first_calibration_slot = 9;
constexpr int bytes_per_cycle = 7;
constexpr int cycles_per_round = 260;
constexpr int laser_count = 64;
constexpr int first_laser = 7;    // position in the round's calibration bytes
constexpr int laser_stride = 28;  // 4 cycles
constexpr int laser_bytes = 21;
constexpr int settings_begin = 1792;  // in the reserved part of the last laser
constexpr int checksum_at = 1818;
constexpr int enough_times = 3;
constexpr char token[] = {'U', 'N', 'I', 'T', '#'};
constexpr int whole_token = 0x1f;
constexpr int whole_date = 0x3f;
constexpr double rad_per_hundredth_deg = pi_d / 18000;

/// Slot of a packet in its cycle; -1 if the type is ambiguous. Settings have other types in place of the
/// digits: 63-HDL64ES3 Rev K p. 37.
int slot_of(std::uint8_t type) {
  constexpr char letters[] = {'H', 'M', 'S', 'D', 'N', 'Y', 'G', 'T', 'V'};
  const auto* letter = std::find(std::begin(letters), std::end(letters), static_cast<char>(type));
  if (letter != std::end(letters)) return static_cast<int>(letter - std::begin(letters));
  if (type >= '1' && type <= '7') return first_calibration_slot + type - '1';
  constexpr std::pair<std::uint8_t, int> settings[] = {{'W', 0},  {0xFE, 0}, {0xFF, 1}, {0xFC, 2}, {0xF9, 2},
                                                       {0xFD, 3}, {0xFA, 4}, {0xF8, 4}, {0xFB, 5}};
  for (const auto& [special, slot] : settings) {
    if (special == type) return first_calibration_slot + slot;
  }
  return -1;
}

bool has_bit(const Hdl64Info& info, unsigned bit) { return (info.warnings >> bit & 1U) != 0; }

std::string gps_text(char gps) {
  return gps == 'A' ? "PPS and NMEA" : gps == 'V' ? "NMEA only" : gps == 'P' ? "PPS only" : "none";
}

std::string return_mode_text(std::uint8_t mode) {
  constexpr const char* modes[] = {"strongest", "last", "both"};
  return mode < std::size(modes) ? modes[mode] : printed("unknown (%d)", mode);
}

}  // namespace

std::string SensorDate::to_string() const {
  return printed("%04d-%02d-%02d %02d:%02d:%02d", year, month, day, hour, minute, second);
}

/// Bits: 63-HDL64ES3 Rev K p. 38; 3 and 4 of an S2: velodyne_decoder, hdl64e.py.
std::vector<std::string> hdl64_warnings(const Hdl64Info& info) {
  std::vector<std::string> warnings;
  if (has_bit(info, 0)) warnings.emplace_back("the window is dirty; clean it");
  if (has_bit(info, 1)) warnings.emplace_back("the sensor is above 58 °C inside; cool it");
  if (has_bit(info, 2)) warnings.emplace_back("the sensor is below 5 °C inside; let it warm up");
  if (info.is_s3) return warnings;
  if (has_bit(info, 3)) warnings.emplace_back("the supply voltage is too low; check the supply");
  if (has_bit(info, 4)) warnings.emplace_back("the supply voltage is too high; check the supply");
  return warnings;
}

std::vector<std::pair<std::string, std::string>> hdl64_details(const Hdl64Info& info) {
  std::vector<std::pair<std::string, std::string>> details;
  if (info.firmware)
    details.emplace_back("firmware_version", printed("%x.%02x", *info.firmware >> 4, *info.firmware & 0xF));
  if (info.temperature) details.emplace_back("temperature_c", printed("%d", *info.temperature));
  if (info.gps) details.emplace_back("gps", gps_text(*info.gps));
  if (info.time) details.emplace_back("sensor_time", info.time->to_string());
  if (!info.settings) return details;
  const Hdl64Settings& settings = *info.settings;
  details.emplace_back("series", info.is_s3 ? "S3" : "S2");
  details.emplace_back("rpm", printed("%d", settings.rpm));
  details.emplace_back("fov_deg", printed("%.2f to %.2f", settings.fov_start_deg, settings.fov_end_deg));
  details.emplace_back("return_mode", return_mode_text(settings.return_mode));
  return details;
}

void Hdl64Status::add(std::uint8_t type, std::uint8_t value) {
  int slot = slot_of(type);
  if (slot < 0) {
    if (slot_ < 0) return;
    slot = (slot_ + 1) % slots_per_cycle;
  }
  step_to(slot);
  if (slot < first_calibration_slot)
    read_status(type, value);
  else
    read_calibration(slot - first_calibration_slot, type, value);
}

void Hdl64Status::restart() {
  slot_ = -1;
  cycle_ = -1;
  pending_count_ = 0;
  token_ = 0;
  date_ = 0;
}

/// Skips lost packets; the next landmark detects the loss of a full cycle.
void Hdl64Status::step_to(int slot) {
  if (slot <= slot_) {
    token_ = 0;
    date_ = 0;
    if (cycle_ >= 0) cycle_ = (cycle_ + 1) % cycles_per_round;
  }
  slot_ = slot;
}

void Hdl64Status::read_status(std::uint8_t type, std::uint8_t value) {
  if (type == 'G')
    info_.gps = static_cast<char>(value);
  else if (type == 'T')
    info_.temperature = static_cast<std::int8_t>(value);
  else if (type == 'V')
    info_.firmware = value;
  else
    read_date(slot_, value);
}

/// All parts of a date must be from one cycle, since the minute may change between cycles.
void Hdl64Status::read_date(int slot, std::uint8_t value) {
  if (slot > 5) return;
  int* const parts[] = {&date_parts_.hour, &date_parts_.minute, &date_parts_.second,
                        &date_parts_.day,  &date_parts_.month,  &date_parts_.year};
  *parts[slot] = value + (slot == 5 ? 2000 : 0);
  date_ |= 1 << slot;
  if (date_ == whole_date) info_.time = date_parts_;
}

void Hdl64Status::read_calibration(int index, std::uint8_t type, std::uint8_t value) {
  if (type == 'W') {  // in place of a reserved byte
    info_.is_s3 = true;
    info_.warnings = value;
    return;
  }
  if (follow_token(index, value) || cycle_ < 0) return;
  if (!is_landmark_right(index, value) || pending_count_ == pending_.size()) {
    lose_position();
    return;
  }
  pending_[pending_count_++] = {static_cast<std::uint16_t>(cycle_ * bytes_per_cycle + index), value};
}

/// True if the byte completes the token at the begin of a round.
bool Hdl64Status::follow_token(int index, std::uint8_t value) {
  if (index >= static_cast<int>(sizeof token) || value != static_cast<std::uint8_t>(token[index]))
    return false;
  token_ |= 1 << index;
  if (token_ != whole_token) return false;
  if (cycle_ == 0) {
    commit();
    finish_round();
  } else if (cycle_ > 0) {
    lose_position();
  }
  cycle_ = 0;
  return true;
}

/// True if a landmark confirms the position of the bytes before it.
bool Hdl64Status::is_landmark_right(int index, std::uint8_t value) {
  if (cycle_ == 0 && index < static_cast<int>(sizeof token))
    return value == static_cast<std::uint8_t>(token[index]);
  const int position = cycle_ * bytes_per_cycle + index - first_laser;
  if (position < 0 || position >= laser_count * laser_stride || position % laser_stride != 0) return true;
  if (value != position / laser_stride) return false;
  commit();
  return true;
}

void Hdl64Status::lose_position() {
  pending_count_ = 0;
  cycle_ = -1;
  ++resynchronisations_;
}

void Hdl64Status::commit() {
  for (std::size_t i = 0; i < pending_count_; ++i) {
    Byte& byte = bytes_[pending_[i].position];
    if (byte.value != pending_[i].value) byte = {pending_[i].value, 0};
    if (byte.times < std::numeric_limits<std::uint8_t>::max()) ++byte.times;
  }
  pending_count_ = 0;
}

void Hdl64Status::finish_round() {
  read_settings();
  if (!is_trustworthy()) return;
  bool is_new = calibration_ == nullptr;
  for (int i = 0; i < laser_count && !is_new; ++i)
    is_new = !(calibration_->lasers[static_cast<std::size_t>(i)] == laser(i));
  if (!is_new) return;
  Calibration fresh;
  fresh.lasers.reserve(laser_count);
  for (int i = 0; i < laser_count; ++i) fresh.lasers.push_back(laser(i));
  calibration_ = std::make_shared<const Calibration>(std::move(fresh));
}

/// How often in succession every byte of the part was the same (minimum).
int Hdl64Status::times_known(int begin, int end) const {
  int least = std::numeric_limits<int>::max();
  for (int i = begin; i < end; ++i) least = std::min<int>(least, bytes_[static_cast<std::size_t>(i)].times);
  return least;
}

std::uint16_t Hdl64Status::le16(int position) const {
  const auto at = static_cast<std::size_t>(position);
  return static_cast<std::uint16_t>(bytes_[at].value | bytes_[at + 1].value << 8U);
}

/// The checksum covers the records of the lasers without their numbers (velodyne_decoder, hdl64e.py).
bool Hdl64Status::is_checksum_right() const {
  if (times_known(checksum_at, round_bytes) == 0) return false;
  boost::crc_optimal<16, 0x8005, 0, 0, false, false> crc;
  for (int i = 0; i < laser_count; ++i) {
    const int record = first_laser + i * laser_stride;
    for (int k = record + 1; k < record + laser_bytes; ++k)
      crc.process_byte(bytes_[static_cast<std::size_t>(k)].value);
  }
  return crc.checksum() == le16(checksum_at);
}

bool Hdl64Status::is_trustworthy() const {
  int times = std::numeric_limits<int>::max();
  for (int i = 0; i < laser_count; ++i) {
    const int record = first_laser + i * laser_stride;
    times = std::min(times, times_known(record, record + laser_bytes));
    constexpr double right_angle = 1.5708;
    if (std::abs(laser(i).vert_correction) > right_angle) return false;
  }
  return times >= enough_times || (times > 0 && info_.is_s3 && is_checksum_right());
}

/// 63-HDL64ES3 Rev K p. 34: angles in 1/100 degree, lengths in mm, the focal slope in tenths.
LaserCalibration Hdl64Status::laser(int index) const {
  const int record = first_laser + index * laser_stride;
  const auto value = [&](int offset) { return static_cast<std::int16_t>(le16(record + offset)); };
  const auto byte = [&](int offset) { return std::next(bytes_.begin(), record + offset)->value; };
  LaserCalibration laser;
  laser.vert_correction = value(1) * rad_per_hundredth_deg;
  laser.rot_correction = value(3) * rad_per_hundredth_deg;
  laser.dist_correction = value(5) / 1e3;
  laser.dist_correction_x = value(7) / 1e3;
  laser.dist_correction_y = value(9) / 1e3;
  laser.vert_offset = value(11) / 1e3;
  laser.horiz_offset = value(13) / 1e3;
  laser.focal_distance = value(15) / 1e3;
  laser.focal_slope = value(17) / 1e1;
  laser.min_intensity = byte(19);
  laser.max_intensity = byte(20);
  const bool has_near = laser.dist_correction_x != 0 && laser.dist_correction_y != 0;
  laser.two_point = has_near ? TwoPoint::on : TwoPoint::off;
  return laser;
}

/// 63-HDL64ES3 Rev K p. 37.
void Hdl64Status::read_settings() {
  if (times_known(settings_begin, round_bytes) == 0) return;
  Hdl64Settings settings;
  settings.rpm = static_cast<std::int16_t>(le16(settings_begin + 7));
  settings.fov_start_deg = le16(settings_begin + 9) / 1e2;
  settings.fov_end_deg = le16(settings_begin + 11) / 1e2;
  settings.return_mode = bytes_[settings_begin + 23].value;
  if (!info_.is_s3) info_.warnings = bytes_[settings_begin + 24].value;
  info_.settings = settings;
}

}  // namespace lidard::velodyne
