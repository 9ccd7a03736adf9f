// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_connection.h"

#include <fmt/format.h>
#include <ros/connection_manager.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/this_node.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <thread>
#include <utility>

#include "daemon/pipeline/log.h"
#include "daemon/ros/ros_callback_thread.h"
#include "daemon/ros/ros_components.h"
#include "daemon/ros/ros_diagnostics.h"
#include "daemon/ros/ros_environment.h"
#include "daemon/ros/ros_lanes.h"
#include "daemon/ros/ros_master.h"
#include "daemon/ros/ros_name.h"
#include "daemon/ros/ros_pulse.h"
#include "daemon/ros/wait_until.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// How often the master is asked whether it is there.
constexpr auto master_period = milliseconds(500);
constexpr auto look_period = milliseconds(100);
/// For so long it is told that we were shut down from outside.
constexpr auto news_of_a_stop = std::chrono::seconds(60);
/// Longer than a daemon that has waited for the master takes to register.
constexpr auto longest_standing_back = std::chrono::seconds(2);
/// A live thread makes ten rounds per second.
constexpr auto longest_round = std::chrono::seconds(2);
/// To advertise all topics takes a busy master its time.
constexpr auto longest_call = std::chrono::seconds(5);

}  // namespace

// Shared with the threads: one that hangs in roscpp at the end outlives the RosConnection.
struct RosConnection::Impl {
  Impl(RosOptions given, const RosLanes::Topics& topics)
      : options(std::move(given)),
        master_uri(choose_master(options.remappings)),
        diagnostics(options.longest_report_age) {
    init_ros(options);
    for (const auto& of_lane : topics) check_ros_names(of_lane);
    node = ros::this_node::getName();
    name = std::make_unique<RosName>(node, wall_clock());
    lanes = std::make_unique<RosLanes>(options, topics, pulse,
                                       [this](std::size_t lane, const std::vector<DiagnosticItem>& items) {
                                         if (diagnostics.set(lane, items)) hurry();
                                       });
  }

  const RosOptions options;
  const std::string master_uri;
  std::string node;
  RosDiagnostics diagnostics;
  RosComponents components;
  std::unique_ptr<RosName> name;
  RosPulse pulse;
  std::unique_ptr<RosCallbackThread> callbacks;  // while ROS runs

  std::atomic<bool> stopping{false};
  std::atomic<bool> master_asked{false}, master_present{false};
  std::atomic<bool> master_ended{false};
  std::atomic<bool> ended_clean{true};
  std::atomic<bool> news{false};  // for /diagnostics, not to be held back
  std::atomic<std::uint64_t> foreign_stops{0};
  std::atomic<Clock::time_point> last_foreign_stop{Clock::time_point()};
  std::atomic<bool> ports_are_taken{false};
  std::mutex wake_mutex;
  std::condition_variable wake;
  std::thread master_thread;
  std::unique_ptr<RosLanes> lanes;
  std::optional<RosChange> wanted;  // guarded by wake_mutex

  // When the whole process stood, this thread may be the first one that runs again, and must not take the
  // others for dead.
  std::atomic<Clock::time_point> awake_since{Clock::now()};

  // Belongs to the master thread.
  Clock::time_point last_round = Clock::now();
  bool running = false;
  bool registered = false;
  int master_pid = 0;
  std::uint32_t service_port = 0;
  std::optional<Clock::time_point> standing_back_since;
  bool noticed = false;  // that the master does not answer
  Clock::time_point next_notice = Clock::now();
  Clock::time_point next_diagnostics = Clock::now();

