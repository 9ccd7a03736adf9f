// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/clock_bench.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "core/base/host_clock.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/sim/world/rng.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;

constexpr Stamp epoch{1'767'226'643'500'000'000};  // of the device's clock when the driver comes
constexpr Span cable = 20us;                       // the least a packet takes
constexpr Span settling = 2s;
constexpr Span silence = 1500ms;  // of a device that is switched off and on

class ClockBench final : public FrameReceiver {
 public:
  ClockBench(const BenchFamily& family, const BenchScenario& scenario, std::uint64_t seed)
      : family_(family), scenario_(scenario), rng_(seed) {
    // Any phase of the device against the start.
    start_ = epoch + span_from_seconds(family.period * rng_.uniform());
    device_ = family.make(start_, scenario.wrap);
    DriverConfig config;
    config.model = find_model(family.model);
    config.frame_id = "laser";
    driver_ = config.model->make(config);
    is_tcp_ = config.model->transport == Transport::tcp;
    clock_.emplace(reading());
  }

  BenchFigures run(Span length) {
    connect();
    while (host(now_) - start_ < length) {
      if (scenario_.reboot && !rebooted_ && host(now_) - start_ >= *scenario_.reboot) reboot();
      if (!online_ && now_ >= back_at_) connect();
      step();
    }
    figures_.steps = driver_->counters().clock_steps;
    figures_.lost = driver_->counters().lost_packets;
    figures_.info = driver_->info();
    return figures();
  }

  void scan(PlanarScan& scan) override { take(scan.stamp, 0); }
  void cloud(Cloud& cloud) override {
    const bool columns = !cloud.columns.empty();
    take(columns ? cloud.columns.front().stamp : cloud.stamp,
         columns ? static_cast<double>(cloud.columns.front().azimuth) : 0);
  }
  void request(ByteView bytes) override {
    uplink_.push_back({now_ + 50us, std::string(bytes.text()), 0, std::nullopt});
  }
  void disconnect(bool again) override {
    if (!is_tcp_ || !online_) return;
    hang_up(again ? 100ms : Span::max() / 4);
  }

 private:
  /// Host time, without steps, of a moment by the device's clock.
  Stamp host(Stamp device) const {
    const double passed = static_cast<double>((device - start_).count());
    const Stamp even =
        device - Span(std::llround(passed * scenario_.ppm * 1e-6 / (1 + scenario_.ppm * 1e-6)));
    return even + slewed(even);
  }
  Span slewed(Stamp even) const {
    const Span since = std::clamp<Span>(even - start_ - 8s, 0s, 10s);
    return Span(std::llround(static_cast<double>(since.count()) * scenario_.slew_ppm * 1e-6));
  }
  bool is_set(Stamp device) const { return scenario_.step_at && host(device) - start_ >= *scenario_.step_at; }
  /// What the host's clock says then.
  HostStamp realtime(Stamp device) const {
    return HostStamp{host(device).ns} + (is_set(device) ? span_from_seconds(scenario_.step_s) : Span(0));
  }
  /// The same as the stamp of a capture.
  Stamp recorded(Stamp device) const { return {realtime(device).ns}; }
  ClockReading reading() const { return {realtime(now_), host(now_) - epoch + 1000s, Span(500)}; }

  void connect() override {
    online_ = true;
    if (!is_tcp_) return;
    device_->connected(now_);
    driver_->connected(host(now_), *this);
  }
  void reboot() {
    rebooted_ = true;
    settled_ = host(now_) + silence + settling;
    hang_up(silence);
    device_->reboot(back_at_);
    last_.reset();
  }
  /// What is on its way is lost.
  void hang_up(Span length) {
    online_ = false;
    back_at_ = now_ + length;
    if (is_tcp_) driver_->disconnected();
    uplink_.clear();
    on_the_way_.clear();
  }

  void step() {
    Stamp horizon = next_tick_;
    if (!uplink_.empty()) horizon = std::min(horizon, uplink_.front().leaves);
    while (auto sent = device_->next(horizon)) delay(std::move(*sent));
    if (!on_the_way_.empty() && on_the_way_.front().leaves <= horizon) {
      now_ = std::max(now_, on_the_way_.front().leaves);
      const DeviceSends sent = std::move(on_the_way_.front());
      on_the_way_.pop_front();
      return feed(sent);
    }
    now_ = std::max(now_, horizon);
    if (!uplink_.empty() && uplink_.front().leaves <= now_) {
      const DeviceSends up = std::move(uplink_.front());
      uplink_.pop_front();
      device_->receive(up.bytes, now_);
    }
    if (now_ < next_tick_) return;
    next_tick_ = now_ + 20ms;
    if (online_) driver_->tick(scenario_.recorded ? recorded(now_) : host(now_), *this);
  }

