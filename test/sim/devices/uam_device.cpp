// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/uam_device.h"

#include <cstdio>

namespace lidard::sim {
namespace {

constexpr char uam_stx = 0x02, uam_etx = 0x03;
constexpr Span turn{30'000'000};
constexpr Span answer_time{300'000};

std::string hex(unsigned value, int digits) {
  char text[16];
  std::snprintf(text, sizeof text, "%0*X", digits, value);
  return text;
}

std::string padded(std::string text, std::size_t size) {
  text.resize(size, ' ');
  return text;
}

}  // namespace

std::uint16_t uam_checksum(const std::string& text) {
  unsigned crc = 0;
  for (const char c : text) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0x8408U : crc >> 1U;
  }
  return static_cast<std::uint16_t>(crc);
}

std::string uam_frame(const std::string& text) {
  const std::string counted = hex(static_cast<unsigned>(text.size() + 10), 4) + text;
  return uam_stx + counted + hex(uam_checksum(counted), 4) + uam_etx;
}

void UamDevice::disconnected() {
  TcpDevice::disconnected();
  line_.clear();
  stream_.clear();
}

void UamDevice::receive(std::string_view bytes, Stamp now) {
  received_ += bytes;
  for (const char c : bytes) {
    if (c == uam_stx) line_.clear();
    line_ += c;
    if (c == uam_etx && line_.size() >= 14) answer(line_.substr(5, 4), now);
  }
}

void UamDevice::answer(const std::string& command, Stamp now) {
  produce(now);
  const Stamp soon = now + answer_time;
  if (command == "VR00") {
    return send(uam_frame("VR0000" + padded(options_.product, 29) + "," + padded(options_.firmware, 29) +
                          "," + padded("", 37) + "," + padded(options_.serial, 8)),
                soon);
  }
  if (command == "AR00") return send(scan(now), soon);
  const bool starts = command == "AR02" || command == "AR04" || command == "AR07";
  const bool ready = now - power_on_ >= options_.boot;
  if (starts && ready) {
    stream_ = command == "AR02" ? "00" : command == "AR04" ? "01" : "06";
    next_turn_ = (now - power_on_) / turn + 1;
  }
  if (command == "AR03" || command == "AR05" || command == "AR08") stream_.clear();
  send(uam_frame(command + (starts && !ready ? "01" : "00")), soon);
}

std::string UamDevice::scan(Stamp begin) const {
  const UamReport& r = options_.report;
  const std::string kind = stream_.empty() ? "00" : stream_;
  const std::size_t beams = kind == "06" ? 2161 : 1081;
  const double passed_ms =
      static_cast<double>((begin - power_on_).count()) * 1e-6 * (1 + options_.clock_ppm * 1e-6);
  std::string text = "AR" + kind + "00";
  text += hex(r.operating_mode, 1) + hex(r.area, 2) + hex(r.error_state, 1) + hex(r.error_code, 2) +
          hex(r.lockout, 1) + hex(r.ossd1, 1) + hex(r.ossd2, 1) + hex(r.warning1, 1) + hex(r.warning2, 1) +
          hex(r.ossd3, 1) + hex(r.ossd4, 1) + "00" + hex(r.muting1, 1) + hex(r.muting2, 1) +
          hex(r.reset1, 1) + hex(r.reset2, 1) + hex(r.encoder_speed, 4) +
          hex(options_.counter_ms + static_cast<std::uint32_t>(passed_ms), 8) + hex(r.laser_off, 1) +
          hex(r.contaminated, 1) + "000000";
  const std::vector<UamBeam> seen = scene_(begin, beams);
  for (const UamBeam& beam : seen) text += hex(beam.distance, 4);
  for (std::size_t i = 0; kind == "01" && i < seen.size(); ++i) text += hex(seen[i].intensity, 4);
  return uam_frame(text);
}

void UamDevice::produce(Stamp until) {
  while (!stream_.empty()) {
    const Stamp begin = power_on_ + turn * next_turn_;
    const Stamp leaves = begin + turn * 3 / 4 + options_.processing;
    if (leaves > until) return;
    send(scan(begin), leaves, begin);
    ++next_turn_;
  }
}

}  // namespace lidard::sim
