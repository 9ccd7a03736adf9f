// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/cola_device.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

namespace lidard::sim {
namespace {

std::string text_of(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

/// Error codes of SICK 8014631; 8 as an LMS1xx answers too few arguments (sick_scan_xd issue 39), 15 as an
/// MRS1104 without inertial unit answers the subscription of one.
enum Refusal : unsigned {
  no_access = 1,
  unknown_method = 2,
  unknown_variable = 3,
  not_now = 4,
  invalid_value = 5,
  wrong_arguments = 8,
  no_write_access = 10,
  unknown_command = 12,
  unknown_event = 15,
};

const std::vector<int> outputs_widths = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2};

}  // namespace

ColaDevice::ColaDevice(ColaDeviceOptions options, ColaScene scene, Stamp power_on)
    : TcpDevice(options.transit),
      options_(std::move(options)),
      scene_(std::move(scene)),
      power_on_(power_on),
      outputs_(outputs_widths.size()),
      last_(options_.beams - 1) {
  set_up();
}

void ColaDevice::set_up() {
  variables_ = cola_variables(options_.dialect, options_.type, options_.version, options_.serial);
}

Span ColaDevice::period() const { return span_from_seconds(1 / options_.hz); }
Span ColaDevice::beam_period() const {
  return span_from_seconds(options_.scans_per_turn / options_.hz * options_.exact_step_deg / 360);
}

void ColaDevice::connected(Stamp) {
  buffer_.clear();
  subscribed_ = polled_ = logged_in_ = false;
}

void ColaDevice::disconnected() {
  TcpDevice::disconnected();
  subscribed_ = polled_ = logged_in_ = false;
}

void ColaDevice::power_cycle(Stamp now) {
  disconnected();
  power_on_ = now;
  next_scan_ = 0;
  telegrams_ = 0;
  stopped_ = false;
  received_.clear();
}

std::uint32_t ColaDevice::device_us(Stamp when) const {
  const double passed =
      static_cast<double>((when - power_on_).count()) * 1e-3 * (1 + options_.clock_ppm * 1e-6);
  return options_.clock_us + static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(passed)));
}

/// Whatever is not framed in its own dialect it throws away.
bool ColaDevice::take_frame(std::string& payload) {
  if (options_.dialect == Cola::text) {
    for (std::size_t end = 0; (end = buffer_.find('\3')) != std::string::npos;) {
      const std::size_t begin = buffer_.rfind('\2', end);
      if (begin != std::string::npos) payload = buffer_.substr(begin + 1, end - begin - 1);
      buffer_.erase(0, end + 1);
      if (begin != std::string::npos) return true;
    }
    return false;
  }
  const std::string mark(4, '\2');
  constexpr std::size_t longest = 4096;
  for (std::size_t begin = 0; (begin = buffer_.find(mark)) != std::string::npos; buffer_.erase(0, 1)) {
    buffer_.erase(0, begin);
    if (buffer_.size() < 8) return false;
    std::size_t length = 0;
    for (std::size_t i = 4; i < 8; ++i) length = length << 8U | static_cast<std::uint8_t>(buffer_[i]);
    if (length > longest) continue;
    if (buffer_.size() < length + 9) return false;
    payload = buffer_.substr(8, length);
    char sum = 0;
    for (const char c : payload) sum = static_cast<char>(sum ^ c);
    if (sum != buffer_[length + 8]) continue;
    buffer_.erase(0, length + 9);
    return true;
  }
  return false;
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
  const Telegram telegram = answer_to(command, arguments, now);
  if (!telegram.empty()) send(text_of(telegram), now + options_.answer_time);
}

ColaDevice::Telegram ColaDevice::refuse(unsigned code) const {
  if (options_.dialect == Cola::text) return words("sFA").number(code, 2).bytes();
  return words(std::string("sFA") + '\0' + static_cast<char>(code)).bytes();
}

