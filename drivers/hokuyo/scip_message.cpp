// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_message.h"

#include <array>
#include <utility>

#include "core/base/angle.h"
#include "core/base/number_text.h"

namespace lidard::hokuyo {
namespace {

// A full turn of three echoes with intensities, 10 000 steps (the request has four digits), is less.
constexpr std::size_t longest_answer = 256 * 1024UL;
constexpr unsigned first_code = 0x30;
constexpr unsigned six_bits = 0x3f;
constexpr std::size_t longest_number = 11;
// Hokuyo C-42-03320B p. 7: up to 16 characters of the host's own, here with a semicolon before.
constexpr std::size_t longest_user_string = 17;

/// Reads exactly `digits` decimal digits from the front of `text`; -1 if they are not there.
int cut_decimal(std::string_view& text, std::size_t digits) {
  const auto value = number_in<unsigned>(text.substr(0, digits));
  if (text.size() < digits || !value) return -1;
  text.remove_prefix(digits);
  return static_cast<int>(*value);
}

}  // namespace

char scip_checksum(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum += static_cast<unsigned char>(c);
  return static_cast<char>((sum & six_bits) + first_code);
}

bool has_checksum(std::string_view line) {
  return line.size() >= 2 && line.back() == scip_checksum(line.substr(0, line.size() - 1));
}

std::optional<std::uint64_t> scip_number(std::string_view text) {
  if (text.empty() || text.size() > longest_number) return std::nullopt;
  std::uint64_t value = 0;
  for (const char c : text) {
    const unsigned code = static_cast<unsigned char>(c) - first_code;
    if (code > six_bits) return std::nullopt;
    value = value << 6U | code;
  }
  return value;
}

std::optional<ScipStamp> parse_stamp(std::string_view line) {
  constexpr std::size_t in_ms = 4, in_us = 11;
  if (line.size() != in_ms + 1 && line.size() != in_us + 1) return std::nullopt;
  const auto ticks = scip_number(line.substr(0, line.size() - 1));
  if (!ticks) return std::nullopt;
  return ScipStamp{*ticks, line.size() == in_us + 1};
}

std::optional<ScipStamp> parse_time(const ScipMessage& message) {
  std::string_view body = message.body;
  const std::string_view line = cut_line(body);
  const bool is_time = message.echo.find("TM1") <= 1 && message.status == "00" && has_checksum(line);
  return is_time ? parse_stamp(line) : std::nullopt;
}

std::string_view cut_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

void ScipReader::interrupt() {
  if (!buffer_.rest().empty()) ++counters_.incomplete;
  buffer_.clear();
  searched_ = 0;
  torn_ = true;
}

namespace {

/// Empty unless the status line is sound.
ScipMessage parse_message(std::string_view text) {
  ScipMessage message;
  message.echo = cut_line(text);
  const std::string_view status = cut_line(text);
  if (message.echo.size() < 2 || status.size() != 3 || !has_checksum(status)) return {};
  message.status = status.substr(0, 2);
  message.body = text;
  return message;
}

}  // namespace

bool ScipReader::next(ScipMessage& message) {
  while (true) {
    std::string_view rest = buffer_.rest().text();
    // No answer begins with an empty line, but a stream may be joined between the two LF that end one.
    const std::size_t empty_lines = std::min(rest.find_first_not_of('\n'), rest.size());
    buffer_.drop(empty_lines);
    rest.remove_prefix(empty_lines);
    searched_ -= std::min(searched_, empty_lines);
    const std::size_t end = rest.find("\n\n", searched_);
    if (end == std::string_view::npos) {
      // The last byte may be the first of the two.
      searched_ = rest.empty() ? 0 : rest.size() - 1;
      if (rest.size() > longest_answer) interrupt();
      return false;
    }
    buffer_.drop(end + 2);
    searched_ = 0;
    message = parse_message(rest.substr(0, end + 1));
    if (!std::exchange(torn_, false) || !message.echo.empty()) return true;
    ++counters_.incomplete;
  }
}

std::optional<ScipScanRequest> parse_scan_request(std::string_view echo) {
  ScipScanRequest request;
  request.percent = !echo.empty() && echo.front() == '%';
  if (request.percent) echo.remove_prefix(1);
  if (echo.size() < 2) return std::nullopt;
  const char kind = echo[0];
  const char content = echo[1];
  echo.remove_prefix(2);
  request.continuous = kind == 'M' || kind == 'N';
  request.multi_echo = kind == 'N' || kind == 'H';
  if (!request.continuous && kind != 'G' && kind != 'H') return std::nullopt;
  request.intensities = content == 'E';
  request.short_values = content == 'S' && !request.multi_echo;
  if (content != 'D' && !request.intensities && !request.short_values) return std::nullopt;
  request.first_step = cut_decimal(echo, 4);
  request.last_step = cut_decimal(echo, 4);
  const int cluster = cut_decimal(echo, 2);
  request.cluster = std::max(1, cluster);
  request.skip = request.continuous ? cut_decimal(echo, 1) : 0;
  const int scans = request.continuous ? cut_decimal(echo, 2) : 0;
  if (request.first_step < 0 || request.last_step < request.first_step || cluster < 0 || request.skip < 0 ||
      scans < 0 || echo.size() > longest_user_string)
    return std::nullopt;
  return request;
}

std::string_view write_scan_request(const ScipScanRequest& request, std::vector<char>& buffer) {
  buffer.resize(32);
  const char content = request.intensities ? 'E' : request.short_values ? 'S' : 'D';
  const int size = std::snprintf(buffer.data(), buffer.size(), "%s%c%c%04d%04d%02d%d00\n",
                                 request.percent ? "%" : "", request.multi_echo ? 'N' : 'M', content,
                                 request.first_step, request.last_step, request.cluster, request.skip);
  return {buffer.data(), static_cast<std::size_t>(size)};
}

bool join_lines(std::string_view body, std::vector<char>& flat) {
  flat.clear();
  while (!body.empty()) {
    const std::string_view line = cut_line(body);
    if (!has_checksum(line)) return false;
    flat.insert(flat.end(), line.begin(), line.end() - 1);
  }
  return true;
}

namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

bool is_plausible(const ScipParameters& p) {
  // Four digits hold a step in a request, three characters a distance.
  return p.range_min_mm >= 0 && p.range_max_mm > p.range_min_mm && p.range_max_mm < 1 << 18 &&
         p.steps_per_turn > 0 && p.steps_per_turn <= 100'000 && p.first_step >= 0 &&
         p.last_step > p.first_step && p.last_step <= 9999 && p.front_step >= 0 && p.front_step <= 9999 &&
         p.rpm > 0 && p.rpm <= 100'000;
}

}  // namespace

