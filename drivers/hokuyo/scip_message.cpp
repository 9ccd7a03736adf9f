// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_message.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace lidard::hokuyo {
namespace {

// A full turn of three echoes with intensities, 10 000 steps (the request has four digits), is less.
constexpr std::size_t longest_answer = 256 * 1024;
constexpr unsigned first_code = 0x30;
constexpr unsigned six_bits = 0x3f;
constexpr std::size_t longest_number = 11;
// Hokuyo C-42-03320B p. 7: up to 16 characters of the host's own, here with a semicolon before.
constexpr std::size_t longest_user_string = 17;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Reads exactly `digits` decimal digits from the front of `text`; -1 if they are not there.
int take_decimal(std::string_view& text, std::size_t digits) {
  if (text.size() < digits) return -1;
  int value = 0;
  for (const char c : text.substr(0, digits)) {
    if (!is_digit(c)) return -1;
    value = 10 * value + (c - '0');
  }
  text.remove_prefix(digits);
  return value;
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

std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

ScipReader::ScipReader(Counters& counters) : counters_(counters) {}

void ScipReader::interrupt() {
  if (begin_ < buffer_.size()) ++counters_.incomplete;
  buffer_.clear();
  begin_ = searched_ = 0;
  torn_ = true;
}

void ScipReader::add(ByteView bytes) {
  if (begin_ > 0) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    searched_ -= begin_;
    begin_ = 0;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

bool ScipReader::next(ScipMessage& message) {
  while (true) {
    // No answer begins with an empty line, but a stream may be joined between the two LF that end one.
    while (begin_ < buffer_.size() && buffer_[begin_] == '\n') ++begin_;
    searched_ = std::max(searched_, begin_);
    const auto from = buffer_.begin() + static_cast<std::ptrdiff_t>(searched_);
    constexpr std::array<std::uint8_t, 2> empty_line = {'\n', '\n'};
    const auto end = std::search(from, buffer_.end(), empty_line.begin(), empty_line.end());
    if (end == buffer_.end()) {
      // The last byte may be the first of the two.
      searched_ = std::max(begin_, buffer_.empty() ? 0 : buffer_.size() - 1);
      if (buffer_.size() - begin_ > longest_answer) interrupt();
      return false;
    }
    const auto size = static_cast<std::size_t>(end - buffer_.begin()) - begin_ + 1;
    const std::string_view text(reinterpret_cast<const char*>(buffer_.data()) + begin_, size);
    begin_ += size + 1;
    const bool sound = parse(text, message);
    const bool was_torn = torn_;
    torn_ = false;
    if (sound) return true;
    if (was_torn) {
      ++counters_.incomplete;
    } else {
      ++counters_.packets;
      counters_.reject(Reject::magic);
    }
  }
}

bool ScipReader::parse(std::string_view text, ScipMessage& message) const {
  message.echo = take_line(text);
  const std::string_view status = take_line(text);
  if (message.echo.size() < 2 || status.size() != 3 || !has_checksum(status)) return false;
  message.status = status.substr(0, 2);
  message.body = text;
  return true;
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
  request.first_step = take_decimal(echo, 4);
  request.last_step = take_decimal(echo, 4);
  const int cluster = take_decimal(echo, 2);
  request.cluster = std::max(1, cluster);
  request.skip = request.continuous ? take_decimal(echo, 1) : 0;
  const int scans = request.continuous ? take_decimal(echo, 2) : 0;
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
    const std::string_view line = take_line(body);
    if (!has_checksum(line)) return false;
    flat.insert(flat.end(), line.begin(), line.end() - 1);
  }
  return true;
}

}  // namespace lidard::hokuyo
