// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <malloc.h>

#include <atomic>
#include <boost/asio/signal_set.hpp>
#include <cstdlib>
#include <memory>
#include <optional>
#include <ostream>
#include <thread>

#include "daemon/commands/commands.h"
#include "daemon/commands/last_good.h"
#include "daemon/commands/status.h"
#include "daemon/health/journal.h"
#include "daemon/health/sentences.h"
#include "daemon/live/cloud_worker.h"
#include "daemon/live/process_memory.h"
#include "daemon/live/runtime_socket.h"
#include "daemon/live/sensor_loop.h"
#include "daemon/live/service.h"
#include "daemon/live/thread_priority.h"
#include "daemon/log/log.h"
#include "daemon/offline/remarks.h"
#include "daemon/ros/master/environment.h"
#include "daemon/ros/session.h"

namespace lidard {
namespace {

constexpr int ticks_per_status = 10, ticks_per_retry = 100;
/// Diagnostics come once per second.
constexpr Span longest_report_age = std::chrono::seconds(2);
/// A running thread makes ten rounds per second.
constexpr auto longest_round = std::chrono::seconds(1);

void log_event(const Event& event) {
  if (event.logged) return;
  const auto level = event.health == Health::ok     ? LogLevel::info
                     : event.health == Health::warn ? LogLevel::warn
                                                    : LogLevel::error;
  log_line(level, event.source + ": " + event.text);
}

void log_remarks(const Config& config) {
  for (const auto& list : {remarks_on(config), host_remarks_on(config)}) {
    for (const auto& remark : list) log_warn("{}", remark);
  }
}

/// A running daemon. The constructor's thread is the sensor thread, which does the daemon's own tasks too.
class Daemon {
 public:
  /// `trouble`: why `config` is not the content of the file; empty: it is.
  Daemon(const Config& config, const RosOptions& how, std::string trouble)
      : division_(std::make_shared<const Division>(config)),
        last_good_(config.file),
        trouble_(std::move(trouble)),
        ros_(config, with_clock(how)),
        box_(config.black_box,
             [](bool good, const std::string& sentence) {
               log_line(good ? LogLevel::info : LogLevel::error, "black box: " + sentence);
             }),
        cloud_sink_(ros_.add_sink()),
        sensors_(division_->planes, clock_, box_, ros_.poses(), ros_.sink()),
        clouds_(division_->clouds, clock_, box_, ros_.poses(), cloud_sink_, sensors_),
        signals_(sensors_.io(), SIGINT, SIGTERM),
        requests_(sensors_.io(), SIGHUP, SIGUSR1),
        socket_(sensors_.io(),
                {{"status", [this](const auto& reply) { reply(status_json(state(), journal_)); }},
                 {"events", [this](const auto& reply) { reply(events_json(journal_)); }},
                 {"metrics", [this](const auto& reply) { reply(metrics_text(state())); }},
                 {"dump", [this](const auto& reply) {
                    box_.dump([reply](const std::string& said) { reply(said + "\n"); });
                  }}}) {
    ros_.sink().set_topics(output_topics(division_->planes));
    cloud_sink_.set_topics(output_topics(division_->clouds));
    ros_.feed(config, [this](const std::string& sensor, auto task) {
      if (clouds_.post(sensor, task) && !sensor.empty()) return;
      sensors_.post([this, task = std::move(task)](Stamp received) { task(sensors_.pipeline(), received); });
    });
    sensors_.add_items = [this](auto& items) {
      items.push_back(clock_.item());
      items.push_back(configuration_item());
      clouds_.add_items(items);
      if (auto item = box_.item()) items.push_back(std::move(*item));
    };
    sensors_.on_round = [this] { feed_watchdog(); };
    sensors_.on_tick = [this](Stamp now) { tick(now); };
  }

  /// Runs until a signal, or until another daemon uses the node's name. Returns the exit code; `left`: false
  /// if a thread did not end in time.
  int run(bool& left) {
    signals_.async_wait([this](const boost::system::error_code& error, int signal) {
      if (error) return;
      log_info("stopping on signal {}", signal);
      sensors_.stop();
    });
    wait_for_signals();
    ros_.start();
    ros_.sink().transforms(sensors_.pipeline().static_transforms(), clock_.now());
    if (const std::string trouble = socket_.start(runtime_socket_path()); !trouble.empty())
      log_warn("`lidard status` cannot ask this daemon: {}", trouble);
    sensors_.post([this](Stamp now) { sensors_.pipeline().tick(now); });
    clouds_.start(division_->clouds);
    // Report READY once all sockets are open.
    clouds_.when_done([this] { came_up(); });
    sensors_.run();
    if (reader_.joinable()) reader_.join();  // a signal may come during a reload
    service_.stopping();
    socket_.stop();
    box_.finish();
    sensors_.finish();
    left = clouds_.stop();
    left = ros_.stop() && left;
    return exit_code_;
  }

