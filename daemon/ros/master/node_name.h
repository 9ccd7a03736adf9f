// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/time.h"
#include "daemon/ros/master/master_client.h"

namespace lidard {

/// The right to a node name. The master ends the older registration of a name with each new one, so two
/// daemons of one name would shut each other down for ever: the second one is refused. Of daemons with one
/// runtime folder a locked file decides, which is free when its process ends; of others the master is asked
/// whether a node of the name answers. Calls belong to the master thread, except conflict() and
/// lacks_files().
class NodeName {
 public:
  /// `master_uri`: nodes of one name at different masters do not meet.
  NodeName(std::string node, std::string master_uri);
  ~NodeName();
  NodeName(const NodeName&) = delete;
  NodeName& operator=(const NodeName&) = delete;

  /// True if no other daemon of this runtime folder has the name. After 3 s of trying there is a conflict.
  bool lock();
  /// True if lock() failed because no more files may be opened.
  bool lacks_files() const { return lacks_files_; }
  /// True if this process has the name, or no node of the name answers at the master. After 3 s of asking
  /// there is a conflict.
  bool is_free(MasterClient& master);
  /// This process has registered: from now on it reclaims the name if another node registers it.
  void registered() { ours_ = true; }
  /// The node was shut down from outside. Returns how long to wait before registering again: from the third
  /// time in 10 s on up to 1 s by chance, so that of two nodes in step one finds the other. If another node
  /// has the name then, there is a conflict.
  Span after_foreign_stop(MasterClient& master);
  /// Why this process does not use the name, with the remedy; empty: there is no conflict.
  std::string conflict() const;

 private:
  using Clock = std::chrono::steady_clock;
  std::string other_node(MasterClient& master) const;
  bool refuse(const std::string& by);
  void give_up(const std::string& by);

  const std::string node_, master_uri_;
  int lock_ = -1;
  bool lockless_ = false;  // the file cannot be opened
  std::atomic<bool> lacks_files_{false};
  bool ours_ = false;
  std::optional<Clock::time_point> refused_since_;
  std::deque<Clock::time_point> foreign_stops_;
  mutable std::mutex mutex_;
  std::string conflict_;  // guarded by mutex_
};

}  // namespace lidard
