// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/connection.h"

#include <fmt/format.h>
#include <ros/connection_manager.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/this_node.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <thread>
#include <utility>

#include "daemon/pipeline/log.h"
#include "daemon/ros/in/component.h"
#include "daemon/ros/master/node_name.h"
#include "daemon/ros/out/diagnostics_publisher.h"
#include "daemon/ros/out/publisher_thread.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// Period of the requests to the master.
constexpr auto master_period = milliseconds(500);
constexpr auto round_period = milliseconds(100);
/// A shutdown from outside is reported for so long.
constexpr auto news_of_a_stop = std::chrono::seconds(60);
/// A live thread makes ten rounds per second.
constexpr auto longest_round = std::chrono::seconds(2);
/// Advertising all topics may last so long with a busy master.
constexpr auto longest_call = std::chrono::seconds(5);

}  // namespace

// Shared with the threads: one that hangs in roscpp at the end outlives the RosConnection.
struct RosConnection::Impl {
  using Pointer = std::shared_ptr<RosComponent>;

  Impl(RosOptions given, const std::vector<OutputTopic>& topics)
      : options(std::move(given)),
        master_uri(choose_master(options.remappings)),
        diagnostics(options.longest_report_age) {
    init_ros(options);
    node = ros::this_node::getName();
    name = std::make_unique<NodeName>(node, master_uri);
    check_ros_names(topics);
    for (const Worker worker : {Worker::sensors, Worker::clouds}) {
      auto& publisher = publisher_of(worker);
      publisher =
          std::make_unique<PublisherThread>(options, watch, worker, [this, worker](const auto& items) {
            if (diagnostics.set(worker, items)) hurry();
          });
      publisher->set_topics(topics);
    }
  }

  const RosOptions options;
  const std::string master_uri;
  std::string node;
  DiagnosticsPublisher diagnostics;
  std::unique_ptr<NodeName> name;
  ThreadWatch watch;
  std::array<std::unique_ptr<PublisherThread>, workers> publishers;

  std::atomic<bool> stopping{false};
  std::atomic<bool> master_asked{false}, master_present{false};
  std::atomic<bool> master_ended{false};
  std::atomic<bool> ended_clean{true};
  std::atomic<bool> news{false};  // for /diagnostics, to be published at once
  std::atomic<std::uint64_t> foreign_stops{0};
  std::atomic<Clock::time_point> last_foreign_stop{Clock::time_point()};
  mutable std::mutex wake_mutex;
  std::condition_variable wake;
  std::thread master_thread;
  std::vector<std::pair<Pointer, Pointer>> changes;  // former and next component; guarded by wake_mutex
  std::vector<DiagnosticItem> component_items;       // guarded by wake_mutex

  // After a stall of the process this thread may run first, and must not report the others as dead.
  std::atomic<Clock::time_point> awake_since{Clock::now()};

  // Belongs to the master thread.
  std::vector<Pointer> components;
  std::unique_ptr<RosCallbackThread> callbacks;  // while ROS runs
  Clock::time_point last_round = Clock::now();
  bool running = false;
  bool registered = false;
  int master_pid = 0;
  std::uint32_t service_port = 0;
  bool noticed = false;  // that the master does not answer
  Clock::time_point next_notice = Clock::now();
  Clock::time_point next_diagnostics = Clock::now();