BeamStatus status_of_code(CodeTable table, std::uint32_t code) {
  if (table == CodeTable::urg) {
    // 0: possibly at 22 m; 6: "others", in practice beyond the range (as hokuyo_node reads both).
    return code == 0 || code == 6 ? BeamStatus::none : BeamStatus::invalid;
  }
  if (code == 1) return BeamStatus::none;
  // 2: too near (internal error); 4: out of range at the near end.
  return code == 2 || code == 4 ? BeamStatus::near : BeamStatus::invalid;
}

CodeTable code_table_of(std::string_view product) {
  for (const std::string_view family : {"URG", "UBG", "UHG"}) {
    if (product.substr(0, family.size()) == family) return CodeTable::urg;
  }
  return CodeTable::utm;
}

double ScipParameters::rad_per_step() const { return two_pi / steps_per_turn; }

bool operator==(const ScipParameters& a, const ScipParameters& b) {
  return a.range_min_mm == b.range_min_mm && a.range_max_mm == b.range_max_mm &&
         a.steps_per_turn == b.steps_per_turn && a.first_step == b.first_step && a.last_step == b.last_step &&
         a.front_step == b.front_step && a.rpm == b.rpm;
}

bool split_entry(std::string_view line, std::string_view& key, std::string_view& value, bool& sound) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || line.size() < colon + 3) return false;
  const std::string_view counted = line.substr(0, line.size() - 1);
  std::string_view bare = counted;
  if (bare.back() == ';') bare.remove_suffix(1);
  sound = line.back() == scip_checksum(bare) || line.back() == scip_checksum(counted);
  key = line.substr(0, colon);
  value = trimmed(bare.substr(colon + 1));
  return true;
}

