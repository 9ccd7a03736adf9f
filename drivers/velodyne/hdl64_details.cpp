// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "drivers/velodyne/hdl64_status.h"

namespace lidard::velodyne {
namespace {

template <class... Numbers>
std::string text(const char* format, Numbers... numbers) {
  char buffer[80];
  std::snprintf(buffer, sizeof buffer, format, numbers...);
  return buffer;
}

bool has_bit(const Hdl64Info& info, unsigned bit) { return (info.warnings >> bit & 1U) != 0; }

std::string gps_text(char gps) {
  switch (gps) {
    case 'A':
      return "PPS and NMEA";
    case 'V':
      return "NMEA only";
    case 'P':
      return "PPS only";
    default:
      return "none";
  }
}

std::string address_text(const std::array<std::uint8_t, 4>& ip) {
  return text("%d.%d.%d.%d", ip[0], ip[1], ip[2], ip[3]);
}

std::string return_mode_text(std::uint8_t mode) {
  switch (mode) {
    case 0:
      return "strongest";
    case 1:
      return "last";
    case 2:
      return "both";
    default:
      return text("unknown (%d)", mode);
  }
}

}  // namespace

std::string SensorDate::to_string() const {
  return text("%04d-%02d-%02d %02d:%02d:%02d", year, month, day, hour, minute, second);
}

/// Bits: 63-HDL64ES3 Rev K p. 38; 3 and 4 of an S2 as in velodyne_decoder's hdl64e.py.
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
    details.emplace_back("firmware_version", text("%x.%02x", *info.firmware >> 4, *info.firmware & 0xF));
  if (info.temperature) details.emplace_back("temperature_c", text("%d", *info.temperature));
  if (info.gps) details.emplace_back("gps", gps_text(*info.gps));
  if (info.time) details.emplace_back("sensor_time", info.time->to_string());
  if (!info.settings) return details;
  const Hdl64Settings& settings = *info.settings;
  details.emplace_back("series", info.is_s3 ? "S3" : "S2");
  details.emplace_back("calibrated", settings.calibrated ? settings.calibrated->to_string() : "no date");
  details.emplace_back("rpm", text("%d", settings.rpm));
  details.emplace_back("fov_deg", text("%.2f to %.2f", settings.fov_start_deg, settings.fov_end_deg));
  details.emplace_back("return_mode", return_mode_text(settings.return_mode));
  details.emplace_back("power_level", text("%02X", settings.power_level));
  details.emplace_back("life_hours", text("%d", settings.life_hours));
  details.emplace_back("humidity_percent", text("%d", settings.humidity));
  details.emplace_back("source", address_text(settings.source));
  details.emplace_back("destination", address_text(settings.destination));
  return details;
}

}  // namespace lidard::velodyne
