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
#include "daemon/commands/status.h"
#include "daemon/live/black_box.h"
#include "daemon/live/host_causes.h"
#include "daemon/live/journal.h"
#include "daemon/live/runtime_socket.h"
#include "daemon/live/service.h"
#include "daemon/live/tcp_connections.h"
#include "daemon/live/udp_ports.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/pipeline/report.h"
#include "daemon/ros/ros_environment.h"
#include "daemon/ros/ros_session.h"
#include "drivers/net/interface_watch.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

constexpr auto tick_period = std::chrono::milliseconds(100);
constexpr int ticks_per_status = 10;
/// Diagnostics come once per second.
constexpr Span longest_report_age = std::chrono::seconds(2);
/// Threads that live make ten rounds per second.
constexpr auto longest_round = std::chrono::seconds(1);

constexpr const char* clock_name = "clock";

void log_event(const Event& event) {
  // Of the clock and of ROS the log has more, since it happened.
  if (event.source == clock_name || event.source == "ROS") return;
  const auto level = event.health == Health::ok     ? spdlog::level::info
                     : event.health == Health::warn ? spdlog::level::warn
                                                    : spdlog::level::err;
  spdlog::log(level, "{}: {}", event.source, event.text);
}

/// Everything of a running daemon. The constructor's thread becomes the sensor thread.
class Daemon {
 public:
  Daemon(const Config& config, const RosOptions& how)
      : ros_(config, how),
        pipeline_(config, ros_.poses(), ros_),
        ports_(io_, config,
               [this](const Packet& packet) {
                 take(packet, [this](const Packet& timed) { pipeline_.packet(timed); });
               }),
        host_causes_(config, ports_),
        links_(io_, config,
               {[this](std::size_t sensor, const Packet& packet) {
                  take(packet, [&](const Packet& timed) { pipeline_.chunk(sensor, timed); });
                },
                [this](std::size_t sensor, Stamp at) { pipeline_.connected(sensor, without_steps(at)); },
                [this](std::size_t sensor) { pipeline_.disconnected(sensor); },
                [this](std::size_t sensor) { return pipeline_.frames(sensor); },
                [this](std::size_t sensor) { return host_causes_.trouble(sensor); },
                [this](std::size_t sensor) { return host_causes_.hint(sensor); }}),
        signals_(io_, SIGINT, SIGTERM),
        wishes_(io_, SIGHUP, SIGUSR1),
        timer_(io_),
        event_timer_(io_),
        topics_(output_topics(config)),
        socket_(io_, {{"status", [this] { return status_json(state(), journal_); }},
                      {"events", [this] { return events_json(journal_); }},
                      {"metrics", [this] { return metrics_text(state()); }},
                      {"dump", [this] { return dump() + "\n"; }}}),
        box_(config.black_box, [](bool good, const std::string& sentence) {
          spdlog::log(good ? spdlog::level::info : spdlog::level::err, "black box: {}", sentence);
        }) {
    pipeline_.set_links(&links_);
    ros_.feed(pipeline_, [this](std::function<void(Stamp)> task) {
      boost::asio::post(io_, [this, task = std::move(task), received = wall_clock()] {
        task(without_steps(received));
        arm();
      });
    });
    pipeline_.add_diagnostics([this](std::vector<DiagnosticItem>& items) {
      const Stamp at = clock_.realtime(now());
      items.push_back(clock_item());
      ports_.add_diagnostics(items);
      links_.add_diagnostics(items);
      update_journal(items, at);
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
    wait_for_wishes();
    ports_.start();
    links_.start();
    if (const std::string trouble = interfaces_.start(); !trouble.empty()) spdlog::warn("{}", trouble);
    ros_.start();
    ros_.transforms(pipeline_.static_transforms(), now());
    if (const std::string trouble = socket_.start(runtime_socket_path()); !trouble.empty())
      spdlog::warn("`lidard status` cannot ask this daemon: {}", trouble);
    service_.ready(status());
    next_tick_ = std::chrono::steady_clock::now();
    schedule_tick();
    io_.run();
    service_.stopping();
    socket_.stop();
    interfaces_.stop();
    ports_.stop();
    pipeline_.finish(now());  // what is still in doubt of the last packets is counted
    links_.stop();
    for (const auto& sensor : pipeline_.report()) log_sensor(sensor);
    left = ros_.stop();
    return exit_code_;
  }

 private:
  /// What comes next from the sensors, the network and ROS is told in the time without steps; the host's
  /// clock is looked at each time, so that a step is known before the first stamp after it is used.
  ClockReading look_at_clocks() {
    const ClockReading reading = read_clocks();
    if (const auto step = clock_.observe(reading)) {
      set_at_ = clock_.steady(reading);
      last_step_ = *step;
      ros_.set_step(clock_.step());
      spdlog::warn("the host's clock was set by {:+.3f} s; the stamps follow it in one step", seconds(*step));
    }
    return reading;
  }
  Stamp now() { return clock_.steady(look_at_clocks()); }
  Stamp without_steps(Stamp taken) { return clock_.steady(taken, look_at_clocks()); }
  template <class Use>
  void take(const Packet& packet, Use use) {
    Packet timed = packet;
    timed.arrival = without_steps(packet.arrival);
    box_.add(timed);
    use(timed);
    arm();
  }
  void wait_for_wishes() {
    wishes_.async_wait([this](const boost::system::error_code& error, int signal) {
      if (error) return;
      if (signal == SIGHUP)
        spdlog::info(
            "SIGHUP: the configuration is read at the start only; restart this daemon for a changed one");
      else
        spdlog::info("SIGUSR1: {}", dump());
      wait_for_wishes();
    });
  }
  /// The path of the black box's capture, or why there is none.
  std::string dump() {
    try {
      return box_.write(now(), clock_.step(), events_json(journal_));
    } catch (const std::exception& error) {
      return std::string("error: ") + error.what();
    }
  }
  void update_journal(const std::vector<DiagnosticItem>& items, Stamp at) {
    constexpr Span aftermath = std::chrono::seconds(5);  // what follows an error for so long is written too
    if (journal_.update(items, at) == Health::error) box_.write_on_error(now(), aftermath);
  }
  DiagnosticItem clock_item() {
    DiagnosticItem item;
    item.name = clock_name;
    item.message = "the host's clock runs evenly";
    item.values = {{"Steps", std::to_string(clock_.steps())},
                   {"Sum of Steps (s)", fmt::format("{:.3f}", seconds(clock_.step()))}};
    constexpr Span news = std::chrono::seconds(10);
    if (clock_.steps() > 0 && now() - set_at_ < news) {
      item.health = Health::warn;
      item.message = fmt::format(
          "the host's clock was set by {:+.3f} s; keep it with chrony or ntpd, which turn its rate instead",
          seconds(last_step_));
    }
    return item;
  }
  std::string status() const {
    std::size_t alive = 0;
    const Stamp now = clock_.steady(read_clocks());
    const auto reports = pipeline_.report();
    for (const auto& sensor : reports)
      alive += sensor.seen && seconds(now - sensor.last_arrival) < 1 ? 1U : 0U;
    std::string text = std::to_string(alive) + "/" + std::to_string(reports.size()) + " lidars, ";
    for (const std::string& part : {ports_.summary(), links_.summary()})
      if (!part.empty()) text += part + ", ";
    return text + "ROS master " + (ros_.has_master() ? "present" : "absent");
  }
  DaemonState state() {
    const Stamp at = now();
    DaemonState all{ros_.node(), clock_.realtime(at), at - started_, status(), pipeline_.diagnostics(at), {}};
    all.items.push_back(ros_.own_status());
    for (const OutputTopic& topic : topics_)
      all.topics.emplace_back(topic.name, ros_.figures(topic, all.now));
    return all;
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
    boost::asio::post(io_, [this, then, now = now()] { boost::asio::post(io_, [then, now] { then(now); }); });
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
    event_timer_.expires_after(std::max(Span(0), *event - now()));
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
    ros_.stand_back(ports_.taken());
    links_.log_changes();
    feed_watchdog();
    leave_name_to_others();
    ++ticks_;
    if (ticks_ % ticks_per_status == 0) service_.status(status());
    update_journal({ros_.own_status()}, clock_.realtime(now));
    box_.poll(now, clock_.step(), [this] { return events_json(journal_); });
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

  boost::asio::io_context io_{1};
  HostClock clock_{read_clocks()};
  Stamp set_at_{};
  Span last_step_{0};
  ServiceManager service_;
  Journal journal_{log_event};
  RosSession ros_;
  Pipeline pipeline_;
  UdpPorts ports_;
  HostCauses host_causes_;
  TcpConnections links_;
  InterfaceWatch interfaces_{io_, [this] {
                               host_causes_.interfaces_changed();
                               ports_.look_again();
                               links_.look_again();
                             }};
  boost::asio::signal_set signals_;
  boost::asio::signal_set wishes_;  // that do not end the daemon
  boost::asio::steady_timer timer_;
  boost::asio::steady_timer event_timer_;
  std::optional<Stamp> next_event_;  // what event_timer_ is set to
  std::chrono::steady_clock::time_point next_tick_;
  int ticks_ = 0;
  int exit_code_ = exit_ok;
  std::chrono::steady_clock::time_point fed_ = std::chrono::steady_clock::now();
  bool reported_standing_ = false;
  const Stamp started_ = now();
  const std::vector<OutputTopic> topics_;
  RuntimeSocket socket_;
  BlackBox box_;
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
