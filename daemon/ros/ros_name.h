// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <deque>
#include <mutex>
#include <optional>
#include <random>
#include <string>

#include "core/base/time.h"

namespace lidard {

class MasterClient;

/// Two daemons of one node name would shut each other down for ever: the master ends the older registration
/// with each new one. The first daemon keeps the name, the second one gives up. Calls belong to the master
/// thread, except conflict().
class RosName {
 public:
  /// `started`: when this process began; tells who of two is the first where both have registered.
  RosName(std::string node, Stamp started);

  /// Lets other daemons ask us since when we run. To be called before each ros::start().
  void answer_others();
  /// False while another daemon holds the name; when it still does so after 3 s, we give up.
  bool is_free(MasterClient& master);
  /// We have registered: from now on the name is ours, and another one that takes it comes second.
  void taken() { ours_ = true; }
  /// We were shut down from outside. Returns how long to step aside, so that another daemon can settle.
  Span thrown_out();
  /// To be called then: after three times in 10 s we give up if the daemon that has the name now started
  /// before us. Returns how long to wait before we start again.
  Span after_thrown_out(MasterClient& master);
  /// Why we have given up, with the remedy; empty: we have not.
  std::string conflict() const;

 private:
  struct Holder {
    std::string uri;
    Stamp started;
  };
  std::optional<Holder> holder(MasterClient& master) const;
  void give_up(const Holder& other);

  const std::string node_;
  const Stamp started_;
  bool ours_ = false;
  std::optional<std::chrono::steady_clock::time_point> seen_since_;
  std::deque<std::chrono::steady_clock::time_point> thrown_out_;
  std::minstd_rand chance_{std::random_device{}()};
  mutable std::mutex mutex_;
  std::string conflict_;
};

}  // namespace lidard
