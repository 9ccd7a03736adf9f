// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "daemon/pipeline/sink.h"

namespace lidard {

/// The one gate for poses that are missing. What is to show one instant waits for them for a bounded time;
/// then it is published as if the vehicle stood still, or left out. Counts for one output, or for the clouds
/// of one sensor.
class PoseGate {
 public:
  /// True if what lacks poses since `since` may wait for them at `now`. A clock that was set back ends the
  /// wait.
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
  /// What is missing in the newest one, with the remedy; empty: nothing.
  const std::string& trouble() const { return trouble_; }
  /// Adds the counters; WARN with the trouble if there is none so far.
  void describe(DiagnosticItem& item) const {
    item.add("Not deskewed", not_deskewed_);
    item.add("Left out for want of poses", left_out_);
    if (item.health == Health::ok && !trouble_.empty()) item.set(Health::warn, trouble_);
  }
  /// The line below the table of a replay: "2 clouds not deskewed"; empty: all is well.
  std::string losses() const;

 private:
  std::uint64_t not_deskewed_ = 0, left_out_ = 0;
  std::string trouble_;
};

}  // namespace lidard