  void hurry() {
    {
      const std::lock_guard lock(wake_mutex);
      news = true;
    }
    wake.notify_all();
  }
  void run_master() {
    MasterClient master(*parse_server_uri(master_uri), node);
    while (!stopping) {
      look_after(master);
      std::unique_lock lock(wake_mutex);
      // A node that was shut down from outside is back soon.
      const auto is_urgent = [this] {
        return stopping || news || wanted || lanes->has_retired() || (running && !ros::ok());
      };
      for (auto waited = milliseconds(0); waited < master_period && !is_urgent(); waited += look_period) {
        pulse.tick(RosPulse::master);
        wake.wait_for(lock, look_period, is_urgent);
      }
    }
    shut_down(master);
    master_ended = true;
  }
  /// Makes the lanes of a wanted change.
  void begin_change() {
    std::unique_lock lock(wake_mutex);
    const std::optional<RosChange> change = std::exchange(wanted, std::nullopt);
    lock.unlock();
    if (!change) return;
    const RosLanes::Pair fresh = lanes->begin_change({change->topics, change->clouds});
    components.replace(change->components, running);
    change->ready(*fresh[0], *fresh[1]);
  }
  /// The lanes of a change are used: those before it are not.
  void end_change() {
    if (!lanes->has_retired()) return;
    const RosPulse::Call call(pulse);
    lanes->end_retired(!master_present);
  }
  /// What has to wait for the master.
  void register_changes() {
    components.register_changes(*callbacks);
    for (const auto& lane : lanes->current()) lane->publishers().advertise_missing();
  }
  void look_after(MasterClient& master) {
    const Clock::time_point now = Clock::now();
    pulse.tick(RosPulse::master);
    if (now - std::exchange(last_round, now) > longest_round) awake_since = now;
    begin_change();
    end_change();
    if (running && !ros::ok()) restart_after_foreign_stop(master);
    // News do not wait for the master's answer.
    if (running && news.exchange(false)) publish_diagnostics();
    const auto pid = master.pid();
    master_asked = true;
    pulse.tick(RosPulse::master);
    if (stopping) return;
    if (pid) {
      master_answered(master, *pid);
    } else {
      master_silent(master);
    }
    if (news.exchange(false) && running) next_diagnostics = Clock::now();
    if (running && Clock::now() >= next_diagnostics) publish_diagnostics();
  }
  void master_answered(MasterClient& master, int pid) {
    const RosPulse::Call call(pulse);
    master_present = true;
    noticed = false;
    const bool another = pid != master_pid;
    master_pid = pid;
    if (!running) {
      if (!name->is_free(master) || stands_back()) return;
      start_ros();
      log_info("ROS master found at {}; publishing as {}", master_uri, node);
    } else if (ros::isShuttingDown()) {
      return;  // from outside; roscpp waits for the master on its way
    } else if (another || !registered) {
      registered = register_again(master, components.master_restarted(), service_port);
      if (registered) log_warn("ROS master at {} came back; all topics are registered again", master_uri);
    }
    register_changes();
    components.for_each(*callbacks, [&](RosComponent& component) {
      if (stopping) return;
      component.poll(master);
      const auto stale = component.stale_topics();
      for (const auto& lane : lanes->current()) lane->publishers().advertise_again(stale);
    });
  }
  /// Whoever has the ports registers first.
  bool stands_back() {
    if (!ports_are_taken) return false;
    const auto now = Clock::now();
    if (!standing_back_since) standing_back_since = now;
    return now - *standing_back_since < longest_standing_back;
  }
  void master_silent(const MasterClient& master) {
    standing_back_since.reset();
    master_present = false;
    registered = false;
    if (noticed || Clock::now() < next_notice) return;
    noticed = true;
    next_notice = Clock::now() + std::chrono::minutes(1);
    log_warn("no ROS master at {} ({}): {}; start one with `roscore`, or set ROS_MASTER_URI", master_uri,
             master.error(),
             running ? "new subscribers cannot find us" : "data is received but not published");
  }
  void start_ros() {
    name->answer_others();
    ros::master::setRetryTimeout(ros::WallDuration(0.2));
    ros::start();
    service_port = ros::ConnectionManager::instance()->getTCPPort();
    for (const auto& lane : lanes->all()) lane->publishers().advertise();
    diagnostics.start();
    callbacks = std::make_unique<RosCallbackThread>(pulse);
    components.connected(*callbacks);
    pulse.attach();
    name->taken();
    running = true;
    registered = true;
  }
  void end_ros(bool leave) {
    const RosPulse::Call call(pulse);
    pulse.detach();
    callbacks->stop();
    components.disconnected();
    if (leave) leave_behind(std::move(callbacks));
    callbacks.reset();
    diagnostics.drop(leave);
    for (const auto& lane : lanes->all()) lane->publishers().drop(leave);
    if (!leave) ros::shutdown();
    running = false;
  }
  void restart_after_foreign_stop(MasterClient& master) {
    const RosPulse::Call call(pulse);
    ++foreign_stops;
    last_foreign_stop = Clock::now();
    log_error(
        "our ROS node {} was shut down from outside (a node of the same name, or rosnode kill); starting "
        "again",
        node);
    end_ros(false);
    const auto pause = [this](Span length) {
      std::unique_lock lock(wake_mutex);
      wake.wait_for(lock, length, [this] { return stopping.load(); });
    };
    pause(name->thrown_out());
    pause(name->after_thrown_out(master));
  }
  void publish_diagnostics() {
    next_diagnostics = Clock::now() + std::chrono::seconds(1);
    components.ask();
    diagnostics.publish(own_items(wall_clock() - lanes->step()), awake_since);
  }
  /// What is told beside the sensor threads' items.
  std::vector<DiagnosticItem> own_items(Stamp now) const {
    std::vector<DiagnosticItem> items{own_status()};
    for (const auto& lane : lanes->current()) lane->add_diagnostics(items, now);
    for (auto& item : components.told()) items.push_back(std::move(item));
    return items;
  }
  DiagnosticItem own_status() const {
    DiagnosticItem item{"ROS"};
    judge_own_status(item);
    item.values = {{"Frames published", std::to_string(lanes->published())},
                   {"Frames dropped", std::to_string(lanes->dropped())},
                   {"Frames before the master came", std::to_string(lanes->without_ros())},
                   {"Subscribers", std::to_string(lanes->subscribers())}};
    item.logged = true;
    return item;
  }
  void judge_own_status(DiagnosticItem& item) const {
    const Span awake = Clock::now() - awake_since.load();
    const Span stands = std::min<Span>(awake, std::max(pulse.since_tick(RosPulse::publishing),
                                                       pulse.since_tick(RosPulse::publishing_clouds)));
    const Span calls = std::min<Span>(awake, pulse.since_tick(RosPulse::master));
    if (stands > longest_round) {
      item.set(Health::error,
               fmt::format("the thread that publishes has stood still for {:.1f} s", seconds(stands)));
    } else if (calls > longest_call) {
      item.set(Health::error,
               fmt::format("the thread that talks to the ROS master has stood still for {:.1f} "
                           "s; check roscore",
                           seconds(calls)));
    } else if (!master_asked) {
      item.message = "asking the master";
    } else if (!master_present) {
      item.set(Health::warn, "the master does not answer; check roscore");
    } else if (foreign_stops > 0 && Clock::now() - last_foreign_stop.load() < news_of_a_stop) {
      item.set(Health::warn, "shut down from outside; look for a node of the same name");
    } else {
      item.message = "publishing";
    }
  }
  void shut_down(MasterClient& master) {
    if (!running) return;
    const bool leave = !master.pid().has_value();
    ended_clean = !leave;
    end_ros(leave);
  }
};