  std::unique_ptr<PublisherThread>& publisher_of(Worker worker) {
    return publishers[static_cast<std::size_t>(worker)];
  }
  template <class Figure>
  std::size_t sum(Figure figure) const {
    return figure(*publishers[0]) + figure(*publishers[1]);
  }
  bool is_ready() const { return publishers[0]->ready() && publishers[1]->ready(); }
  std::size_t subscribers() const {
    return sum([](PublisherThread& one) { return one.subscribers(); });
  }
  void hurry() {
    {
      const std::lock_guard lock(wake_mutex);
      news = true;
    }
    wake.notify_all();
  }
  void pause(Span length) {
    std::unique_lock lock(wake_mutex);
    wake.wait_for(lock, length, [this] { return stopping.load(); });
  }
  void run_master() {
    MasterClient master(*parse_server_uri(master_uri), node);
    while (!stopping) {
      do_round(master);
      std::unique_lock lock(wake_mutex);
      // A node that was shut down from outside comes back soon.
      const auto is_urgent = [this] { return stopping || news || (running && !ros::ok()); };
      for (auto waited = milliseconds(0); waited < master_period && !is_urgent(); waited += round_period) {
        watch.tick(ThreadWatch::master);
        wake.wait_for(lock, round_period, is_urgent);
      }
    }
    if (running) {
      const bool leave = !master.pid().has_value();
      ended_clean = !leave;
      end_ros(leave);
    }
    master_ended = true;
  }
  void do_round(MasterClient& master) {
    const Clock::time_point now = Clock::now();
    watch.tick(ThreadWatch::master);
    if (now - std::exchange(last_round, now) > longest_round) awake_since = now;
    if (!name->lock()) return;
    if (running && !ros::ok()) restart_after_foreign_stop(master);
    // Publish news before the master's answer.
    if (running && news.exchange(false)) publish_diagnostics();
    const auto pid = master.pid();
    master_asked = true;
    watch.tick(ThreadWatch::master);
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
    const ThreadWatch::Call call(watch);
    master_present = true;
    noticed = false;
    const bool another = pid != master_pid;
    master_pid = pid;
    if (!running) {
      if (!name->conflict().empty() || !name->is_free(master)) return;
      start_ros();
      log_info("ROS master found at {}; publishing as {}", master_uri, node);
    } else if (ros::isShuttingDown()) {
      return;  // from outside; roscpp waits for the master on its way
    } else if (another || !registered) {
      register_at(master);
    }
    change_components();
    for (const auto& one : publishers) one->advertise();
    for (const Pointer& component : components) {
      if (stopping) return;
      component->poll(master);
      const auto stale = component->stale_topics();
      for (const auto& one : publishers) one->advertise_again(stale);
    }
  }
  void register_at(MasterClient& master) {
    std::vector<std::string> services;
    for (const Pointer& component : components) {
      for (auto& service : component->master_restarted()) services.push_back(std::move(service));
    }
    registered = register_again(master, services, service_port);
    if (registered) log_warn("ROS master at {} came back; all topics are registered again", master_uri);
  }
  /// May wait for the master if ROS runs.
  void change_components() {
    std::unique_lock lock(wake_mutex);
    const auto now = std::exchange(changes, {});
    lock.unlock();
    for (const auto& [former, next] : now) {
      if (former != nullptr && running) former->disconnect(false);
      components.erase(std::remove(components.begin(), components.end(), former), components.end());
      components.push_back(next);
      if (running) next->connected(*callbacks);
    }
  }
  void master_silent(const MasterClient& master) {
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
    change_components();
    ros::master::setRetryTimeout(ros::WallDuration(0.2));
    ros::start();
    service_port = ros::ConnectionManager::instance()->getTCPPort();
    for (const auto& one : publishers) one->advertise();
    diagnostics.start();
    callbacks = std::make_unique<RosCallbackThread>(watch);
    for (const Pointer& component : components) component->connected(*callbacks);
    watch.attach();
    name->registered();
    running = true;
    registered = true;
  }
  void end_ros(bool leave) {
    const ThreadWatch::Call call(watch);
    watch.detach();
    callbacks->stop();
    for (const Pointer& component : components) component->disconnect(leave);
    if (leave) leave_behind(std::move(callbacks));
    callbacks.reset();
    diagnostics.stop(leave);
    for (const auto& one : publishers) one->withdraw(leave);
    if (!leave) ros::shutdown();
    running = false;
  }
  void restart_after_foreign_stop(MasterClient& master) {
    const ThreadWatch::Call call(watch);
    ++foreign_stops;
    last_foreign_stop = Clock::now();
    log_error(
        "our ROS node {} was shut down from outside (a node of the same name, or rosnode kill); starting "
        "again",
        node);
    end_ros(false);
    pause(name->after_foreign_stop(master));
  }
  void publish_diagnostics() {
    next_diagnostics = Clock::now() + std::chrono::seconds(1);
    std::vector<DiagnosticItem> items;
    for (const Pointer& component : components) {
      for (auto& item : component->diagnostics()) items.push_back(std::move(item));
    }
    {
      const std::lock_guard lock(wake_mutex);
      component_items = std::move(items);
    }
    diagnostics.publish(own_items(options.clock_step->steady(wall_clock())), awake_since);
  }
  /// Items beside those of the sensor threads.
  std::vector<DiagnosticItem> own_items(Stamp now) const {
    std::vector<DiagnosticItem> items{own_status()};
    for (const auto& one : publishers) one->add_diagnostics(items, now);
    const std::lock_guard lock(wake_mutex);
    items.insert(items.end(), component_items.begin(), component_items.end());
    return items;
  }
  RosStatus status() const {
    RosStatus status;
    status.master = master_present;
    status.connected = is_ready();
    status.subscribers = subscribers();
    status.published = sum([](PublisherThread& one) { return one.published(); });
    status.dropped = sum([](PublisherThread& one) { return one.dropped(); });
    status.without_ros = sum([](PublisherThread& one) { return one.without_ros(); });
    status.foreign_stops = foreign_stops;
    return status;
  }
  DiagnosticItem own_status() const {
    DiagnosticItem item{"ROS"};
    judge_own_status(item);
    const RosStatus now = status();
    item.add("Frames published", now.published);
    item.add("Frames dropped", now.dropped);
    item.add("Frames before the master came", now.without_ros);
    item.add("Subscribers", now.subscribers);
    item.logged = true;
    return item;
  }
  void judge_own_status(DiagnosticItem& item) const {
    const Span awake = Clock::now() - awake_since.load();
    const Span stands = std::min<Span>(awake, std::max(watch.since_tick(ThreadWatch::publishing),
                                                       watch.since_tick(ThreadWatch::publishing_clouds)));
    const Span calls = std::min<Span>(awake, watch.since_tick(ThreadWatch::master));
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
};

RosConnection::RosConnection(RosOptions options, const std::vector<OutputTopic>& topics)
    : impl_(std::make_shared<Impl>(std::move(options), topics)) {}
RosConnection::~RosConnection() { stop(); }

void RosConnection::add(std::shared_ptr<RosComponent> component, std::shared_ptr<RosComponent> former) {
  const std::lock_guard lock(impl_->wake_mutex);
  impl_->changes.emplace_back(std::move(former), std::move(component));
}

void RosConnection::start() {
  for (const auto& one : impl_->publishers) one->start();
  impl_->master_thread = std::thread([impl = impl_] { impl->run_master(); });
}

FrameSink& RosConnection::sink(Worker worker) { return *impl_->publisher_of(worker); }

void RosConnection::set_topics(Worker worker, const std::vector<OutputTopic>& topics) {
  impl_->publisher_of(worker)->set_topics(topics);
}

void RosConnection::publish_clock(Stamp now) { impl_->publishers[0]->publish_clock(now); }

bool RosConnection::wait_for_master(Span limit) {
  wait_until([this] { return impl_->is_ready() || !conflict().empty(); }, limit);
  return impl_->is_ready();
}

bool RosConnection::wait_for_subscribers(std::size_t count, Span limit) {
  return wait_until([&] { return impl_->subscribers() >= count; }, limit);
}

bool RosConnection::flush(Span limit) {
  const bool sent = wait_until(
      [this] { return impl_->sum([](PublisherThread& one) { return one.in_flight(); }) == 0; }, limit);
  // A subscriber drops unread messages when the master reports that this node is gone.
  if (impl_->subscribers() > 0) std::this_thread::sleep_for(milliseconds(250));
  return sent;
}

std::string RosConnection::node() const { return impl_->node; }

RosStatus RosConnection::status() const { return impl_->status(); }

TopicFigures RosConnection::figures(const OutputTopic& topic, Stamp now) const {
  return impl_->publisher_of(topic.worker)->figures(topic.name, now);
}

std::vector<DiagnosticItem> RosConnection::diagnostics(Stamp now) const {
  std::vector<DiagnosticItem> items = impl_->diagnostics.items();
  for (DiagnosticItem& item : impl_->own_items(now)) items.push_back(std::move(item));
  return items;
}
bool RosConnection::has_master() const { return impl_->master_present; }
std::string RosConnection::standing_threads() { return impl_->watch.standing(impl_->master_present); }
std::string RosConnection::conflict() const { return impl_->name->conflict(); }

bool RosConnection::stop() {
  if (!impl_->master_thread.joinable()) return impl_->ended_clean;
  {
    const std::lock_guard lock(impl_->wake_mutex);
    impl_->stopping = true;
  }
  impl_->wake.notify_all();
  for (const auto& one : impl_->publishers) one->stop();
  if (wait_until([this] { return impl_->master_ended.load(); }, std::chrono::seconds(1))) {
    impl_->master_thread.join();
  } else {
    impl_->master_thread.detach();
    impl_->ended_clean = false;
  }
  return impl_->ended_clean;
}

}  // namespace lidard
