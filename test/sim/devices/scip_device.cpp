// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/scip_device.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace lidard::sim {
namespace {

// From the request to the answer; a guess that real sensors are slower than.
constexpr Span thinking_time{150'000};

bool all_digits(const std::string& text, std::size_t from, std::size_t count) {
  if (text.size() < from + count) return false;
  return std::all_of(text.begin() + static_cast<std::ptrdiff_t>(from),
                     text.begin() + static_cast<std::ptrdiff_t>(from + count),
                     [](char c) { return c >= '0' && c <= '9'; });
}

int digits(const std::string& text, std::size_t from, std::size_t count) {
  return std::stoi(text.substr(from, count));
}

}  // namespace

std::optional<ScipOrder> parse_order(const std::string& request) {
  ScipOrder order;
  order.echo = request;
  order.percent = request.rfind('%', 0) == 0;
  const std::string text = request.substr(order.percent ? 1 : 0);
  if (text.size() < 12) return std::nullopt;
  const std::string command = text.substr(0, 2);
  const std::string known[] = {"MD", "MS", "ME", "ND", "NE", "GD", "GS", "GE", "HD", "HE"};
  if (std::find(std::begin(known), std::end(known), command) == std::end(known)) return std::nullopt;
  order.continuous = command[0] == 'M' || command[0] == 'N';
  order.multi_echo = command[0] == 'N' || command[0] == 'H';
  order.intensities = command[1] == 'E';
  order.short_values = command[1] == 'S';
  if (!all_digits(text, 2, order.continuous ? 13 : 10)) return std::nullopt;
  order.first = digits(text, 2, 4);
  order.last = digits(text, 6, 4);
  order.cluster = std::max(1, digits(text, 10, 2));
  if (order.continuous) {
    order.skip = digits(text, 12, 1);
    order.scans = digits(text, 13, 2);
  }
  return order;
}

ScipTexts scip_texts(const std::string& product) {
  if (product.rfind("UST", 0) == 0)
    return {"2.23.0000 (2016-10-20)", "Measuring by Sensitive Mode", "Measuring by Sensitive Mode",
            "sensor is working normally"};
  return {"1.1.0 (2011-09-30)", "000 Idle", "004 Multi_scan", "Stable 000 no error."};
}

ScipDevice::ScipDevice(ScipDeviceOptions options, ScipScene scene, Stamp power_on)
    : TcpDevice(options.transit),
      options_(std::move(options)),
      scene_(std::move(scene)),
      power_on_(power_on) {
  if (options_.firmware.empty()) options_.firmware = scip_texts(options_.product).firmware;
}

Span ScipDevice::period() const {
  return span_from_seconds(60.0 / options_.rpm * (1 + options_.motor_ppm * 1e-6));
}
Span ScipDevice::step() const { return period() / options_.steps_per_turn; }
Stamp ScipDevice::turn(std::int64_t number) const { return power_on_ + period() * number; }

void ScipDevice::connected(Stamp now) {
  static_cast<void>(now);
  line_.clear();
}

void ScipDevice::disconnected() {
  TcpDevice::disconnected();
  line_.clear();
  order_.reset();
  time_mode_ = false;
}

void ScipDevice::power_cycle(Stamp now) {
  disconnected();
  power_on_ = now;
  received_.clear();
}

void ScipDevice::tell_status(std::string_view status, Stamp now) {
  if (order_) send(scip_answer(order_->echo, status), now);
}

void ScipDevice::receive(std::string_view bytes, Stamp now) {
  received_ += bytes;
  for (const char c : bytes) {
    if (c != '\n') {
      line_ += c;
      continue;
    }
    const std::string request = line_;
    line_.clear();
    answer(request, now);
  }
}

void ScipDevice::answer(const std::string& request, Stamp now) {
  produce(now);
  const Stamp soon = now + thinking_time;
  const bool percent = request.rfind('%', 0) == 0;
  const std::string command = request.substr(0, request.find(';'));
  const std::string key = command.substr(0, (percent ? 1U : 0U) + (command.find("TM") < 2 ? 3U : 2U));
  const auto refusal = options_.refusals.find(key);
  if (refusal != options_.refusals.end() && !refusal->second.empty())
    return send(scip_answer(request, refusal->second), soon);
  if (percent && !options_.knows_percent) return send(scip_answer(request, "0E"), soon);
  if (const auto order = parse_order(request)) return answer_order(*order, now);
  if (key == "TM0" || key == "TM1" || key == "TM2" || key == "%TM1")
    return answer_time(request, percent, now);
  if (key == "QT" || key == "BM") {
    if (key == "QT") order_.reset(), time_mode_ = false;
    return send(scip_answer(request, "00"), soon);
  }
  if (key == "VV") return send(scip_answer(request, "00", version()), soon);
  if (key == "PP") return send(scip_answer(request, "00", parameters()), soon);
  if (key == "II") return send(scip_answer(request, "00", information(now)), soon);
  send(scip_answer(request, "0E"), soon);
}

void ScipDevice::answer_time(const std::string& request, bool percent, Stamp now) {
  const Stamp soon = now + thinking_time;
  if (request.find("TM0") != std::string::npos) {
    const bool busy = order_ || now - power_on_ < options_.boot;
    const char* status = busy ? "10" : time_mode_ ? "02" : "00";
    time_mode_ = time_mode_ || !busy;
    return send(scip_answer(request, status), soon);
  }
  if (request.find("TM2") != std::string::npos) {
    send(scip_answer(request, time_mode_ ? "00" : "03"), soon);
    time_mode_ = false;
    return;
  }
  if (!time_mode_) return send(scip_answer(request, "10"), soon);
  if (options_.time_tick_ms == 0)
    return send(scip_answer(request, "00", scip_line(counter(soon, percent))), soon);
  const Stamp read = next_tick(soon, 1);
  send(scip_answer(request, "00", scip_line(counter(read + Span(1000), percent))),
       next_tick(read, options_.time_tick_ms));
}

/// When the counter shows the next multiple of so many ms.
Stamp ScipDevice::next_tick(Stamp when, int tick_ms) const {
  const double us = 1e3 * tick_ms;
  return when + Span(std::llround(1e3 * (us - std::fmod(device_us(when), us))));
}

void ScipDevice::answer_order(ScipOrder order, Stamp now) {
  const Stamp soon = now + thinking_time;
  const bool ready = !time_mode_ && now - power_on_ >= options_.boot;
  if ((order.multi_echo && !options_.knows_echoes) || (order.intensities && !options_.knows_intensities))
    return send(scip_answer(order.echo, "0E"), soon);
  if (order.last > options_.last_step) return send(scip_answer(order.echo, "04"), soon);
  if (order.first > order.last) return send(scip_answer(order.echo, "05"), soon);
  if (!ready) return send(scip_answer(order.echo, "10"), soon);
  const auto turns = (now - power_on_).count() / period().count() + 1;
  if (!order.continuous) {
    const Stamp begin = turn(turns);
    order_ = order;
    send_scan(begin, begin + step() * order.last + options_.processing);
    order_.reset();
    return;
  }
  send(scip_answer(order.echo, "00"), soon);
  order_ = std::move(order);
  next_turn_ = turns;
}

double ScipDevice::device_us(Stamp when) const {
  const double passed = static_cast<double>((when - power_on_).count()) * (1 + options_.clock_ppm * 1e-6);
  return static_cast<double>(options_.counter) + passed / 1000;
}

/// What the counter shows, coded.
std::string ScipDevice::counter(Stamp when, bool percent) const {
  const auto us = static_cast<std::uint64_t>(device_us(when));
  return percent ? scip_code(us, options_.long_stamp) : scip_code(us / 1000 % (1U << 24U), 4);
}

void ScipDevice::send_scan(Stamp begin, Stamp leaves) {
  std::vector<ScipStep> steps = scene_(begin);
  ScipOrder what = *order_;
  what.last -= options_.values_missing * what.cluster;
  std::string echo = order_->echo;
  if (order_->scans > 0) {  // the echo counts down
    const int left = --order_->scans;
    char number[8];
    std::snprintf(number, sizeof number, "%02d", left % 100);
    echo.replace(order_->percent ? 14 : 13, 2, number);
  }
  if (order_->percent && options_.bare_echo) echo.erase(0, 1);
  if (options_.sends_on_tick) leaves = next_tick(leaves, 1);
  const std::string body = scip_line(counter(begin, order_->percent)) + scip_data(what, steps);
  send(scip_answer(echo, order_->continuous ? "99" : "00", body), leaves, begin);
}

void ScipDevice::produce(Stamp until) {
  while (order_ && order_->continuous) {
    const Stamp begin = turn(next_turn_);
    const Stamp leaves = begin + step() * order_->last + options_.processing;
    if (leaves > until) return;
    const bool last = order_->scans == 1;
    send_scan(begin, leaves);
    next_turn_ += 1 + order_->skip;
    if (last) order_.reset();
  }
}

std::string ScipDevice::version() const {
  return scip_entries({{"VEND", "Hokuyo Automatic Co., Ltd."},
                       {"PROD", options_.product},
                       {"FIRM", options_.firmware},
                       {"PROT", "SCIP 2.2"},
                       {"SERI", options_.serial}});
}

std::string ScipDevice::parameters() const {
  return scip_entries({{"MODL", options_.product},
                       {"DMIN", std::to_string(options_.range_min_mm)},
                       {"DMAX", std::to_string(options_.range_max_mm)},
                       {"ARES", std::to_string(options_.steps_per_turn)},
                       {"AMIN", std::to_string(options_.first_step)},
                       {"AMAX", std::to_string(options_.last_step)},
                       {"AFRT", std::to_string(options_.front_step)},
                       {"SCAN", std::to_string(options_.rpm)}});
}

std::string ScipDevice::information(Stamp now) const {
  const ScipTexts texts = scip_texts(options_.product);
  return scip_entries({{"MODL", options_.product},
                       {"LASR", order_ ? "ON" : "OFF"},
                       {"SCSP", std::to_string(options_.rpm)},
                       {"MESM", order_ ? texts.streaming : texts.idle},
                       {"SBPS", "Ethernet 100 [Mbps]"},
                       {"TIME", counter(now, false)},
                       {"STAT", texts.status}});
}

}  // namespace lidard::sim