RosConnection::RosConnection(RosOptions options, const std::vector<OutputTopic>& topics,
                             const std::vector<OutputTopic>& clouds)
    : impl_(std::make_shared<Impl>(std::move(options), RosLanes::Topics{topics, clouds})) {}
RosConnection::~RosConnection() { stop(); }

void RosConnection::add(std::shared_ptr<RosComponent> component) {
  impl_->components.add(std::move(component));
}

void RosConnection::start() {
  for (const auto& lane : impl_->lanes->current()) lane->start();
  impl_->master_thread = std::thread([impl = impl_] { impl->run_master(); });
}

FrameSink& RosConnection::sink(Lane lane) { return impl_->lanes->of(lane); }

std::string RosConnection::node() const { return impl_->node; }

std::vector<DiagnosticItem> RosConnection::diagnostics(Stamp now) const { return impl_->own_items(now); }

TopicFigures RosConnection::figures(Lane lane, const OutputTopic& topic, Stamp now) const {
  return impl_->lanes->of(lane).figures(topic.id, now);
}

void RosConnection::set_step(Span step) { impl_->lanes->set_step(step); }

void RosConnection::change(RosChange change) {
  {
    const std::lock_guard lock(impl_->wake_mutex);
    impl_->wanted = std::move(change);
  }
  impl_->wake.notify_all();
}

void RosConnection::finish_change() {
  impl_->lanes->finish_change();
  impl_->wake.notify_all();
}

void RosConnection::publish_clock(Stamp now) { impl_->lanes->current().front()->queue().push_clock(now); }

bool RosConnection::wait_for_master(Span limit) {
  return wait_until([this] { return impl_->lanes->is_ready(); }, limit);
}

bool RosConnection::wait_for_subscribers(std::size_t count, Span limit) {
  return wait_until([&] { return impl_->lanes->subscribers() >= count; }, limit);
}

bool RosConnection::flush(Span limit) {
  const bool sent = wait_until(
      [this] { return impl_->lanes->sum([](RosLane& lane) { return lane.in_flight(); }) == 0; }, limit);
  // A subscriber drops what it has not read yet when the master tells it that we are gone.
  if (impl_->lanes->subscribers() > 0) std::this_thread::sleep_for(milliseconds(250));
  return sent;
}

RosStatus RosConnection::status() const {
  RosStatus status;
  status.master = impl_->master_present;
  status.connected = impl_->lanes->is_ready();
  status.subscribers = impl_->lanes->subscribers();
  status.published = impl_->lanes->published();
  status.dropped = impl_->lanes->dropped();
  status.without_ros = impl_->lanes->without_ros();
  status.foreign_stops = impl_->foreign_stops;
  return status;
}

bool RosConnection::has_master() const { return impl_->master_present; }
std::string RosConnection::standing_threads() { return impl_->pulse.standing(impl_->master_present); }
std::string RosConnection::conflict() const { return impl_->name->conflict(); }
void RosConnection::stand_back(bool ports_are_taken) { impl_->ports_are_taken = ports_are_taken; }

bool RosConnection::stop() {
  if (!impl_->master_thread.joinable()) return impl_->ended_clean;
  {
    const std::lock_guard lock(impl_->wake_mutex);
    impl_->stopping = true;
  }
  impl_->wake.notify_all();
  for (const auto& lane : impl_->lanes->all()) lane->stop();
  if (wait_until([this] { return impl_->master_ended.load(); }, std::chrono::seconds(1))) {
    impl_->master_thread.join();
  } else {
    impl_->master_thread.detach();
    impl_->ended_clean = false;
  }
  return impl_->ended_clean;
}

}  // namespace lidard