  /// Nothing overtakes.
  void delay(DeviceSends sent) {
    Span late = cable + Span(std::llround(rng_.uniform() * static_cast<double>(scenario_.jitter.count())));
    if (rng_.uniform() < scenario_.outliers) late += span_from_seconds(0.08 * rng_.uniform());
    sent.leaves = sent.leaves + late;
    const Stamp kept_from = start_ + 6s;
    if (sent.leaves >= kept_from && sent.leaves < kept_from + scenario_.stall) {
      sent.leaves = kept_from + scenario_.stall + (sent.leaves - kept_from) / 1000;
      settled_ = sent.leaves + settling;
    }
    if (!on_the_way_.empty() && sent.leaves < on_the_way_.back().leaves)
      sent.leaves = on_the_way_.back().leaves;
    on_the_way_.push_back(std::move(sent));
  }

  void feed(const DeviceSends& sent) {
    if (!online_) return;
    if (clock_->observe(reading()) && !scenario_.recorded) settled_ = host(now_) + settling;
    Packet packet;
    packet.payload = ByteView(sent.bytes);
    packet.arrival = scenario_.recorded ? recorded(now_) : clock_->steady(realtime(now_), reading());
    packet.transport = is_tcp_ ? Transport::tcp : Transport::udp;
    const std::uint16_t port = sent.port != 0 ? sent.port : find_model(family_.model)->port;
    packet.from = packet.to = {IpAddress(), port};
    driver_->receive(packet, *this);
  }

  void take(Stamp stamp, double azimuth) {
    const bool moved = scenario_.recorded && is_set(now_);
    const Stamp by_device = unhost(moved ? stamp - span_from_seconds(scenario_.step_s) : stamp);
    const auto truth = device_->truth(by_device, azimuth);
    ++figures_.frames;
    if (!moved) figures_.ahead = std::max(figures_.ahead, seconds(stamp - host(now_)));
    note_order(moved ? HostStamp{stamp.ns} : ClockStep(clock_->step()).host(stamp), stamp);
    if (!truth) {
      ++figures_.without_truth;
      return;
    }
    note_gap(*truth);
    const Span error = stamp - (moved ? host(*truth) + span_from_seconds(scenario_.step_s) : host(*truth));
    const Span since = host(*truth) - start_;
    if (since < 500ms)
      figures_.first = std::max(figures_.first, std::abs(seconds(error)));
    else if (since < settling)
      figures_.start = std::max(figures_.start, std::abs(seconds(error)));
    // A capture's step is noticed within half a second, and then all begins anew.
    const bool waits =
        scenario_.recorded && moved && host(now_) - start_ < *scenario_.step_at + 500ms + settling;
    if (since >= settling && host(*truth) >= settled_ && !waits) errors_.push_back(seconds(error));
  }
  Stamp unhost(Stamp host_time) const {
    return host_time - slewed(host_time) +
           Span(std::llround(static_cast<double>((host_time - start_).count()) * scenario_.ppm * 1e-6));
  }

  /// The stamps as they go out: in order, and with jumps only where the clock was set.
  void note_order(HostStamp out, Stamp inside) {
    if (last_out_ && out <= *last_out_) ++figures_.backwards;
    if (last_out_ && std::chrono::abs((out - *last_out_) - (inside - *last_inside_)) > 100ms)
      ++figures_.jumps;
    if (last_out_ && scenario_.recorded && std::chrono::abs(out - *last_out_) > 600ms) ++figures_.jumps;
    last_out_ = out;
    last_inside_ = inside;
  }
  void note_gap(Stamp truth) {
    const bool was_off = last_ && rebooted_ && *last_ < back_at_ && truth >= back_at_;
    if (last_ && !was_off) {
      const auto frames = std::llround(seconds(truth - *last_) / family_.period);
      if (frames > 1) figures_.missing += static_cast<std::size_t>(frames - 1);
    }
    last_ = truth;
  }

  BenchFigures figures() {
    if (errors_.empty()) return figures_;
    double squares = 0, sum = 0;
    for (double& error : errors_) {
      squares += error * error;
      sum += error;
      error = std::abs(error);
    }
    const auto n = static_cast<double>(errors_.size());
    std::sort(errors_.begin(), errors_.end());
    figures_.rms = std::sqrt(squares / n);
    figures_.mean = sum / n;
    figures_.p99 = errors_[errors_.size() * 99 / 100];
    figures_.worst = errors_.back();
    return figures_;
  }

  const BenchFamily& family_;
  const BenchScenario& scenario_;
  sim::Rng rng_;
  Stamp start_;
  std::unique_ptr<BenchDevice> device_;
  std::unique_ptr<Driver> driver_;
  std::optional<HostClock> clock_;
  bool is_tcp_ = false, online_ = false, rebooted_ = false;
  Stamp now_ = epoch, next_tick_ = epoch, back_at_ = epoch, settled_;
  std::deque<DeviceSends> uplink_, on_the_way_;
  std::optional<Stamp> last_, last_inside_;
  std::optional<HostStamp> last_out_;
  BenchFigures figures_;
  std::vector<double> errors_;
};

}  // namespace

BenchFigures run_clock_bench(const BenchFamily& family, const BenchScenario& scenario, Span length,
                             std::uint64_t seed) {
  return ClockBench(family, scenario, seed).run(length);
}

}  // namespace lidard::test
