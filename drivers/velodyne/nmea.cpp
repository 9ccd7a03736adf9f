// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/nmea.h"

#include <algorithm>
#include <array>
#include <ctime>

#include "core/base/number_text.h"

namespace lidard::velodyne {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::nanoseconds;
using std::chrono::seconds;

bool all_digits(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// The number of `count` digits from `at` on; nullopt if a character is not a digit.
std::optional<int> digits(std::string_view text, std::size_t at, std::size_t count) {
  if (text.size() < at + count) return std::nullopt;
  const auto value = number_in<unsigned>(text.substr(at, count));
  return value ? std::optional<int>(static_cast<int>(*value)) : std::nullopt;
}

/// A decimal number, sign allowed, without exponent.
std::optional<double> decimal(std::string_view text) {
  const std::string_view unsigned_part = text.substr(!text.empty() && text.front() == '-' ? 1 : 0);
  if (unsigned_part.empty() || !all_digits(unsigned_part.substr(0, 1))) return std::nullopt;
  return text.find_first_of("eE") == std::string_view::npos ? number_in<double>(text) : std::nullopt;
}

/// HHMMSS with up to nine decimals; receivers send none to three (23:59:60 is a leap second).
std::optional<Span> time_of_day(std::string_view text) {
  const auto h = digits(text, 0, 2);
  const auto m = digits(text, 2, 2);
  const auto s = digits(text, 4, 2);
  if (!h || !m || !s || *h > 23 || *m > 59 || *s > 60) return std::nullopt;
  const Span whole = hours(*h) + minutes(*m) + seconds(*s);
  if (text.size() == 6) return whole;
  const std::size_t decimals = text.size() - 7;
  if (text[6] != '.' || decimals < 1 || decimals > 9) return std::nullopt;
  const auto fraction = digits(text, 7, decimals);
  if (!fraction) return std::nullopt;
  std::int64_t ns = *fraction;
  for (std::size_t i = decimals; i < 9; ++i) ns *= 10;
  return whole + nanoseconds(ns);
}

/// DDMMYY as its midnight; years are those from 1980 (the begin of GPS) to 2079.
std::optional<HostStamp> midnight(std::string_view text) {
  const auto day = digits(text, 0, 2);
  const auto month = digits(text, 2, 2);
  const auto short_year = digits(text, 4, 2);
  if (text.size() != 6 || !day || !month || !short_year) return std::nullopt;
  std::tm date{};
  date.tm_mday = *day;
  date.tm_mon = *month - 1;
  date.tm_year = *short_year + (*short_year < 80 ? 100 : 0);
  const std::int64_t whole = timegm(&date);
  // timegm() accepts the 31st of April as the 1st of May.
  if (date.tm_mday != *day || date.tm_mon != *month - 1) return std::nullopt;
  return HostStamp{} + seconds(whole);
}

/// [D]DDMM.mmm and its hemisphere as degrees.
std::optional<double> degrees(std::string_view text, std::string_view hemisphere, std::size_t degree_digits,
                              std::string_view hemispheres) {
  const auto whole = digits(text, 0, degree_digits);
  if (!whole || !digits(text, degree_digits, 2)) return std::nullopt;
  const auto arc_minutes = decimal(text.substr(degree_digits));
  if (!arc_minutes || *arc_minutes >= 60 || hemisphere.size() != 1) return std::nullopt;
  const double value = *whole + *arc_minutes / 60;
  const double limit = degree_digits == 2 ? 90 : 180;
  if (value > limit) return std::nullopt;
  if (hemisphere[0] == hemispheres[0]) return value;
  if (hemisphere[0] == hemispheres[1]) return -value;
  return std::nullopt;
}

bool read_position(std::string_view lat, std::string_view ns, std::string_view lon, std::string_view ew,
                   NmeaReading& reading) {
  const auto latitude = degrees(lat, ns, 2, "NS");
  const auto longitude = degrees(lon, ew, 3, "EW");
  if (!latitude || !longitude) return false;
  reading.latitude_deg = *latitude;
  reading.longitude_deg = *longitude;
  return true;
}

/// The fields of a sentence, its address first.
struct Fields {
  static constexpr std::size_t most = 24;  // an NMEA sentence has at most 82 characters; RMC and GGA need 15
  std::array<std::string_view, most> text;
  std::size_t count = 0;

  std::string_view operator[](std::size_t i) const { return i < count ? text[i] : std::string_view(); }
};

bool split(std::string_view body, Fields& fields) {
  while (fields.count < Fields::most) {
    const std::size_t comma = body.find(',');
    fields.text[fields.count++] = body.substr(0, comma);
    if (comma == std::string_view::npos) return true;
    body.remove_prefix(comma + 1);
  }
  return false;
}

/// Mode of RMC since NMEA 2.3; older receivers send none. Positions without satellites count as no fix.
FixStatus rmc_status(std::string_view mode) {
  if (mode.empty() || mode == "A" || mode == "P") return FixStatus::satellite;
  if (mode == "D") return FixStatus::sbas;
  return mode == "R" || mode == "F" ? FixStatus::gbas : FixStatus::none;
}

FixStatus gga_status(std::string_view quality) {
  if (quality == "1" || quality == "3") return FixStatus::satellite;
  if (quality == "2") return FixStatus::sbas;
  return quality == "4" || quality == "5" ? FixStatus::gbas : FixStatus::none;
}

NmeaVerdict read_rmc(const Fields& f, NmeaReading& reading) {
  if (f[2] != "A" && f[2] != "V") return NmeaVerdict::malformed;
  reading.status = rmc_status(f[12]);
  if (f[2] == "V" || reading.status == FixStatus::none) return NmeaVerdict::no_fix;
  const auto time = time_of_day(f[1]);
  const auto day = midnight(f[9]);
  if (!time || !day || !read_position(f[3], f[4], f[5], f[6], reading)) return NmeaVerdict::malformed;
  reading.time_of_day = *time;
  reading.utc = *day + *time;
  // 2001-01-01: a sensor without a receiver sends dates of 2000; older dates come from the roll-over of the
  // GPS week.
  constexpr HostStamp earliest{978'307'200'000'000'000};
  return *day < earliest ? NmeaVerdict::invented_date : NmeaVerdict::valid;
}

NmeaVerdict read_gga(const Fields& f, NmeaReading& reading) {
  if (f[6].size() != 1 || !all_digits(f[6])) return NmeaVerdict::malformed;
  reading.status = gga_status(f[6]);
  if (reading.status == FixStatus::none) return NmeaVerdict::no_fix;
  const auto time = time_of_day(f[1]);
  if (!time || !read_position(f[2], f[3], f[4], f[5], reading)) return NmeaVerdict::malformed;
  reading.time_of_day = *time;
  // Altitude above the sea plus the geoid's height above the ellipsoid.
  const auto above_sea = decimal(f[9]);
  const auto geoid = decimal(f[11]);
  if (above_sea && geoid) reading.altitude_m = *above_sea + *geoid;
  return NmeaVerdict::valid;
}

bool checksum_fits(std::string_view body, std::string_view written) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  return written.size() == 2 && number_in<unsigned>(written, 16) == sum;
}

}  // namespace

NmeaReading read_nmea(std::string_view text) {
  NmeaReading reading;
  text = text.substr(0, text.find_first_of(std::string_view("\0\r\n", 3)));
  if (text.empty()) return reading;
  const std::size_t star = text.find('*');
  const std::string_view body = text.substr(1, star == std::string_view::npos ? star : star - 1);
  Fields fields;
  if (text.front() != '$' || star == 0 || !split(body, fields)) {
    reading.verdict = NmeaVerdict::malformed;
  } else if (star == std::string_view::npos || !checksum_fits(body, text.substr(star + 1))) {
    reading.verdict = NmeaVerdict::bad_checksum;
  } else if (fields[0].size() == 5 && fields[0].substr(2) == "RMC") {
    reading.kind = NmeaKind::rmc;
    reading.verdict = read_rmc(fields, reading);
  } else if (fields[0].size() == 5 && fields[0].substr(2) == "GGA") {
    reading.kind = NmeaKind::gga;
    reading.verdict = read_gga(fields, reading);
  } else {
    reading.verdict = NmeaVerdict::other_sentence;
  }
  return reading;
}

}  // namespace lidard::velodyne
