// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/driver.h"

namespace lidard::test {

/// What a simulated device sends, and when by its own clock.
struct DeviceSends {
  Stamp leaves;
  std::string bytes;
  std::uint16_t port = 0;      ///< 0: the port of its data
  std::optional<Stamp> begin;  ///< of the first beam, where the bytes end a scan
};

/// A simulated device that lives on its own clock: the bench makes host time of it, so that every device
/// drifts without knowing.
class BenchDevice {
 public:
  virtual ~BenchDevice() = default;
  /// What leaves next, no later than `until`.
  virtual std::optional<DeviceSends> next(Stamp until) = 0;
  virtual void connected(Stamp /*now*/) {}
  virtual void receive(std::string_view /*bytes*/, Stamp /*now*/) {}
  /// Switched off and on: counters begin anew; it measures again from `now` on.
  virtual void reboot(Stamp now) = 0;
  /// The true time, by the device's clock, of what the driver says began at about `near` with that azimuth.
  virtual std::optional<Stamp> truth(Stamp near, double azimuth) const = 0;
};

/// A family of devices, or a kind of counter.
struct BenchFamily {
  const char* name;
  const char* model;
  bool ms_counter;  ///< its counter shows whole ms, else us (or turns)
  bool overflows;   ///< its counter does within a scenario, else it is too long to
  double period;    ///< s of a frame
  /// Switched on at `start`; `wrap`: its counter overflows that long after `start`, where it has one that
  /// does.
  std::function<std::unique_ptr<BenchDevice>(Stamp start, std::optional<Span> wrap)> make;
};
const std::vector<BenchFamily>& bench_families();

/// What happens to a device on its way to the driver.
struct BenchScenario {
  const char* name;
  double ppm = 0;                 ///< the device's clock is that much fast
  Span jitter{0};                 ///< each packet is late by up to that, evenly distributed
  double outliers = 0;            ///< share of the packets that are late by up to 80 ms more
  std::optional<Span> wrap{};     ///< after the start
  std::optional<Span> reboot{};   ///< silent for 1.5 s then
  Span stall{0};                  ///< from 6 s after the start on, the network keeps the packets for so long
  std::optional<Span> step_at{};  ///< the host's clock is set then
  double step_s = 0;
  double slew_ppm = 0;    ///< the host's clock is that much fast for 10 s, from 8 s after the start on
  bool recorded = false;  ///< the step is in the arrival stamps (a capture)
};

struct BenchFigures {
  double rms = 0, p99 = 0, worst = 0, mean = 0;  ///< s, from 2 s after the start or an event on
  double start = 0;                              ///< s, largest error from 0.5 to 2 s after the start
  double first = 0;                              ///< s, largest error of the first 0.5 s
  std::size_t frames = 0;
  std::size_t missing = 0;    ///< gaps between frames where the device was not silent
  std::size_t backwards = 0;  ///< stamps that are not newer than the one before
  double ahead = 0;           ///< s, the furthest that a stamp was ahead of the newest packet's arrival
  std::size_t jumps = 0;      ///< discontinuities of the stamps as they go out, in host time
  std::uint64_t steps = 0;    ///< that the driver counted
  std::uint64_t lost = 0;     ///< packets, likewise
  std::size_t without_truth = 0;
  DeviceInfo info;  ///< as diagnostics have it at the end
};

/// Runs a device for `length` of host time on a virtual clock; the same seed gives the same figures.
BenchFigures run_clock_bench(const BenchFamily& family, const BenchScenario& scenario, Span length,
                             std::uint64_t seed);

}  // namespace lidard::test
