// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <malloc.h>
#include <spdlog/spdlog.h>

#include <array>
#include <atomic>
#include <boost/asio/signal_set.hpp>
#include <ostream>
#include <thread>

#include "daemon/commands/commands.h"
#include "daemon/commands/status.h"
#include "daemon/live/frame_queue.h"
#include "daemon/live/journal.h"
#include "daemon/live/runtime_socket.h"
#include "daemon/live/sensor_loop.h"
#include "daemon/live/service.h"
#include "daemon/ros/ros_environment.h"
#include "daemon/ros/ros_pulse.h"
#include "daemon/ros/ros_session.h"
#include "daemon/ros/wait_until.h"

namespace lidard {
namespace {

constexpr int ticks_per_status = 10;
/// Diagnostics come once per second.
constexpr Span longest_report_age = std::chrono::seconds(2);
/// Threads that live make ten rounds per second.
constexpr auto longest_round = std::chrono::seconds(1);

void log_event(const Event& event) {
  if (event.logged) return;
  const auto level = event.health == Health::ok     ? spdlog::level::info
                     : event.health == Health::warn ? spdlog::level::warn
                                                    : spdlog::level::err;
  spdlog::log(level, "{}: {}", event.source, event.text);
}

/// A topic for each source that is handed over to the other lane.
std::vector<OutputTopic> topics_of(const std::vector<std::string>& sources) {
  std::vector<OutputTopic> topics;
  for (const std::string& source : sources)
    topics.push_back({source, TopicKind::scan, true, 0, topics.size()});
  return topics;
}

/// Everything of a running daemon. The constructor's thread becomes that of the lane of planes, which the
/// daemon's own affairs share; the lane of clouds has another one, if it has anything to do.
class Daemon {
 public:
  Daemon(const Config& config, const RosOptions& how)
      : parts_{part_of(config, Lane::planes), part_of(config, Lane::clouds)},
        clock_([this](Span step) { ros_.set_step(step); }),
        ros_(parts_[0], parts_[1], how),
        box_(config.black_box,
             [](bool good, const std::string& sentence) {
               spdlog::log(good ? spdlog::level::info : spdlog::level::err, "black box: {}", sentence);
             }),
        planes_(parts_[0], clock_, box_, ros_.poses(), ros_.sink(Lane::planes)),
        clouds_(parts_[1], clock_, box_, ros_.poses(), ros_.sink(Lane::clouds)),
        handed_topics_(topics_of(parts_[1].hand_over)),
        handed_over_(handed_topics_, Backpressure::drop_oldest),
        topics_{output_topics(parts_[0]), output_topics(parts_[1])},
        signals_(planes_.io(), SIGINT, SIGTERM),
        wishes_(planes_.io(), SIGHUP, SIGUSR1),
        socket_(planes_.io(), {{"status", [this] { return status_json(state(), journal_); }},
                               {"events", [this] { return events_json(journal_); }},
                               {"metrics", [this] { return metrics_text(state()); }},
                               {"dump", [this] { return dump() + "\n"; }}}) {
    for (const auto& [part, loop] : {std::pair(&parts_[0], &planes_), {&parts_[1], &clouds_}})
      ros_.feed(*part, config, loop->pipeline(),
                [loop = loop](std::function<void(Stamp)> task) { loop->post(std::move(task)); });
    planes_.add_items = [this](auto& items) { items.push_back(clock_.item()); };
    planes_.on_state = [this](const LaneState& state) { take_state(Lane::planes, state); };
    planes_.on_tick = [this](Stamp now) { tick(now); };
    clouds_.on_state = [this](const LaneState& state) {
      planes_.post([this, state](Stamp) { take_state(Lane::clouds, state); });
    };
    clouds_.pipeline().set_hand_over(
        [this](std::size_t source, const PlanarScan& scan, Stamp now) { hand_over(source, scan, now); });
  }

  /// Runs until a signal, or until it must leave the node's name to another daemon. Returns the exit code;
  /// `left`: false if a thread did not end in time.
  int run(bool& left) {
    signals_.async_wait([this](const boost::system::error_code& error, int signal) {
      if (error) return;
      spdlog::info("stopping on signal {}", signal);
      planes_.stop();
    });
    wait_for_wishes();
    ros_.start();
    ros_.sink(Lane::planes).transforms(planes_.pipeline().static_transforms(), clock_.now());
    if (const std::string trouble = socket_.start(runtime_socket_path()); !trouble.empty())
      spdlog::warn("`lidard status` cannot ask this daemon: {}", trouble);
    // Ready is who has opened all sockets. Where there are no clouds, their lane has none to open.
    planes_.post([this](Stamp) {
      states_[0] = planes_.state();
      if (!has_clouds()) service_.ready(status());
    });
    clouds_.post([this](Stamp) {
      planes_.post([this, state = clouds_.state()](Stamp) {
        take_state(Lane::clouds, state);
        service_.ready(status());
      });
    });
    if (has_clouds()) clouds_thread_ = std::thread([this] { run_clouds(); });
    planes_.run();
    service_.stopping();
    socket_.stop();
    planes_.finish();
    left = end_clouds();
    left = ros_.stop() && left;
    return exit_code_;
  }