 private:
  /// All sockets are open.
  void came_up() {
    service_.ready(status(ros_.diagnostics(clock_.now())));
    keep_config();
  }
  void keep_config() {
    // After a wrong file the configuration in force is the stored copy already.
    if (!trouble_.empty()) return;
    const std::string before = std::exchange(not_kept_, last_good_.keep(division_->whole));
    if (!not_kept_.empty() && before.empty()) log_warn("{}", not_kept_);
  }
  void wait_for_signals() {
    requests_.async_wait([this](const boost::system::error_code& error, int signal) {
      if (error) return;
      if (signal == SIGHUP)
        reload();
      else
        box_.dump([](const std::string& said) { log_info("SIGUSR1: {}", said); });
      wait_for_signals();
    });
  }
  /// Reloads the file in a separate thread, since reading a calibration is slow. An invalid file changes
  /// nothing.
  void reload() {
    wants_reload_ = reader_.joinable();
    if (wants_reload_) return;
    service_.reloading();
    const auto read = [this, file = division_->whole.file] {
      std::shared_ptr<const Division> division;
      std::string trouble;
      try {
        division = std::make_shared<const Division>(load_config(file));
      } catch (const std::exception& error) {
        trouble = error.what();
      }
      sensors_.post(
          [this, division, trouble](Stamp now) { division ? change(division, now) : end_reload(trouble); });
    };
    try {
      reader_ = std::thread(read);
    } catch (const std::system_error& error) {
      end_reload(std::string("no thread can read the file: ") + error.what());
    }
  }
  /// Switches both threads in order, each in its own thread.
  void change(const std::shared_ptr<const Division>& next, Stamp now) {
    log_remarks(next->whole);
    try {
      clouds_.start(next->clouds);
      ros_.change(division_->whole, next->whole);
    } catch (const std::system_error& error) {
      return end_reload(std::string("no thread can be started for the clouds: ") + error.what());
    } catch (const RosError& error) {
      return end_reload(error.what());
    }
    division_ = next;
    ros_.sink().set_topics(output_topics(next->planes));
    sensors_.configure(next->planes);
    ros_.sink().transforms(sensors_.pipeline().static_transforms(), now);
    const auto set_topics = [this, next] { cloud_sink_.set_topics(output_topics(next->clouds)); };
    clouds_.configure(next, set_topics, [this] {
      sensors_.retry_ports();  // of sensors that the other thread had
      sensors_.pipeline().tick(clock_.now());
      box_.configure(division_->whole.black_box);
      end_reload("");
    });
  }
  /// `trouble`: why the file was rejected; empty: it is in force.
  void end_reload(const std::string& trouble) {
    if (reader_.joinable()) reader_.join();
    trouble_ = trouble;
    ++reloads_;
    if (trouble.empty())
      log_info("{} is in force", division_->whole.file);
    else
      log_error("{}; nothing is changed, correct it and reload again", trouble);
    came_up();
    malloc_trim(0);  // returns the memory of the former configuration
    if (std::exchange(wants_reload_, false)) reload();
  }
  DiagnosticItem configuration_item() const {
    DiagnosticItem item{"configuration"};
    item.logged = true;
    item.set<says::as_in_file>(division_->whole.file);
    if (!not_kept_.empty()) item.set(Health::warn, not_kept_);
    if (!trouble_.empty()) item.set<says::file_refused>(trouble_);
    item.add("File", division_->whole.file);
    item.add("Reloads", reloads_);
    return item;
  }
  std::string status(const std::vector<DiagnosticItem>& items) const {
    std::string text;
    for (const auto& [kind, form] : {std::pair("sensor ", "{}/{} lidars, "),
                                     {"port ", "{} of {} ports open, "},
                                     {"link ", "{} of {} devices connected, "}}) {
      std::size_t up = 0, all = 0;
      for (const DiagnosticItem& item : items) {
        if (!item.is_up || item.name.rfind(kind, 0) != 0) continue;
        ++all;
        up += *item.is_up ? 1U : 0U;
      }
      if (all > 0 || text.empty()) text += fmt::format(fmt::runtime(form), up, all);
    }
    return text + "ROS master " + (ros_.has_master() ? "present" : "absent");
  }
  DaemonState state() {
    const Stamp now = clock_.now();
    std::vector<DiagnosticItem> items = ros_.diagnostics(now);
    DaemonState all{
        ros_.node(), clock_.step()->host(now), now - started_, status(items), history_, std::move(items), {}};
    for (const OutputTopic& topic : output_topics(division_->whole)) {
      const TopicFigures figures = ros_.publisher().figures(topic.name, now);
      if (topic.promised || figures.frames > 0) all.topics.emplace_back(topic.name, figures);
    }
    return all;
  }
  void tick(Stamp now) {
    leave_name_to_others();
    const std::vector<DiagnosticItem> items = ros_.diagnostics(now);
    if (++ticks_ % ticks_per_status == 0) service_.status(status(items));
    if (!not_kept_.empty() && ticks_ % ticks_per_retry == 0) keep_config();
    const HostStamp host = clock_.step()->host(now);
    for (const std::string& error : journal_.update(items, host)) box_.incident(now, error);
    box_.poll(now, host, [this] { return events_json(journal_); });
  }
  /// Names of the hanging threads.
  std::string stalled_threads() {
    std::string stalled = ros_.stalled_threads();
    if (clouds_.is_stalled()) stalled += (stalled.empty() ? "" : ", ") + std::string("the thread of clouds");
    return stalled;
  }
  void feed_watchdog() {
    const auto now = std::chrono::steady_clock::now();
    const std::string stalled = stalled_threads();
    if (stalled.empty()) {
      service_.alive();
      fed_ = now;
      reported_stall_ = false;
    } else if (now - fed_ > longest_round && !reported_stall_) {
      log_error("the watchdog is not fed, since these have not moved for 1 s: {}", stalled);
      reported_stall_ = true;
    }
  }
  void leave_name_to_others() {
    const std::string conflict = ros_.conflict();
    if (conflict.empty() || exit_code_ != exit_ok) return;
    log_error("{}", conflict);
    exit_code_ = exit_failed;
    sensors_.stop();
  }

