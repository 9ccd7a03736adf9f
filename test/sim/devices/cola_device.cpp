// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/cola_device.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace lidard::sim {
namespace {

std::string text_of(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace

ColaDevice::ColaDevice(ColaDeviceOptions options, ColaScene scene, Stamp power_on)
    : TcpDevice(options.transit),
      options_(std::move(options)),
      scene_(std::move(scene)),
      power_on_(power_on) {}

Span ColaDevice::period() const { return span_from_seconds(1 / options_.hz); }
Span ColaDevice::beam_period() const {
  return span_from_seconds(options_.scans_per_turn / options_.hz * options_.exact_step_deg / 360);
}

void ColaDevice::connected(Stamp) {
  buffer_.clear();
  subscribed_ = logged_in_ = false;
}

void ColaDevice::disconnected() {
  TcpDevice::disconnected();
  subscribed_ = logged_in_ = false;
}

void ColaDevice::power_cycle(Stamp now) {
  disconnected();
  power_on_ = now;
  next_scan_ = 0;
  telegrams_ = 0;
  received_.clear();
}

std::uint32_t ColaDevice::device_us(Stamp when) const {
  const double passed =
      static_cast<double>((when - power_on_).count()) * 1e-3 * (1 + options_.clock_ppm * 1e-6);
  return options_.clock_us + static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(passed)));
}

/// Whatever is not framed in its own dialect it throws away.
bool ColaDevice::take_frame(std::string& payload) {
  const bool binary = options_.dialect == Cola::binary;
  const std::string mark = binary ? std::string(4, '\2') : "\2s";
  const std::size_t begin = buffer_.find(mark);
  if (begin == std::string::npos) return false;
  buffer_.erase(0, begin);
  if (!binary) {
    const std::size_t end = buffer_.find('\3');
    if (end == std::string::npos) return false;
    payload = buffer_.substr(1, end - 1);
    buffer_.erase(0, end + 1);
    return true;
  }
  if (buffer_.size() < 8) return false;
  std::size_t length = 0;
  for (std::size_t i = 4; i < 8; ++i) length = length << 8U | static_cast<std::uint8_t>(buffer_[i]);
  if (buffer_.size() < length + 9) return false;
  payload = buffer_.substr(8, length);
  char sum = 0;
  for (const char c : payload) sum = static_cast<char>(sum ^ c);
  const bool right = sum == buffer_[length + 8];
  buffer_.erase(0, right ? length + 9 : 1);
  return right || take_frame(payload);
}

void ColaDevice::receive(std::string_view bytes, Stamp now) {
  produce(now);
  received_ += bytes;
  buffer_ += bytes;
  for (std::string payload; take_frame(payload);) answer(payload, now);
}

void ColaDevice::answer(const std::string& payload, Stamp now) {
  const std::size_t end = std::min(payload.find(' ', 4), payload.size());
  const std::string command = payload.substr(0, end);
  const std::string arguments = end < payload.size() ? payload.substr(end + 1) : "";
  send(text_of(answer_to(command, arguments, now)), now + options_.answer_time);
}

std::vector<std::uint8_t> ColaDevice::refuse(unsigned code) const {
  if (options_.dialect == Cola::text) return ColaWords(Cola::text, "sFA").number(code, 2).bytes();
  return ColaWords(Cola::binary, std::string("sFA") + '\0' + static_cast<char>(code)).bytes();
}

std::vector<std::uint8_t> ColaDevice::answer_to(const std::string& command, const std::string& arguments,
                                                Stamp now) {
  const auto words = [&](const std::string& text) { return ColaWords(options_.dialect, text); };
  if (const auto refusal = options_.refusals.find(command); refusal != options_.refusals.end())
    return refuse(refusal->second);
  if (now - power_on_ < options_.boot) return refuse(4);
  if (command == "sRN DeviceIdent")
    return words("sRA DeviceIdent").text(options_.type, 2).text(options_.version, 2).bytes();
  if (command == "sRN LMPoutputRange") {
    const double end =
        options_.start / 1e4 + options_.exact_step_deg * static_cast<double>(options_.beams - 1);
    ColaWords out = words("sRA LMPoutputRange");
    out.number(1, 2).number(options_.step, 4).number(static_cast<std::uint32_t>(options_.start), 4);
    return out.number(static_cast<std::uint32_t>(std::lround(end * 1e4)), 4).bytes();
  }
  if (command == "sRN LMDscandatacfg") return settings();
  if (command == "sRN LCMstate" && options_.contamination)
    return words("sRA LCMstate").number(*options_.contamination, 1).bytes();
  if (command == "sRN MCAngleCompSin" && options_.compensation) {
    ColaWords out = words("sRA MCAngleCompSin");
    for (std::size_t i = 0; i < 3; ++i)
      out.number(static_cast<std::uint32_t>(options_.compensation->at(i)),
                 i == 1 || options_.wide_compensation ? 4 : 2);
    return out.bytes();
  }
  if (command == "sWN LMDscandatacfg") {
    if (!logged_in_) return refuse(10);
    take_settings(arguments);
    return words("sWA LMDscandatacfg").bytes();
  }
  if (command == "sMN SetAccessMode") {
    logged_in_ = is_password(arguments);
    return words("sAN SetAccessMode").number(logged_in_ ? 1 : 0, 1).bytes();
  }
  if (command == "sMN Run") {
    logged_in_ = false;
    return words("sAN Run").number(1, 1).bytes();
  }
  if (command.substr(0, 3) != "sEN") return refuse(command.substr(0, 3) == "sMN" ? 2 : 3);
  const bool on = !arguments.empty() && arguments.back() != '0' && arguments.back() != '\0';
  if (command == "sEN LMDscandata") {
    subscribed_ = on;
    next_scan_ = (now - power_on_) / period() + 1;
  }
  return words("sEA " + command.substr(4)).number(on ? 1 : 0, 1).bytes();
}

