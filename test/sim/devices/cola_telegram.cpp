// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/cola_telegram.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>

namespace lidard::sim {

void ColaWords::separate() {
  if (dialect_ == Cola::text || !has_values_) payload_ += ' ';
  has_values_ = true;
}

ColaWords& ColaWords::number(std::uint32_t value, int bytes) {
  separate();
  if (dialect_ == Cola::text) {
    char digits[12];
    std::snprintf(digits, sizeof digits, "%X", bytes < 4 ? value & ((1U << 8 * bytes) - 1) : value);
    payload_ += digits;
    return *this;
  }
  for (int i = bytes - 1; i >= 0; --i) payload_ += static_cast<char>(value >> 8 * i & 0xffU);
  return *this;
}

ColaWords& ColaWords::real(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  if (dialect_ == Cola::binary) return number(bits, 4);
  char digits[12];
  std::snprintf(digits, sizeof digits, "%08X", bits);
  return letters(digits);
}

ColaWords& ColaWords::letters(const std::string& text) {
  separate();
  payload_ += text;
  return *this;
}

ColaWords& ColaWords::text(const std::string& text, int length_bytes) {
  number(static_cast<std::uint32_t>(text.size()), length_bytes);
  if (dialect_ == Cola::text && !text.empty()) payload_ += ' ';
  payload_ += text;
  return *this;
}

std::vector<std::uint8_t> ColaWords::bytes() const {
  std::vector<std::uint8_t> out;
  if (dialect_ == Cola::text) {
    out.push_back(2);
    out.insert(out.end(), payload_.begin(), payload_.end());
    out.push_back(3);
    return out;
  }
  out.assign(4, 2);
  const std::size_t size = payload_.size();
  for (const unsigned shift : {24U, 16U, 8U, 0U}) out.push_back(static_cast<std::uint8_t>(size >> shift));
  std::uint8_t sum = 0;
  for (const char c : payload_) {
    out.push_back(static_cast<std::uint8_t>(c));
    sum = static_cast<std::uint8_t>(sum ^ out.back());
  }
  out.push_back(sum);
  return out;
}

std::optional<std::vector<std::uint32_t>> parse_numbers(Cola dialect, const std::string& arguments,
                                                        const std::vector<int>& widths) {
  std::vector<std::uint32_t> numbers;
  if (dialect == Cola::text) {
    std::istringstream words(arguments);
    for (std::string word; words >> word;) {
      char* end = nullptr;
      const int base = word[0] == '+' || word[0] == '-' ? 10 : 16;
      numbers.push_back(static_cast<std::uint32_t>(std::strtoll(word.c_str(), &end, base)));
      if (*end != '\0') return std::nullopt;
    }
    if (numbers.size() != widths.size()) return std::nullopt;
    return numbers;
  }
  std::size_t at = 0;
  for (const int width : widths) {
    std::uint32_t number = 0;
    for (int i = 0; i < width; ++i) {
      if (at == arguments.size()) return std::nullopt;
      number = number << 8U | static_cast<std::uint8_t>(arguments[at++]);
    }
    numbers.push_back(number);
  }
  if (at != arguments.size()) return std::nullopt;
  return numbers;
}

namespace {

void put_channels(ColaWords& out, const std::vector<SickChannel>& channels, bool wide) {
  const auto count =
      std::count_if(channels.begin(), channels.end(), [&](const auto& c) { return c.wide == wide; });
  out.number(static_cast<std::uint32_t>(count), 2);
  for (const SickChannel& channel : channels) {
    if (channel.wide != wide) continue;
    out.letters(channel.name).real(channel.scale).real(channel.offset);
    out.number(static_cast<std::uint32_t>(channel.start), 4).number(channel.step, 2);
    out.number(static_cast<std::uint32_t>(channel.values.size()), 2);
    for (const std::uint16_t value : channel.values) out.number(value, wide ? 2 : 1);
  }
}

void put_text(ColaWords& out, const std::string& text) {
  out.number(text.empty() ? 0 : 1, 2);
  // 16 bits of length, as an LMS151 sends them.
  if (!text.empty()) out.text(text, 2);
}

}  // namespace

std::vector<std::uint8_t> SickScan::bytes(Cola dialect) const {
  ColaWords out(dialect, command);
  out.number(version, 2).number(device, 2).number(serial, 4).number(status[0], 1).number(status[1], 1);
  out.number(telegram_counter, 2).number(scan_counter, 2).number(start_us, 4).number(transmit_us, 4);
  for (const std::uint8_t byte : {inputs[0], inputs[1], outputs[0], outputs[1]}) out.number(byte, 1);
  out.number(static_cast<std::uint16_t>(layer), 2).number(scan_frequency, 4).number(measurement_frequency, 4);
  out.number(static_cast<std::uint32_t>(encoders.size()), 2);
  for (const auto& [ticks, speed] : encoders) out.number(ticks, 4).number(speed, 2);
  put_channels(out, channels, true);
  put_channels(out, channels, false);
  out.number(position ? 1 : 0, 2);
  for (int i = 1; position && i <= 6; ++i) out.real(static_cast<float>(i) / 2);
  if (position) out.number(3, 1);
  put_text(out, name);
  put_text(out, comment);
  out.number(calendar_us ? 1 : 0, 2);
  if (calendar_us) {
    const auto second = static_cast<std::uint32_t>(*calendar_us / 1'000'000);
    out.number(1970, 2).number(1, 1).number(1 + second / 86400, 1).number(second / 3600 % 24, 1);
    out.number(second / 60 % 60, 1).number(second % 60, 1);
    out.number(static_cast<std::uint32_t>(*calendar_us % 1'000'000), 4);
  }
  out.number(event ? 1 : 0, 2);
  if (event) out.letters("FDEC").number(7, 4);
  return out.bytes();
}

}  // namespace lidard::sim
