// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/counters.h"

namespace lidard::hokuyo {

/// The check character of a line: low six bits of the sum of its bytes, moved to the printable ones (Hokuyo
/// C-42-03320B p. 7).
char scip_checksum(std::string_view text);
/// True if the last character of `line` is the checksum of the rest.
bool has_checksum(std::string_view line);
/// A number coded with 6 bits a character, most significant first (Hokuyo C-42-03320B p. 6); empty if a
/// character cannot be of a number or there are more than 11 of them.
std::optional<std::uint64_t> scip_number(std::string_view text);
/// Cuts the first line off `text`: returns it without its LF.
std::string_view take_line(std::string_view& text);

/// One answer of a SCIP sensor; views into the reader's buffer.
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
  explicit ScipReader(Counters& counters);

  /// The next bytes come from somewhere else in the stream, or from another one: what is half here is worth
  /// nothing.
  void interrupt();
  void add(ByteView bytes);
  /// The next answer whose status line is sound. It is valid until the next call of any function.
  bool next(ScipMessage& message);

 private:
  bool parse(std::string_view text, ScipMessage& message) const;

  Counters& counters_;
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;     // of the answer that is being collected
  std::size_t searched_ = 0;  // no empty line ends before
  bool torn_ = true;          // what comes next may be the tail of an answer
};

/// What a request for distances asks for, as its echo repeats it.
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

/// What a sensor's counter shows.
struct ScipStamp {
  std::uint64_t ticks = 0;
  bool microseconds = false;  ///< of the % extension; else ms, 24 bits (Hokuyo C-42-03320B p. 12)
};

/// Reads a line with a stamp, checksum included; empty if it is none. How wide it is tells its unit: 4
/// characters are ms, the 11 of the % extension are us. The echo does not tell: seqsense/urg_stamped's
/// simulator answers %ME with the echo ME (src/urg_sim/urg_sim.cpp, handleMX).
std::optional<ScipStamp> parse_stamp(std::string_view line);

/// Empty if the echo is not that of MD, MS, ME, ND, NE, GD, GS, GE, HD or HE with sound parameters.
std::optional<ScipScanRequest> parse_scan_request(std::string_view echo);
/// The request itself, ended by LF, for an endless stream.
std::string_view write_scan_request(const ScipScanRequest& request, std::vector<char>& buffer);

/// Joins the data lines of `body` without their checksums into `flat`; values straddle line ends (Hokuyo
/// C-42-03320B p. 11). False if a checksum is wrong.
bool join_lines(std::string_view body, std::vector<char>& flat);

}  // namespace lidard::hokuyo