 private:
  bool has_clouds() const { return !parts_[1].sensors.empty(); }
  void run_clouds() {
    name_this_thread("lidard-clouds");
    clouds_.run();
    clouds_.finish();
    clouds_ended_ = true;
  }
  /// False if the thread stands still.
  bool end_clouds() {
    if (!clouds_thread_.joinable()) return true;
    clouds_.stop();
    const bool ended = wait_until([this] { return clouds_ended_.load(); }, longest_round);
    ended ? clouds_thread_.join() : clouds_thread_.detach();
    return ended;
  }
  /// In the thread of the lane of clouds.
  void hand_over(std::size_t source, const PlanarScan& scan, Stamp now) {
    handed_over_.push(handed_topics_[source], scan, now);
    planes_.post([this](Stamp received) { take_over(received); });
  }
  void take_over(Stamp received) {
    while (QueuedFrame* const frame = handed_over_.pop(Span(0))) {
      planes_.pipeline().scan_message(parts_[1].hand_over[frame->lane], std::get<PlanarScan>(frame->content),
                                      received);
      handed_over_.done(frame);
    }
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
      return box_.write(clock_.now(), clock_.step(), events_json(journal_));
    } catch (const std::exception& error) {
      return std::string("error: ") + error.what();
    }
  }
  void take_state(Lane lane, const LaneState& state) {
    states_[static_cast<std::size_t>(lane)] = state;
    update_journal();
  }
  /// What both lanes tell.
  std::vector<DiagnosticItem> items() const {
    std::vector<DiagnosticItem> all = joined(states_[0].items, states_[1].items);
    all.push_back(ros_.own_status());
    return all;
  }
  void update_journal() {
    constexpr Span aftermath = std::chrono::seconds(5);  // what follows an error for so long is written too
    const Stamp now = clock_.now();
    if (journal_.update(items(), clock_.realtime(now)) == Health::error) box_.write_on_error(now, aftermath);
  }
  std::string status() const {
    Share lidars, ports, devices;
    for (const LaneState& state : states_) {
      lidars += state.lidars_alive;
      ports += state.open_ports;
      devices += state.connected_devices;
    }
    std::string text = fmt::format("{}/{} lidars, ", lidars.good, lidars.all);
    if (ports.all > 0) text += fmt::format("{} of {} ports open, ", ports.good, ports.all);
    if (devices.all > 0) text += fmt::format("{} of {} devices connected, ", devices.good, devices.all);
    return text + "ROS master " + (ros_.has_master() ? "present" : "absent");
  }
  DaemonState state() {
    states_[0] = planes_.state();
    const Stamp now = clock_.now();
    DaemonState all{ros_.node(), clock_.realtime(now), now - started_, status(), items(), {}};
    for (const Lane lane : {Lane::planes, Lane::clouds}) {
      for (const OutputTopic& topic : topics_[static_cast<std::size_t>(lane)])
        all.topics.emplace_back(topic.name, ros_.figures(lane, topic, now));
    }
    return all;
  }
  void tick(Stamp now) {
    feed_watchdog();
    leave_name_to_others();
    ++ticks_;
    if (ticks_ % ticks_per_status == 0) service_.status(status());
    update_journal();
    box_.poll(now, clock_.step(), [this] { return events_json(journal_); });
  }
  /// The threads that stand still. This one moves, since it is here.
  std::string standing_threads() {
    std::string standing = ros_.standing_threads();
    const std::uint64_t rounds = clouds_.rounds();
    if (has_clouds() && rounds == clouds_rounds_)
      standing += (standing.empty() ? "" : ", ") + std::string("the thread of clouds");
    if (standing.empty()) clouds_rounds_ = rounds;
    return standing;
  }
  void feed_watchdog() {
    const auto now = std::chrono::steady_clock::now();
    const std::string standing = standing_threads();
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
    planes_.stop();
  }

  const std::array<Config, 2> parts_;  // by lane, as all arrays here
  DaemonClock clock_;
  ServiceManager service_;
  Journal journal_{log_event};
  RosSession ros_;
  BlackBox box_;
  SensorLoop planes_;
  SensorLoop clouds_;
  const std::vector<OutputTopic> handed_topics_;
  FrameQueue handed_over_;
  std::thread clouds_thread_;
  std::atomic<bool> clouds_ended_{false};
  std::uint64_t clouds_rounds_ = 0;
  std::array<LaneState, 2> states_;
  const std::array<std::vector<OutputTopic>, 2> topics_;
  boost::asio::signal_set signals_;
  boost::asio::signal_set wishes_;  // that do not end the daemon
  int ticks_ = 0;
  int exit_code_ = exit_ok;
  std::chrono::steady_clock::time_point fed_ = std::chrono::steady_clock::now();
  bool reported_standing_ = false;
  const Stamp started_ = clock_.now();
  RuntimeSocket socket_;
};

/// Clouds of 10 MB come and go ten times a second. Each gets memory of its own, which the system has back
/// after it; in the heaps of several threads they would leave holes.
void keep_heap_small() {
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  mallopt(M_ARENA_MAX, 2);
}

}  // namespace

int run_daemon(const Config& config, RosOptions ros, std::ostream& err) {
  keep_heap_small();
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
