// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/counters.h"
#include "core/frames/scan.h"
#include "drivers/driver.h"
#include "drivers/stream_buffer.h"

namespace lidard::hokuyo {

/// The check character of a line: low six bits of the sum of its bytes, moved to the printable ones (Hokuyo
/// C-42-03320B p. 7).
char scip_checksum(std::string_view text);
/// True if the last character of `line` is the checksum of the rest.
bool has_checksum(std::string_view line);
/// A number coded with 6 bits a character, most significant first (Hokuyo C-42-03320B p. 6); empty if a
/// character cannot be of a number or there are more than 11 of them.
std::optional<std::uint64_t> scip_number(std::string_view text);
/// Removes the first line of `text` and returns it without its LF.
std::string_view cut_line(std::string_view& text);

/// One answer of a SCIP sensor; views into the reader's buffer. All are empty if the answer is not readable.
struct ScipMessage {
  std::string_view echo;    ///< the request as the sensor repeats it
  std::string_view status;  ///< two characters
  std::string_view body;    ///< further lines with their checksums, each ended by LF; may be empty

  /// Two letters, with the % of the extension if it is there.
  std::string_view command() const { return echo.substr(0, !echo.empty() && echo.front() == '%' ? 3 : 2); }
};

/// Cuts a stream into answers. An answer ends with an empty line; the stream may begin or be torn anywhere.
class ScipReader {
 public:
  explicit ScipReader(Counters& counters) : counters_(counters) {}

  /// The next bytes come from another place in the stream, or from another stream: drops an incomplete
  /// answer.
  void interrupt();
  void add(ByteView bytes) { buffer_.add(bytes); }
  /// The next answer. It is valid until the next call of any function.
  bool next(ScipMessage& message);

 private:
  Counters& counters_;
  StreamBuffer buffer_;
  std::size_t searched_ = 0;  // no empty line ends in so many bytes
  bool torn_ = true;          // what comes next may be the tail of an answer
};

/// Parameters of a request for distances, as its echo repeats them.
struct ScipScanRequest {
  bool percent = false;       ///< with the extension, which asks for stamps in us
  bool continuous = false;    ///< M. and N.: the sensor goes on sending
  bool multi_echo = false;    ///< N. and H.
  bool intensities = false;   ///< .E
  bool short_values = false;  ///< .S: two characters a distance, not three
  int first_step = 0, last_step = 0;
  int cluster = 1;  ///< steps merged into one value
  int skip = 0;     ///< scans left out between two

  /// Number of values that an answer must hold.
  std::size_t values() const { return static_cast<std::size_t>((last_step - first_step) / cluster) + 1; }
  friend bool operator==(const ScipScanRequest& a, const ScipScanRequest& b) {
    return a.first_step == b.first_step && a.last_step == b.last_step && a.cluster == b.cluster;
  }
};

/// Reading of a sensor's counter.
struct ScipStamp {
  std::uint64_t ticks = 0;
  bool microseconds = false;  ///< of the % extension; else ms, 24 bits (Hokuyo C-42-03320B p. 12)
};

/// Reads a line with a stamp, checksum included; empty if it is none. Its width shows the unit: 4 characters
/// are ms, the 11 of the % extension are us. The echo does not show it: seqsense/urg_stamped's simulator
/// answers %ME with the echo ME (src/urg_sim/urg_sim.cpp, handleMX).
std::optional<ScipStamp> parse_stamp(std::string_view line);
/// The counter in an answer to TM1; empty in any other answer, or if it is refused or damaged.
std::optional<ScipStamp> parse_time(const ScipMessage& message);

/// Empty if the echo is not that of MD, MS, ME, ND, NE, GD, GS, GE, HD or HE with sound parameters.
std::optional<ScipScanRequest> parse_scan_request(std::string_view echo);
/// The request itself, ended by LF, for an endless stream.
std::string_view write_scan_request(const ScipScanRequest& request, std::vector<char>& buffer);

/// Joins the data lines of `body` without their checksums into `flat`; values straddle line ends (Hokuyo
/// C-42-03320B p. 11). False if a checksum is wrong.
bool join_lines(std::string_view body, std::vector<char>& flat);

/// Meaning of distances below the shortest one, which are codes.
enum class CodeTable : std::uint8_t {
  utm,  ///< Hokuyo C-42-03320B p. 12 table 4 (UTM-30LX); unverified for UST and UXM
  urg   ///< the same, table 3 (URG-04LX, UBG, UHG)
};

/// State of a beam by its code.
BeamStatus status_of_code(CodeTable table, std::uint32_t code);
/// The table that fits a product's name.
CodeTable code_table_of(std::string_view product);

/// The sensor's answer to PP (Hokuyo C-42-03320B p. 21), or what is known of a product beforehand.
struct ScipParameters {
  int range_min_mm = 0;    ///< DMIN; what is less is a code
  int range_max_mm = 0;    ///< DMAX; what is more is no echo
  int steps_per_turn = 0;  ///< ARES
  int first_step = 0;      ///< AMIN
  int last_step = 0;       ///< AMAX
  int front_step = 0;      ///< AFRT
  int rpm = 0;             ///< SCAN