std::vector<std::uint8_t> ColaDevice::settings() const {
  ColaWords out(options_.dialect, "sRA LMDscandatacfg");
  out.number(options_.channels, 1).number(0, 1).number(options_.rssi, 1);
  for (int i = 0; i < 7; ++i) out.number(0, 1);
  return out.number(0, 1).number(options_.interval, 2).bytes();
}

/// Thirteen bytes, or as many fields less one of the 16-bit number at the end.
void ColaDevice::take_settings(const std::string& arguments) {
  std::vector<unsigned> fields;
  if (options_.dialect == Cola::binary) {
    for (const char c : arguments) fields.push_back(static_cast<std::uint8_t>(c));
    if (fields.size() != 13) return;
    fields[11] = fields[11] << 8U | fields[12];
  } else {
    const char* at = arguments.c_str();
    for (char* end = nullptr; *at != '\0'; at = end) {
      fields.push_back(static_cast<unsigned>(std::strtoul(at, &end, 16)));
      if (end == at) return;
    }
    if (fields.size() != 12) return;
  }
  ++writes_;
  options_.channels = static_cast<std::uint8_t>(fields[0]);
  options_.rssi = static_cast<std::uint8_t>(fields[2]);
  options_.interval = static_cast<std::uint16_t>(fields[11]);
}

bool ColaDevice::is_password(const std::string& arguments) const {
  char expected[24];
  if (options_.dialect == Cola::text) {
    std::snprintf(expected, sizeof expected, "3 %08X", options_.password);
    return arguments == expected;
  }
  std::string bytes(1, '\3');
  for (const unsigned shift : {24U, 16U, 8U, 0U})
    bytes += static_cast<char>(options_.password >> shift & 0xffU);
  return arguments == bytes;
}

void ColaDevice::produce(Stamp until) {
  if (!subscribed_ || !options_.measures) return;
  const Span sweep = beam_period() * static_cast<std::int64_t>(options_.beams - 1);
  for (;; ++next_scan_) {
    const Stamp first_beam = power_on_ + span_from_seconds(static_cast<double>(next_scan_) / options_.hz);
    if (first_beam + sweep + options_.processing > until) return;
    const bool due = next_scan_ % options_.interval == 0;
    if (!logged_in_ && due) send_scan(next_scan_, first_beam);
  }
}

void ColaDevice::send_scan(std::int64_t number, Stamp first_beam) {
  const Stamp last_beam = first_beam + beam_period() * static_cast<std::int64_t>(options_.beams - 1);
  SickScan scan;
  scan.serial = options_.serial;
  std::copy(options_.status.begin(), options_.status.end(), scan.status);
  scan.telegram_counter = telegrams_++;
  scan.scan_counter = static_cast<std::uint16_t>(number);
  scan.start_us = device_us(options_.stamps_last_beam ? last_beam : first_beam);
  scan.transmit_us = device_us(last_beam + options_.processing);
  scan.layer = options_.layers[static_cast<std::size_t>(number) % options_.layers.size()];
  scan.scan_frequency = static_cast<std::uint32_t>(std::lround(options_.hz * 100));
  scan.measurement_frequency =
      static_cast<std::uint32_t>(std::lround(1e9 / static_cast<double>(beam_period().count()) / 100));
  const std::vector<ColaBeam> beams = scene_(first_beam, options_.beams);
  static const char* const names[] = {"DIST1", "DIST2", "DIST3", "DIST4", "DIST5"};
  for (unsigned echo = 0; echo < 5; ++echo) {
    if ((options_.channels >> echo & 1U) == 0) continue;
    SickChannel channel{names[echo], 1, 0, options_.start, options_.step, true, {}};
    for (const ColaBeam& beam : beams)
      channel.values.push_back(echo < 2 ? beam.mm.at(echo) : std::uint16_t{0});
    scan.channels.push_back(std::move(channel));
  }
  if (options_.rssi != 0) {
    SickChannel channel{"RSSI1", 1, 0, options_.start, options_.step, false, {}};
    for (const ColaBeam& beam : beams) channel.values.push_back(beam.rssi);
    scan.channels.push_back(std::move(channel));
  }
  send(text_of(scan.bytes(options_.dialect)), last_beam + options_.processing, first_beam);
}

}  // namespace lidard::sim