ColaDevice::Telegram ColaDevice::answer_to(const std::string& command, const std::string& arguments,
                                           Stamp now) {
  if (const auto refusal = options_.refusals.find(command); refusal != options_.refusals.end())
    return refuse(refusal->second);
  if (now - power_on_ < options_.boot) return refuse(not_now);
  const std::string kind = command.substr(0, 3),
                    name = command.substr(std::min<std::size_t>(4, command.size()));
  if (kind == "sRN") return read(name, now);
  if (kind == "sWN") return write(name, arguments);
  if (kind == "sMN") return call(name, arguments);
  if (kind == "sEN") return subscribe(name, arguments, now);
  // The identity by its index, as older drivers ask for it.
  if (command == "sRI 0") return words("sRA 0").text(options_.type, 2).text(options_.version, 2).bytes();
  return refuse(unknown_command);
}

ColaDevice::Telegram ColaDevice::read(const std::string& name, Stamp now) {
  if (name == "LMDscandata") {
    polled_ = true;
    if (!subscribed_) next_scan_after(now);
    return {};
  }
  if (const auto answer = measured(name)) return answer->bytes();
  const auto found = variables_.find(name);
  if (found == variables_.end()) return refuse(unknown_variable);
  return words("sRA " + name + found->second.arguments).bytes();
}

std::optional<ColaWords> ColaDevice::measured(const std::string& name) const {
  ColaWords out = words("sRA " + name);
  const auto angle = [this](std::size_t beam) {
    const double deg = options_.start / 1e4 + options_.exact_step_deg * static_cast<double>(beam);
    return static_cast<std::uint32_t>(std::lround(deg * 1e4));
  };
  if (name == "DeviceIdent") return out.text(options_.type, 2).text(options_.version, 2);
  if (name == "SCdevicestate") return out.number(logged_in_ || stopped_ ? 0 : 1, 1);
  if (name == "STlms") {
    out.number(stopped_ ? 6 : 7, 2).number(0, 1).text("12:00:00", 2).text("01.01.1970", 2);
    return out.number(0, 2).number(0, 2).number(0, 2);  // lamps
  }
  if (name == "LMPoutputRange")
    return out.number(1, 2).number(options_.step, 4).number(angle(first_), 4).number(angle(last_), 4);
  if (name == "LMPscancfg") {
    out.number(static_cast<std::uint32_t>(std::lround(options_.hz * 100)), 4).number(1, 2);
    return out.number(options_.step, 4).number(angle(0), 4).number(angle(options_.beams - 1), 4);
  }
  if (name == "LMDscandatacfg") {
    std::vector<std::uint32_t> now = outputs_;
    now[0] = options_.channels;
    now[2] = options_.rssi;
    now[11] = options_.interval;
    for (std::size_t i = 0; i < now.size(); ++i) out.number(now[i], outputs_widths[i]);
    return out;
  }
  if (name == "LCMstate" && options_.contamination) return out.number(*options_.contamination, 1);
  if (name == "MCAngleCompSin" && options_.compensation) {
    for (std::size_t i = 0; i < 3; ++i)
      out.number(static_cast<std::uint32_t>(options_.compensation->at(i)),
                 i == 1 || options_.wide_compensation ? 4 : 2);
    return out;
  }
  return std::nullopt;
}

ColaDevice::Telegram ColaDevice::write(const std::string& name, const std::string& arguments) {
  const auto found = variables_.find(name);
  const bool known = found != variables_.end() || measured(name);
  if (!known) return refuse(unknown_variable);
  const bool writable = found != variables_.end() ? found->second.writable
                                                  : name == "LMDscandatacfg" || name == "LMPoutputRange";
  if (!logged_in_ || !writable) return refuse(no_write_access);
  const std::optional<unsigned> refusal = name == "LMDscandatacfg"   ? apply_outputs(arguments)
                                          : name == "LMPoutputRange" ? apply_range(arguments)
                                          : name == "FREchoFilter"   ? apply_echoes(arguments)
                                                                     : std::nullopt;
  if (refusal) return refuse(*refusal);
  if (found != variables_.end()) found->second.arguments = " " + arguments;
  const Telegram done = words("sWA " + name).bytes();
  if (name == "EIHstCola") {
    const Cola wanted = !arguments.empty() && arguments.back() % 2 != 0 ? Cola::binary : Cola::text;
    if (std::exchange(options_.dialect, wanted) != wanted) set_up();
  }
  return done;
}

