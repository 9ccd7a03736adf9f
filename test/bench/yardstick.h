// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <vector>

namespace lidard::bench {

/// Time this thread used the processor, s: what other programs of a busy machine do counts as little as can
/// be.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

/// Copies as many bytes as a decoder wrote, frame by frame, between buffers far larger than the cache.
class Yardstick {
 public:
  /// `frames`: bytes of each.
  explicit Yardstick(std::vector<std::size_t> frames)
      : frames_(std::move(frames)), from_(buffer_size, 1), to_(buffer_size) {}

  void copy() {
    for (std::size_t frame : frames_) {
      frame = std::min(frame, buffer_size);
      if (at_ + frame > buffer_size) at_ = 0;
      std::memcpy(to_.data() + at_, from_.data() + at_, frame);
      benchmark::ClobberMemory();
      at_ += frame;
    }
  }

 private:
  static constexpr std::size_t buffer_size = 96U << 20U;
  std::vector<std::size_t> frames_;
  std::vector<std::uint8_t> from_, to_;
  std::size_t at_ = 0;
};

/// The round in the middle.
inline double median(std::vector<double> rounds) {
  const auto middle = rounds.begin() + static_cast<std::ptrdiff_t>(rounds.size() / 2);
  std::nth_element(rounds.begin(), middle, rounds.end());
  return *middle;
}

/// Times `work`, which writes `points` points into frames of these bytes, and beside each round the copying
/// of the same bytes. Counters: nanoseconds per point of both (medians of the rounds), their ratio, and the
/// ratio of the quickest rounds, which what else the machine does disturbs least.
template <typename Work>
void against_memcpy(benchmark::State& state, std::size_t points, const std::vector<std::size_t>& frames,
                    Work&& work) {
  Yardstick yardstick(frames);
  yardstick.copy();
  std::vector<double> works, copies;
  for (auto _ : state) {
    const double begin = cpu_seconds();
    work();
    const double worked = cpu_seconds();
    yardstick.copy();
    copies.push_back(cpu_seconds() - worked);
    works.push_back(worked - begin);
    state.SetIterationTime(worked - begin);
  }
  const auto n = static_cast<double>(points);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points));
  state.counters["ns_point"] = median(works) * 1e9 / n;
  state.counters["ns_memcpy"] = median(copies) * 1e9 / n;
  state.counters["x_memcpy"] = median(works) / median(copies);
  state.counters["x_best"] =
      *std::min_element(works.begin(), works.end()) / *std::min_element(copies.begin(), copies.end());
}

}  // namespace lidard::bench
