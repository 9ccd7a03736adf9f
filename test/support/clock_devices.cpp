// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <deque>

#include "core/base/angle.h"
#include "test/sim/devices/cola_device.h"
#include "test/sim/devices/microscan3.h"
#include "test/sim/devices/scip_device.h"
#include "test/sim/devices/sick_segments.h"
#include "test/sim/devices/uam_device.h"
#include "test/sim/devices/velodyne.h"
#include "test/sim/world/scene.h"
#include "test/support/clock_bench.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;

/// A device that sends datagrams. Everything it sees is 5 m away.
class UdpBenchDevice final : public BenchDevice {
 public:
  /// `turns`: each firing sequence has a truth of its own; else each frame.
  UdpBenchDevice(sim::ModelMaker make, Stamp start, std::optional<Span> wrap, bool turns)
      : make_(std::move(make)), turns_(turns) {
    constexpr std::int64_t hour = 3'600'000'000'000;
    entry_.range_max = 60;
    if (wrap) entry_.clock_offset = Span(hour - (start + *wrap).ns % hour);
    device_ = make_(entry_, start);
  }

  std::optional<DeviceSends> next(Stamp until) override {
    while (queue_.empty() || queue_.back().leaves <= until) measure();
    if (queue_.front().leaves > until) return std::nullopt;
    DeviceSends first = std::move(queue_.front());
    queue_.pop_front();
    return first;
  }

  void reboot(Stamp now) override {
    entry_.clock_offset -= Span(1'234'567'891'000);
    device_ = make_(entry_, now);
    queue_.clear();
  }

  std::optional<Stamp> truth(Stamp near, double azimuth) const override {
    std::optional<Stamp> best;
    for (const Truth& each : truths_) {
      const bool same = !turns_ || std::abs(std::remainder(each.azimuth - azimuth, two_pi)) < 1e-4;
      if (same && (!best || std::chrono::abs(each.time - near) < std::chrono::abs(*best - near)))
        best = each.time;
    }
    return best;
  }

 private:
  struct Truth {
    Stamp time;
    double azimuth;
  };

  void measure() {
    const std::vector<sim::Beam>& beams = device_->next();
    sim::Answer answer;
    answer.echoes[0] = {5, 5, 0.5};
    answer.count = 1;
    answers_.assign(beams.size(), answer);
    datagrams_.clear();
    slots_.clear();
    device_->encode(answers_, {}, datagrams_, slots_);
    for (const auto& sent : datagrams_)
      queue_.push_back({sent.ready, {sent.payload.begin(), sent.payload.end()}, sent.port, {}});
    remember(beams);
  }
  /// Of a rotating lidar the firing sequences, else the first beam.
  void remember(const std::vector<sim::Beam>& beams) {
    if (!turns_) truths_.push_back({beams.front().time, 0});
    for (std::size_t i = 0; turns_ && i < beams.size(); ++i) {
      if (beams[i].laser == 0) truths_.push_back({beams[i].time, beams[i].azimuth});
    }
    while (truths_.size() > (turns_ ? 8000U : 40U)) truths_.pop_front();
  }

  sim::ModelMaker make_;
  bool turns_;
  sim::SensorEntry entry_;
  std::unique_ptr<sim::SensorModel> device_;
  std::deque<DeviceSends> queue_;
  std::deque<Truth> truths_;
  std::vector<sim::Answer> answers_;
  std::vector<sim::Datagram> datagrams_;
  std::vector<sim::SlotTruth> slots_;
};

/// A device that serves a TCP client and says of each scan when it began.
template <class Device>
class TcpBenchDevice final : public BenchDevice {
 public:
  explicit TcpBenchDevice(std::unique_ptr<Device> device) : device_(std::move(device)) {}

  std::optional<DeviceSends> next(Stamp until) override {
    auto sent = device_->next(until);
    if (!sent) return std::nullopt;
    if (sent->sweep) begins_.push_back(*sent->sweep);
    while (begins_.size() > 40) begins_.pop_front();
    return DeviceSends{sent->time, std::move(sent->bytes), 0, sent->sweep};
  }
  void connected(Stamp now) override { device_->connected(now); }
  void receive(std::string_view bytes, Stamp now) override { device_->receive(bytes, now); }
  void reboot(Stamp now) override {
    if constexpr (std::is_same_v<Device, sim::UamDevice>) {
      device_->disconnected();
      device_->options().counter_ms += 77'000'000;
    } else {
      device_->power_cycle(now);
    }
  }
  std::optional<Stamp> truth(Stamp near, double /*azimuth*/) const override {
    std::optional<Stamp> best;
    for (const Stamp begin : begins_) {
      if (!best || std::chrono::abs(begin - near) < std::chrono::abs(*best - near)) best = begin;
    }
    return best;
  }

 private:
  std::unique_ptr<Device> device_;
  std::deque<Stamp> begins_;
};

constexpr Span before = 100s;  // that long the devices were on when the driver comes