std::optional<unsigned> ColaDevice::apply_outputs(const std::string& arguments) {
  const auto given = parse_numbers(options_.dialect, arguments, outputs_widths);
  if (!given) return wrong_arguments;
  ++writes_;
  outputs_ = *given;
  options_.channels = static_cast<std::uint8_t>(outputs_[0]);
  options_.rssi = static_cast<std::uint8_t>(outputs_[2]);
  options_.interval = static_cast<std::uint16_t>(std::max(1U, outputs_[11]));
  return std::nullopt;
}

/// The beams between the given angles; the step is that of the model.
std::optional<unsigned> ColaDevice::apply_range(const std::string& arguments) {
  const auto given = parse_numbers(options_.dialect, arguments, {2, 4, 4, 4});
  if (!given) return wrong_arguments;
  if (given->at(0) != 1 || given->at(1) != options_.step) return not_now;
  const auto beam = [this](std::uint32_t angle) {
    return (static_cast<std::int32_t>(angle) - options_.start) / 1e4 / options_.exact_step_deg;
  };
  // Drivers round angles to 1/10000 deg, and some calculate them from radians with six digits.
  constexpr double tolerance = 0.01;
  const double first = std::max(0.0, std::ceil(beam(given->at(2)) - tolerance));
  const double last =
      std::min(static_cast<double>(options_.beams - 1), std::floor(beam(given->at(3)) + tolerance));
  if (first > last) return invalid_value;
  first_ = static_cast<std::size_t>(first);
  last_ = static_cast<std::size_t>(last);
  return std::nullopt;
}

std::optional<unsigned> ColaDevice::apply_echoes(const std::string& arguments) {
  const auto given = parse_numbers(options_.dialect, arguments, {1});
  if (!given) return wrong_arguments;
  if (given->at(0) > 2) return invalid_value;
  echo_filter_ = given->at(0);
  return std::nullopt;
}

ColaDevice::Telegram ColaDevice::call(const std::string& name, const std::string& arguments) {
  const ColaWords done = words("sAN " + name);
  const auto result = [&done](std::uint32_t value) { return ColaWords(done).number(value, 1); };
  if (name == "SetAccessMode") {
    const auto given = parse_numbers(options_.dialect, arguments, {1, 4});
    if (!given) return refuse(wrong_arguments);
    logged_in_ = given->at(0) == 3 && given->at(1) == options_.password;
    return result(logged_in_ ? 1 : 0).bytes();
  }
  if (name == "Run") {
    logged_in_ = false;
    return result(1).bytes();
  }
  // What they return if they succeed; that of the last one is unverified.
  static const std::map<std::string, unsigned> methods = {{"LMCstartmeas", 0},   {"LMCstopmeas", 0},
                                                          {"LMCstandby", 0},     {"mEEwriteall", 1},
                                                          {"mLMPsetscancfg", 0}, {"mCLsetscancfglist", 0}};
  const auto method = methods.find(name);
  if (method == methods.end()) return refuse(unknown_method);
  if (!logged_in_) return refuse(no_access);
  if (name == "mLMPsetscancfg") {
    const std::vector<int> widths = {4, 2, 4, 4, 4};
    const auto given = parse_numbers(options_.dialect, arguments, widths);
    if (!given) return refuse(wrong_arguments);
    // Rate and step are those of the scene: 1 refuses the rate, 2 the step.
    const bool rate = given->at(0) == static_cast<std::uint32_t>(std::lround(options_.hz * 100));
    ColaWords out = result(!rate ? 1 : given->at(2) != options_.step ? 2 : 0);
    for (std::size_t i = 0; i < widths.size(); ++i) out.number(given->at(i), widths[i]);
    return out.bytes();
  }
  if (name.rfind("LMC", 0) == 0) stopped_ = name != "LMCstartmeas";
  return result(method->second).bytes();
}