  double rad_per_step() const;
  /// rad, counter-clockwise from the front; fractions of a step for groups.
  double angle(double step) const { return (step - front_step) * rad_per_step(); }
  double turn_seconds() const { return 60.0 / rpm; }
  double step_seconds() const { return turn_seconds() / steps_per_turn; }
  friend bool operator==(const ScipParameters& a, const ScipParameters& b);
};

/// Reads the lines of an answer to PP; `product` gets the sensor's name. False if a line is missing, its
/// checksum is wrong or the values make no sense.
bool parse_parameters(std::string_view body, ScipParameters& parameters, std::string& product);

/// Calls use(key, value, sound) for each line KEY:VALUE of an answer to PP, VV or II. The checksum counts the
/// line without its semicolon; some firmware counts that, too. `sound`: the checksum is right.
template <class Use>
void for_each_entry(std::string_view body, Use&& use);

bool split_entry(std::string_view line, std::string_view& key, std::string_view& value, bool& sound);

template <class Use>
void for_each_entry(std::string_view body, Use&& use) {
  while (!body.empty()) {
    const std::size_t end = body.find('\n');
    std::string_view key, value;
    bool sound = false;
    if (split_entry(body.substr(0, end), key, value, sound)) use(key, value, sound);
    body.remove_prefix(end == std::string_view::npos ? body.size() : end + 1);
  }
}

/// The request for the steps inside the configured angles (all of them if there are none) and what lies
/// between them, with cluster and skip.
inline ScipScanRequest request_for(const ScipParameters& p, const DriverConfig& config) {
  ScipScanRequest request;
  const auto steps = static_cast<std::size_t>(p.last_step - p.first_step) + 1;
  const BeamWindow window = beams_inside(config.sector(), p.angle(p.first_step), p.rad_per_step(), steps);
  request.first_step = p.first_step + static_cast<int>(window.first);
  request.last_step =
      window.count == 0 ? p.last_step : request.first_step + static_cast<int>(window.count) - 1;
  request.cluster = std::clamp(config.requests.cluster.value_or(1), 1, 99);
  request.skip = std::clamp(config.requests.skip.value_or(0), 0, 9);
  return request;
}

/// True for UST firmware that knows the % extension: from 4.1, or from 1.1 within 1.x (as urg_stamped has
/// it).
inline bool firmware_knows_percent(const std::string& firmware) {
  int major = 0, minor = 0;
  if (std::sscanf(firmware.c_str(), "%d.%d", &major, &minor) != 2) return false;
  return major > 4 || (major == 4 && minor >= 1) || (major == 1 && minor >= 1);
}

/// Class of the status of an answer.
enum class StatusClass : std::uint8_t {
  accepted,   ///< 00
  data,       ///< 99
  unknown,    ///< 0E, 0F: the sensor has no such command
  verifying,  ///< 21-49: the sensor pauses to check itself
  fault,      ///< 50-97: hardware trouble
  resumed,    ///< 98
  refused     ///< everything else
};

StatusClass class_of(std::string_view status);

/// Why `command` was not carried out: a sentence with a remedy. Where the two generations of SCIP 2 give a
/// status another meaning, it names both.
std::string explain_status(std::string_view command, std::string_view status);

}  // namespace lidard::hokuyo
