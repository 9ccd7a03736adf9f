// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <ostream>

#include "daemon/commands/commands.h"
#include "daemon/live/service.h"
#include "daemon/live/tcp_connections.h"
#include "daemon/live/udp_ports.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/pipeline/report.h"
#include "daemon/ros/ros_environment.h"
#include "daemon/ros/ros_session.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

constexpr auto tick_period = std::chrono::milliseconds(100);
constexpr int ticks_per_status = 10;
constexpr int ticks_per_summary = 100;
/// Diagnostics come once per second.
constexpr Span longest_report_age = std::chrono::seconds(2);
/// Threads that live make ten rounds per second.
constexpr auto longest_round = std::chrono::seconds(1);

/// Figures alone are no news.
std::string without_figures(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; }),
             text.end());
  return text;
}

/// Everything of a running daemon. The constructor's thread becomes the sensor thread.
class Daemon {
 public:
  Daemon(const Config& config, const RosOptions& how)
      : ros_(config, how),
        pipeline_(config, ros_.poses(), ros_),
        ports_(io_, config,
               [this](const Packet& packet) {
                 pipeline_.packet(packet);
                 arm();
               }),
        links_(io_, config,
               {[this](std::size_t sensor, const Packet& packet) {
                  pipeline_.chunk(sensor, packet);
                  arm();
                },
                [this](std::size_t sensor, Stamp now) { pipeline_.connected(sensor, now); },
                [this](std::size_t sensor) { pipeline_.disconnected(sensor); },
                [this](std::size_t sensor) { return pipeline_.frames(sensor); }}),
        signals_(io_, SIGINT, SIGTERM),
        timer_(io_),
        event_timer_(io_) {
    pipeline_.set_links(&links_);
    ros_.feed(pipeline_, [this](std::function<void(Stamp)> task) {
      boost::asio::post(io_, [this, task = std::move(task), received = wall_clock()] {
        task(received);
        arm();
      });
    });
    pipeline_.add_diagnostics([this](std::vector<DiagnosticItem>& items) {
      ports_.add_diagnostics(items);
      links_.add_diagnostics(items);
    });
  }

  /// Runs until a signal, or until it must leave the node's name to another daemon. Returns the exit code;
  /// `left`: false if ROS could not be left in time.
  int run(bool& left) {
    signals_.async_wait([this](const boost::system::error_code& error, int signal) {
      if (error) return;
      spdlog::info("stopping on signal {}", signal);
      io_.stop();
    });
    ports_.start();
    links_.start();
    ros_.start();
    ros_.transforms(pipeline_.static_transforms(), wall_clock());
    service_.ready(status());
    next_tick_ = std::chrono::steady_clock::now();
    schedule_tick();
    io_.run();
    service_.stopping();
    ports_.stop();
    pipeline_.finish(wall_clock());  // what is still in doubt of the last packets is counted
    links_.stop();
    for (const auto& sensor : pipeline_.report()) log_sensor(sensor);
    left = ros_.stop();
    return exit_code_;
  }

