// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "drivers/velodyne/model_row.h"

namespace lidard::velodyne {

/// Chooses a model's timing variant by the median packet period, which no configuration knows and which the
/// random rest of a VLS-128 blurs: a single pair of packets would often mislead.
class TimingChooser {
 public:
  explicit TimingChooser(const ModelRow& row) : row_(row), chosen_(&row.timings.front()) {}

  /// Two consecutive packets without loss or hidden sector between them: the time from one to the other.
  void add(Span step, std::size_t sequences);
  const Timing& timing() const { return *chosen_; }
  /// False until there is something to choose by.
  bool decided() const { return row_.timings.size() == 1 || count_ > 0; }
  /// Mean time from sequence to sequence as measured; the chosen variant's before.
  Span measured_sequence() const;

 private:
  const ModelRow& row_;
  const Timing* chosen_;
  std::array<std::int64_t, 64> steps_{};   // ns per sequence, in order of arrival
  std::array<std::int64_t, 64> sorted_{};  // the same in order of size
  std::size_t count_ = 0;
  std::int64_t sum_ = 0;
};

}  // namespace lidard::velodyne