ColaDevice::Telegram ColaDevice::subscribe(const std::string& name, const std::string& arguments, Stamp now) {
  static const std::set<std::string> events = {"LMDscandata", "LFErec", "LIDinputstate", "LIDoutputstate"};
  if (events.count(name) == 0) return refuse(unknown_event);
  const auto given = parse_numbers(options_.dialect, arguments, {1});
  if (!given) return refuse(wrong_arguments);
  const bool on = given->at(0) != 0;
  if (name == "LMDscandata") {
    subscribed_ = on;
    next_scan_after(now);
  }
  return words("sEA " + name).number(on ? 1 : 0, 1).bytes();
}

void ColaDevice::produce(Stamp until) {
  if ((!subscribed_ && !polled_) || !options_.measures) return;
  const Span sweep = beam_period() * static_cast<std::int64_t>(last_);
  for (;; ++next_scan_) {
    const Stamp first_beam = power_on_ + span_from_seconds(static_cast<double>(next_scan_) / options_.hz);
    if (first_beam + sweep + options_.processing > until) return;
    const bool due = polled_ || (subscribed_ && next_scan_ % options_.interval == 0);
    if (!logged_in_ && !stopped_ && due) send_scan(next_scan_, first_beam);
  }
}

void ColaDevice::send_scan(std::int64_t number, Stamp sweep) {
  const auto time_of = [&](std::size_t beam) {
    return sweep + beam_period() * static_cast<std::int64_t>(beam);
  };
  const Stamp last_beam = time_of(last_), leaves = last_beam + options_.processing;
  SickScan scan;
  if (std::exchange(polled_, false)) scan.command = "sRA LMDscandata";
  scan.serial = options_.serial;
  std::copy(options_.status.begin(), options_.status.end(), scan.status);
  scan.telegram_counter = telegrams_++;
  scan.scan_counter = static_cast<std::uint16_t>(number);
  scan.start_us = device_us(options_.stamps_last_beam ? last_beam : time_of(first_));
  scan.transmit_us = device_us(leaves);
  scan.layer = options_.layers[static_cast<std::size_t>(number) % options_.layers.size()];
  scan.scan_frequency = static_cast<std::uint32_t>(std::lround(options_.hz * 100));
  scan.measurement_frequency =
      static_cast<std::uint32_t>(std::lround(1e9 / static_cast<double>(beam_period().count()) / 100));
  // Without a server of time it begins in 1970.
  if (outputs_[10] != 0)
    scan.calendar_us = static_cast<std::uint64_t>((last_beam - power_on_).count() / 1000);
  std::vector<ColaBeam> beams = scene_(sweep, options_.beams);
  beams = {beams.begin() + static_cast<std::ptrdiff_t>(first_),
           beams.begin() + static_cast<std::ptrdiff_t>(last_ + 1)};
  const auto start = static_cast<std::int32_t>(
      options_.start + std::lround(1e4 * options_.exact_step_deg * static_cast<double>(first_)));
  const auto add = [&](std::string name, bool wide, const auto& value_of) {
    SickChannel channel{std::move(name), 1, 0, start, options_.step, wide, {}};
    for (const ColaBeam& beam : beams) channel.values.push_back(value_of(beam));
    scan.channels.push_back(std::move(channel));
  };
  // Recorded: an MRS1104 whose filter is not "all" sends one channel.
  for (unsigned echo = 0; echo < (echo_filter_ == 1 ? 5U : 1U); ++echo) {
    if ((options_.channels >> echo & 1U) == 0) continue;
    add("DIST" + std::to_string(echo + 1), true, [&](const ColaBeam& beam) -> std::uint16_t {
      if (echo_filter_ == 2 && beam.mm[1] != 0) return beam.mm[1];
      return echo < 2 ? beam.mm.at(echo) : 0;
    });
  }
  const bool wide = outputs_[3] != 0;
  if ((options_.rssi & 1U) != 0)
    add("RSSI1", wide,
        [&](const ColaBeam& beam) { return static_cast<std::uint16_t>(beam.rssi * (wide ? 257 : 1)); });
  send(text_of(scan.bytes(options_.dialect)), leaves, time_of(first_));
}

}  // namespace lidard::sim
