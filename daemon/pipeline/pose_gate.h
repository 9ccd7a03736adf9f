// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "daemon/pipeline/sink.h"

namespace lidard {

/// Handles missing poses of the vehicle for one output or for the clouds of one sensor: a frame waits for its
/// poses for a limited time and is then published as if the vehicle stood still, or dropped. Counts both.
class PoseGate {
 public:
  /// True if a frame that has waited since `since` may still wait at `now`. A clock that was set back ends
  /// the wait.
  static bool may_wait(Stamp since, Span longest_wait, Stamp now) {
    return now >= since && now - since < longest_wait;
  }
  void published(bool is_deskewed) {
    if (!is_deskewed) ++not_deskewed_;
    trouble_ = is_deskewed ? ""
                           : "published as if the vehicle stood still: its poses at the time of measuring "
                             "are missing; see that odometry is published";
  }
  void left_out(std::string why) {
    ++left_out_;
    trouble_ = std::move(why);
  }
  bool has_left_out() const { return left_out_ > 0; }
  /// What is missing in the newest frame, with the remedy; empty: nothing.
  const std::string& trouble() const { return trouble_; }
  /// Adds the counters, and WARN with trouble() if the item is ok.
  void describe(DiagnosticItem& item) const {
    item.add("Not deskewed", not_deskewed_);
    item.add("Left out for want of poses", left_out_);
    if (item.health == Health::ok && !trouble_.empty()) item.set(Health::warn, trouble_);
  }
  /// The line below the table of a replay: "2 clouds not deskewed"; empty: no losses.
  std::string losses() const;

 private:
  std::uint64_t not_deskewed_ = 0, left_out_ = 0;
  std::string trouble_;
};

}  // namespace lidard