std::unique_ptr<BenchDevice> scip(sim::ScipDeviceOptions options, Stamp start, std::optional<Span> wrap) {
  constexpr std::uint64_t length_us = (std::uint64_t{1} << 24U) * 1000;
  if (wrap) options.counter = length_us - static_cast<std::uint64_t>((before + *wrap).count() / 1000);
  options.transit.delay = Span(0);
  const auto steps = static_cast<std::size_t>(options.last_step) + 1;
  return std::make_unique<TcpBenchDevice<sim::ScipDevice>>(std::make_unique<sim::ScipDevice>(
      options,
      [steps](Stamp) {
        return std::vector<sim::ScipStep>(steps, {{5000, 100}});
      },
      start - before));
}

sim::ScipDeviceOptions ust(double motor_ppm) {
  sim::ScipDeviceOptions options;
  options.motor_ppm = motor_ppm;
  options.sends_on_tick = true;
  return options;
}
sim::ScipDeviceOptions ust_with_microseconds() {
  sim::ScipDeviceOptions options = ust(700);
  options.sends_on_tick = false;
  options.knows_percent = true;
  options.firmware = "4.1.0";
  return options;
}
sim::ScipDeviceOptions utm() {
  sim::ScipDeviceOptions options;
  options.product = "UTM-30LX-EW";
  options.motor_ppm = 700;
  return options;
}

std::unique_ptr<BenchDevice> uam(Stamp start, std::optional<Span> wrap) {
  sim::UamDeviceOptions options;
  options.transit.delay = Span(0);
  options.processing = Span(0);  // listening does not show it, and this device is not asked for its clock
  if (wrap) options.counter_ms = static_cast<std::uint32_t>(-((before + *wrap).count() / 1'000'000));
  return std::make_unique<TcpBenchDevice<sim::UamDevice>>(std::make_unique<sim::UamDevice>(
      options,
      [](Stamp, std::size_t beams) {
        return std::vector<sim::UamBeam>(beams, {5000, 100});
      },
      start - before));
}

std::unique_ptr<BenchDevice> cola(sim::ColaDeviceOptions options, Stamp start, std::optional<Span> wrap) {
  if (wrap) options.clock_us = static_cast<std::uint32_t>(-((before + *wrap).count() / 1000));
  options.transit.delay = Span(0);
  return std::make_unique<TcpBenchDevice<sim::ColaDevice>>(std::make_unique<sim::ColaDevice>(
      options,
      [](Stamp, std::size_t beams) {
        return std::vector<sim::ColaBeam>(beams, {{5000, 0}, 100});
      },
      start - before));
}
sim::ColaDeviceOptions tim() {
  sim::ColaDeviceOptions options;
  options.type = "TiM781";
  options.hz = 15;
  options.step = 3333;
  options.exact_step_deg = 1.0 / 3;
  options.beams = 811;
  return options;
}

sim::ModelMaker vlp16() {
  for (const sim::VelodyneTable& table : sim::velodyne_tables()) {
    if (std::string(table.name) == "velodyne_vlp16") return sim::make_velodyne(table, {});
  }
  return {};
}
sim::ModelMaker segments() {
  sim::SickSegmentsOptions options;
  options.imu_hz = 0;
  return sim::make_sick_segments(options);
}

template <class Make>
auto udp(Make make, bool turns = false) {
  return [make, turns](Stamp start, std::optional<Span> wrap) {
    return std::make_unique<UdpBenchDevice>(make(), start, wrap, turns);
  };
}

}  // namespace

// The beat of a UST's motor with its counter decides what whole ms show; 2.5 % of a ms per turn (1000 ppm) is
// a guess. The one in step shows what a sensor without a beat hides.
const std::vector<BenchFamily>& bench_families() {
  static const std::vector<BenchFamily> families = {
      {"VLP-16, us of the hour", "velodyne_vlp16", false, true, 0.1, udp(vlp16, true)},
      {"microScan3, turns", "sick_microscan3", false, false, 0.03,
       udp([] { return sim::make_microscan3({}); })},
      {"picoScan150, us", "sick_picoscan150", false, false, 0.05, udp(segments)},
      {"LMS1xx, us", "sick_lms1xx", false, true, 0.02,
       [](Stamp start, std::optional<Span> wrap) { return cola({}, start, wrap); }},
      {"TiM7xx, us", "sick_tim7xx", false, true, 1.0 / 15,
       [](Stamp start, std::optional<Span> wrap) { return cola(tim(), start, wrap); }},
      {"UST-10LX, us", "hokuyo_ust_10lx", false, false, 0.025,
       [](Stamp start, std::optional<Span> wrap) { return scip(ust_with_microseconds(), start, wrap); }},
      {"UST-10LX, ms, sends on its tick", "hokuyo_ust_10lx", true, true, 0.025,
       [](Stamp start, std::optional<Span> wrap) { return scip(ust(1000), start, wrap); }},
      {"UST-10LX, ms, motor in step", "hokuyo_ust_10lx", true, true, 0.025,
       [](Stamp start, std::optional<Span> wrap) { return scip(ust(0), start, wrap); }},
      {"UTM-30LX-EW, ms, sends at once", "hokuyo_utm_30lx_ew", true, true, 0.025,
       [](Stamp start, std::optional<Span> wrap) { return scip(utm(), start, wrap); }},
      {"UAM-05LP, ms", "hokuyo_uam_05lp", true, true, 0.03, uam}};
  return families;
}

}  // namespace lidard::test
