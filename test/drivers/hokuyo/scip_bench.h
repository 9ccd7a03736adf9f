// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <string>
#include <vector>

#include "drivers/model.h"
#include "test/sim/devices/scip_device.h"
#include "test/support/collector.h"

namespace lidard::test {

constexpr Stamp scip_epoch{1'767'225'600'000'000'000};

/// Steps of a plain wall: 1 m and 1 mm more a step, intensity twice the step.
inline std::vector<sim::ScipStep> scip_wall(int steps) {
  std::vector<sim::ScipStep> wall;
  for (int i = 0; i < steps; ++i)
    wall.push_back({{static_cast<std::uint32_t>(1000 + i), static_cast<std::uint32_t>(2 * i)}});
  return wall;
}

/// A TCP device and its driver with a cable between them, on a clock of their own.
class TcpBench : public DriverBench {
 public:
  using DriverBench::DriverBench;

  void scan(PlanarScan& scan) override {
    DriverBench::scan(scan);
    arrivals.push_back(now);
    sweeps.push_back(sweep);
  }
  void request(ByteView bytes) override {
    written += bytes.text();
    uplink.push_back({leaves_at + way_up + up_to(way_up_jitter), std::string(bytes.text())});
  }
  Stamp leaves(Stamp) override { return leaves_at; }
  void disconnect(bool again) override {
    EXPECT_TRUE(again);
    ++reconnects;
    cut = true;
  }

  void connect_now() {
    leaves_at = now;
    device->connected(now);
    driver->connected(now, *this);
    online = true;
  }
  void disconnect_now() {
    driver->disconnected();
    device->disconnected();
    uplink.clear();
    online = cut = false;
  }
  Reject feed(std::string_view bytes, bool start = false, std::uint64_t missing = 0) {
    return DriverBench::feed(ByteView(bytes), start, missing).reject;
  }
  /// Lets both talk; a connection that the driver ends is made again after 0.2 s.
  void run(Span time) {
    const Stamp end = now + time;
    while (now < end) {
      if (cut) disconnect_now(), reconnect = now + std::chrono::milliseconds(200);
      if (!online && auto_connect && now >= reconnect) connect_now();
      step(end);
    }
  }

  sim::TcpDevice* device = nullptr;
  std::vector<Stamp> arrivals, sweeps;  // beside scans
  std::string written;
  Span way_up{50'000}, way_up_jitter{0};
  Span host_late{0};  // up to so long the host reads after an arrival
  sim::Rng rng{1};
  bool online = false, auto_connect = true, muted = false;
  bool recording = false;
  std::vector<std::pair<Stamp, std::string>> recorded;  // arrival and bytes, as a capture has them

 private:
  struct Upward {
    Stamp time;
    std::string bytes;
  };

  Span up_to(Span most) {
    return Span(static_cast<std::int64_t>(rng.uniform() * static_cast<double>(most.count())));
  }
  void step(Stamp end) {
    Stamp horizon = std::min(end, next_tick);
    if (!uplink.empty()) horizon = std::min(horizon, uplink.front().time);
    if (const auto sent = device->next(horizon)) {
      now = std::max(now, sent->time);
      sweep = sent->sweep.value_or(Stamp());
      if (recording) recorded.emplace_back(now, sent->bytes);
      leaves_at = now + host_late / 4 + up_to(host_late);
      if (online && !muted) feed(sent->bytes);
      return;
    }
    now = std::max(now, horizon);
    if (!uplink.empty() && uplink.front().time <= now) {
      const Upward up = uplink.front();
      uplink.pop_front();
      device->receive(up.bytes, now);
    }
    if (now >= next_tick) {
      leaves_at = now;
      if (online) driver->tick(now, *this);
      next_tick = now + std::chrono::milliseconds(20);
    }
  }

  std::deque<Upward> uplink;
  Stamp leaves_at = scip_epoch;
  Stamp next_tick = scip_epoch, reconnect = scip_epoch, sweep;
  bool cut = false;
};

/// A UST sends on the tick of its counter (seqsense/urg_stamped, README), unless it has one of us.
inline sim::ScipDeviceOptions as_product(sim::ScipDeviceOptions options, const std::string& model) {
  options.sends_on_tick = model.find("_ust_") != std::string::npos && !options.knows_percent;
  return options;
}

/// With a SCIP sensor on the other end that looks at scip_wall().
class ScipBench : public TcpBench {
 public:
  explicit ScipBench(sim::ScipDeviceOptions options = {}, DriverConfig config = {},
                     const std::string& model = "hokuyo_ust_10lx")
      : TcpBench(model, std::move(config)),
        wall(scip_wall(options.last_step + 1)),
        sensor(
            as_product(std::move(options), model), [this](Stamp) { return wall; },
            now - std::chrono::seconds(100)) {
    device = &sensor;
  }

  std::vector<sim::ScipStep> wall;
  sim::ScipDevice sensor;
};

}  // namespace lidard::test