  RosOptions with_clock(RosOptions how) const {
    how.clock_step = clock_.step();
    return how;
  }

  std::shared_ptr<const Division> division_;
  const LastGood last_good_;
  std::string trouble_;   // why the configuration is not the content of the file; empty: it is
  std::string not_kept_;  // why it could not be stored; empty: it is
  std::uint64_t reloads_ = 0;
  std::thread reader_;  // joinable during a reload
  bool wants_reload_ = false;
  DaemonClock clock_;
  ServiceManager service_;
  Journal journal_{log_event};
  RosSession ros_;
  BlackBox box_;
  PublisherThread::Sink& cloud_sink_;
  SensorLoop sensors_;
  CloudWorker clouds_;
  boost::asio::signal_set signals_;
  boost::asio::signal_set requests_;  // signals that do not end the daemon
  int ticks_ = 0;
  int exit_code_ = exit_ok;
  std::chrono::steady_clock::time_point fed_ = std::chrono::steady_clock::now();
  bool reported_stall_ = false;
  const Stamp started_ = clock_.now();
  const std::string history_ = service_history();
  RuntimeSocket socket_;
};

}  // namespace

int run_daemon(const Config& config, RosOptions ros, std::ostream& err, const std::string& trouble) {
  keep_heap_small();
  lock_memory();
  prefer_this_thread();
  try {
    ros.longest_report_age = longest_report_age;
    log_remarks(config);
    Daemon daemon(config, ros, trouble);
    bool left = false;
    const int code = daemon.run(left);
    // roscpp's destructors wait for a hanging master.
    if (!left) std::quick_exit(code);
    return code;
  } catch (const RosError& e) {
    err << e.what() << '\n';
    return exit_usage;
  }
}

int run_daemon(const std::string& config_file, const std::vector<std::string>& ros_arguments,
               std::ostream& err) {
  RosOptions ros;
  ros.remappings = ros_arguments;
  std::string trouble;
  try {
    return run_daemon(load_config(config_file), ros, err);
  } catch (const ConfigError& e) {
    trouble = e.what();
  }
  std::optional<Config> last_good = LastGood(config_file).load();
  if (!last_good) {
    err << trouble << '\n';
    return exit_config;
  }
  log_error("{}; the last good configuration is in force, correct the file and reload", trouble);
  last_good->file = config_file;
  return run_daemon(*last_good, ros, err, trouble);
}

}  // namespace lidard