bool parse_parameters(std::string_view body, ScipParameters& parameters, std::string& product) {
  struct Field {
    std::string_view key;
    int ScipParameters::*value;
  };
  constexpr std::array<Field, 7> fields = {{{"DMIN", &ScipParameters::range_min_mm},
                                            {"DMAX", &ScipParameters::range_max_mm},
                                            {"ARES", &ScipParameters::steps_per_turn},
                                            {"AMIN", &ScipParameters::first_step},
                                            {"AMAX", &ScipParameters::last_step},
                                            {"AFRT", &ScipParameters::front_step},
                                            {"SCAN", &ScipParameters::rpm}}};
  ScipParameters read;
  std::size_t found = 0;
  bool all_sound = true;
  std::string_view name;
  for_each_entry(body, [&](std::string_view key, std::string_view value, bool sound) {
    all_sound = all_sound && sound;
    if (key == "MODL") name = value.substr(0, value.find('('));
    for (const Field& field : fields) {
      if (field.key != key) continue;
      if (const auto number = number_in<int>(value)) read.*field.value = *number, ++found;
    }
  });
  if (!all_sound || found != fields.size() || !is_plausible(read)) return false;
  parameters = read;
  product = trimmed(name);
  return true;
}

namespace {

struct Meaning {
  std::string_view status;
  std::string_view words;
  std::string_view remedy;
};

constexpr std::string_view check_range = "correct angle_min, angle_max, cluster or skip in the configuration";
constexpr std::string_view check_model = "check the model in the configuration and the sensor's firmware";
constexpr std::string_view report = "please report the sensor's firmware version";
constexpr std::string_view wait =
    "wait, it is asked again every second; if it stays, switch its power off and on";

// Hokuyo C-42-03320B p. 11 and p. 23 (SCIP 2.0); the second generation (SCIP 2.2: UST, UTM-30LX-EW) as
// hokuyolx and urg_stamped have it.
constexpr std::array<Meaning, 20> meanings = {{
    {"01", "the first step is no number, or the laser is broken", check_range},
    {"02", "the last step is no number", check_range},
    {"03", "the cluster is no number", check_range},
    {"04", "the last step is out of range", check_range},
    {"05", "the last step is below the first", check_range},
    {"06", "the interval is no number", check_range},
    {"07", "the number of scans is no number", check_range},
    {"0A", "it has no memory left to answer", wait},
    {"0B", "the buffer is full or the command was repeated before it was done", wait},
    {"0C", "the command is too short, or a parameter of it is wrong", report},
    {"0D", "the command is too long or unknown", report},
    {"0E", "it does not know the command", check_model},
    {"0F", "it does not support the command", check_model},
    {"0G", "the user string is too long", report},
    {"0H", "the user string or the command's length is wrong", report},
    {"0I", "it is in firmware update mode",
     "finish the update with the maker's tool, then switch its power off and on"},
    {"0L", "it is in an abnormal state",
     "switch its power off and on; if it comes back, look at it with the maker's tool (UrgBenriPlus)"},
    {"0M", "its measurement is not stable yet",
     "wait until its motor runs steadily; if it stays, check power supply and vibration"},
    {"10", "the laser is off or the sensor is busy in another mode",
     "wait, it is asked again every second; check that no other program is connected to it"},
    {"98", "it had stopped to check itself and measures again", "nothing to do"},
}};

}  // namespace

StatusClass class_of(std::string_view status) {
  if (status == "00") return StatusClass::accepted;
  if (status == "99") return StatusClass::data;
  if (status == "98") return StatusClass::resumed;
  if (status == "0E" || status == "0F") return StatusClass::unknown;
  const unsigned value = status.size() == 2 ? number_in<unsigned>(status).value_or(0) : 0;
  if (value >= 50) return StatusClass::fault;
  return value >= 21 ? StatusClass::verifying : StatusClass::refused;
}

std::string explain_status(std::string_view command, std::string_view status) {
  const std::string what =
      "the sensor answers " + std::string(command) + " with status " + std::string(status) + ": ";
  const StatusClass is = class_of(status);
  if (is == StatusClass::verifying)
    return what +
           "it has stopped measuring to check an error; keep dirt and strong light off its window, it "
           "goes on by itself if the error does not last";
  if (is == StatusClass::fault)
    return what +
           "it reports hardware trouble; switch its power off and on, and have it repaired if it comes back";
  for (const Meaning& meaning : meanings) {
    if (meaning.status == status)
      return what + std::string(meaning.words) + "; " + std::string(meaning.remedy);
  }
  return what + "no document known here explains it; " + std::string(report);
}

}  // namespace lidard::hokuyo
