// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/health/pipeline_health.h"
#include "daemon/live/black_box.h"
#include "daemon/live/daemon_clock.h"
#include "daemon/live/host_causes.h"
#include "daemon/live/tcp_connections.h"
#include "daemon/live/udp_ports.h"
#include "drivers/net/interface_watch.h"

namespace lidard {

/// A thread of a running daemon that works on frames: its sockets and its pipeline, used only by the thread
/// of run(). Other threads post tasks.
class SensorLoop {
 public:
  /// The other arguments must outlive this.
  SensorLoop(const Config& config, DaemonClock& clock, BlackBox& box, TransformSource& transforms,
             DiagnosticSink& sink);

  boost::asio::io_context& io() { return io_; }
  Pipeline& pipeline() { return pipeline_; }
  /// Called in the thread of run() about ten times per second; on_tick only when no packet is pending.
  std::function<void()> on_round = [] {};
  std::function<void(Stamp now)> on_tick = [](Stamp) {};
  /// Adds items to the diagnostics.
  std::function<void(std::vector<DiagnosticItem>&)> add_items = [](std::vector<DiagnosticItem>&) {};

  /// Runs `task` in the thread of run(), with the time without steps at which it was posted.
  void post(std::function<void(Stamp)> task);
  /// Opens the sockets and runs until stop().
  void run();
  /// Applies another configuration. Unchanged entries are not interrupted.
  void configure(const Config& config);
  /// Opens ports again that could not be opened so far.
  void retry_ports() { ports_.interfaces_changed(); }
  /// Thread-safe.
  void stop() { io_.stop(); }
  /// Call after run(): closes the sockets, completes the counters and logs them.
  void finish();
  /// A counter that increases about ten times per second while the thread runs. Thread-safe.
  std::uint64_t rounds() const { return rounds_; }

 private:
  void report_round();
  void handle(std::vector<Packet>& packets, std::optional<std::size_t> connection = std::nullopt);
  template <class Then>
  void catch_up(Then then);
  void schedule_tick();
  void arm();
  void tick(Stamp now);
  DiagnosticItem load_item() const;

  boost::asio::io_context io_{1};
  DaemonClock& clock_;
  BlackBox& box_;
  Pipeline pipeline_;
  HealthReporter reporter_;
  UdpPorts ports_;
  HostCauses host_causes_;
  TcpConnections connections_;
  InterfaceWatch interfaces_;
  boost::asio::steady_timer timer_;
  boost::asio::steady_timer event_timer_;
  std::vector<Packet> chunk_ = std::vector<Packet>(1);  // of a connection
  std::optional<Stamp> next_event_;                     // expiry of event_timer_
  std::chrono::steady_clock::time_point next_tick_, next_round_;
  std::atomic<std::uint64_t> rounds_{0};
  double stalled_s_ = 0;  // how long this thread waited for a processor when it did last
  std::optional<std::chrono::steady_clock::time_point> stalled_at_;
};

}  // namespace lidard
