// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "core/base/time.h"

namespace lidard {

/// Handles missing poses of the vehicle for one output or for the clouds of one sensor: a frame waits for its
/// poses for a limited time and is then published as if the vehicle stood still, or dropped. Counts both.
class PoseGate {
 public:
  enum class Newest : std::uint8_t { published, not_deskewed, left_out };

  /// True if a frame that has waited since `since` may still wait at `now`. A clock that was set back ends
  /// the wait.
  static bool may_wait(Stamp since, Span longest_wait, Stamp now) {
    return now >= since && now - since < longest_wait;
  }
  void published(bool is_deskewed) {
    if (!is_deskewed) ++not_deskewed_;
    newest_ = is_deskewed ? Newest::published : Newest::not_deskewed;
  }
  /// `why`: the pose that is missing; empty: those of the vehicle.
  void left_out(std::string why = {}) {
    ++left_out_;
    newest_ = Newest::left_out;
    why_ = std::move(why);
  }
  /// What became of the newest frame.
  Newest newest() const { return newest_; }
  /// Why the newest one that was left out was; empty: poses of the vehicle were missing.
  const std::string& why() const { return why_; }
  std::uint64_t left_out_count() const { return left_out_; }
  std::uint64_t not_deskewed_count() const { return not_deskewed_; }

 private:
  std::uint64_t not_deskewed_ = 0, left_out_ = 0;
  Newest newest_ = Newest::published;
  std::string why_;
};

}  // namespace lidard