 private:
  std::string status() const {
    std::size_t alive = 0;
    const Stamp now = wall_clock();
    const auto reports = pipeline_.report();
    for (const auto& sensor : reports)
      alive += sensor.seen && seconds(now - sensor.last_arrival) < 1 ? 1U : 0U;
    std::string text = std::to_string(alive) + "/" + std::to_string(reports.size()) + " lidars, ";
    for (const std::string& part : {ports_.summary(), links_.summary()})
      if (!part.empty()) text += part + ", ";
    return text + "ROS master " + (ros_.has_master() ? "present" : "absent");
  }
  static void log_sensor(const SensorReport& sensor) {
    const Counters& c = sensor.counters;
    spdlog::info("{} ({}): {} packets, {} frames, {} lost, rejected {}", sensor.name, sensor.model, c.packets,
                 c.frames, c.lost_packets, rejected_text(c));
  }
  /// Calls `then` with the time that it is now, after all that has arrived by now: what waits in a socket
  /// while this thread is busy is not late.
  template <class Then>
  void catch_up(Then then) {
    // A handler that is posted runs before those of sockets found ready meanwhile, the next one after them.
    boost::asio::post(
        io_, [this, then, now = wall_clock()] { boost::asio::post(io_, [then, now] { then(now); }); });
  }
  void schedule_tick() {
    next_tick_ += tick_period;
    timer_.expires_at(next_tick_);
    timer_.async_wait([this](const boost::system::error_code& error) {
      if (error) return;
      catch_up([this](Stamp now) { tick(now); });
      schedule_tick();
    });
  }
  /// Sets the timer to the next thing that the pipeline has to do without new input.
  void arm() {
    const auto event = pipeline_.next_event();
    if (!event || event == next_event_) return;
    next_event_ = event;
    event_timer_.expires_after(std::max(Span(0), *event - wall_clock()));
    event_timer_.async_wait([this](const boost::system::error_code& error) {
      if (error) return;
      catch_up([this](Stamp now) {
        next_event_.reset();
        pipeline_.tick(now);
        arm();
      });
    });
  }
  void tick(Stamp now) {
    pipeline_.tick(now);
    arm();
    links_.tick();
    ports_.log_changes();
    links_.log_changes();
    feed_watchdog();
    leave_name_to_others();
    ++ticks_;
    if (ticks_ % ticks_per_status == 0) service_.status(status());
    if (ticks_ % ticks_per_summary == 0) log_trouble();
  }
  /// This thread moves, since it is here.
  void feed_watchdog() {
    const auto now = std::chrono::steady_clock::now();
    const std::string standing = ros_.standing_threads();
    if (standing.empty()) {
      service_.alive();
      fed_ = now;
      reported_standing_ = false;
    } else if (now - fed_ > longest_round && !reported_standing_) {
      spdlog::error("the watchdog is not fed, since for 1 s there stands still: {}", standing);
      reported_standing_ = true;
    }
  }
  void leave_name_to_others() {
    const std::string conflict = ros_.conflict();
    if (conflict.empty() || exit_code_ != exit_ok) return;
    spdlog::error("{}", conflict);
    exit_code_ = exit_failed;
    io_.stop();
  }
  /// What went wrong since the last summary, in one line per sensor; silence when all is well.
  void log_trouble() {
    for (const auto& item : pipeline_.diagnostics(wall_clock())) {
      std::string& told = told_[item.name];
      if (item.health == Health::ok) {
        if (!told.empty()) spdlog::info("{}: {}", item.name, item.message);
        told.clear();
      } else if (const std::string text = without_figures(item.message); told != text) {
        spdlog::warn("{}: {}", item.name, item.message);
        told = text;
      }
    }
  }

  boost::asio::io_context io_{1};
  ServiceManager service_;
  RosSession ros_;
  Pipeline pipeline_;
  UdpPorts ports_;
  TcpConnections links_;
  boost::asio::signal_set signals_;
  boost::asio::steady_timer timer_;
  boost::asio::steady_timer event_timer_;
  std::optional<Stamp> next_event_;  // what event_timer_ is set to
  std::chrono::steady_clock::time_point next_tick_;
  int ticks_ = 0;
  int exit_code_ = exit_ok;
  std::chrono::steady_clock::time_point fed_ = std::chrono::steady_clock::now();
  bool reported_standing_ = false;
  std::map<std::string, std::string> told_;
};

}  // namespace

int run_daemon(const Config& config, RosOptions ros, std::ostream& err) {
  try {
    ros.longest_report_age = longest_report_age;
    for (const auto& warning : config.warnings) spdlog::warn("{}", warning);
    Daemon daemon(config, ros);
    bool left = false;
    const int code = daemon.run(left);
    // roscpp's destructors would wait for a master that hangs.
    if (!left) std::quick_exit(code);
    return code;
  } catch (const RosError& e) {
    err << e.what() << '\n';
    return exit_usage;
  }
}

int run_daemon(const std::string& config_file, const std::vector<std::string>& ros_arguments,
               std::ostream& err) {
  set_up_logging();
  try {
    RosOptions ros;
    ros.remappings = ros_arguments;
    return run_daemon(load_config(config_file), ros, err);
  } catch (const ConfigError& e) {
    err << e.what() << '\n';
    return exit_config;
  }
}

}  // namespace lidard
