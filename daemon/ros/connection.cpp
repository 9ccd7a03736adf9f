// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/connection.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <fmt/format.h>
#include <ros/connection_manager.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>

#include <algorithm>

#include "daemon/health/sentences.h"
#include "daemon/live/thread_priority.h"
#include "daemon/log/log.h"
#include "daemon/ros/master/master_client.h"
#include "daemon/ros/messages/convert.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

using std::chrono::milliseconds;

/// Period of the requests to the master.
constexpr auto master_period = milliseconds(500);
constexpr auto round_period = milliseconds(100);
/// A shutdown from outside is reported for so long.
constexpr auto news_of_a_stop = std::chrono::seconds(60);
/// A live thread makes ten rounds per second.
constexpr auto longest_round = std::chrono::seconds(2);
/// Advertising all topics may last so long with a busy master.
constexpr auto longest_call = std::chrono::seconds(5);

/// Returns the name of the node.
std::string initialised(const RosOptions& options) {
  init_ros(options);
  return ros::this_node::getName();
}

}  // namespace

RosConnection::RosConnection(const RosOptions& options, const std::vector<OutputTopic>& topics)
    : options_(options),
      master_uri_(choose_master(options.remappings)),
      node_(initialised(options)),
      name_(node_, master_uri_),
      publisher_(options, watch_, [this](std::size_t sink, const auto& items) { accept_items(sink, items); }),
      sink_(publisher_.add_sink()) {
  check_ros_names(topics);
  sink_.set_topics(topics);
}

RosConnection::~RosConnection() {
  stop();
  if (master_thread_.joinable()) master_thread_.join();
}

void RosConnection::add(Component component, Component former) {
  const std::lock_guard lock(mutex_);
  changes_.emplace_back(std::move(former), std::move(component));
}

void RosConnection::start() {
  publisher_.start();
  master_thread_ = std::thread([this] { run_master(); });
}

bool RosConnection::wait_for_master(Span limit) {
  wait_until([this] { return publisher_.ready() || !conflict().empty(); }, limit);
  return publisher_.ready();
}

bool RosConnection::flush(Span limit) {
  const bool sent = wait_until([this] { return publisher_.in_flight() == 0; }, limit);
  // A subscriber drops unread messages when the master reports that this node is gone.
  if (publisher_.subscribers() > 0) std::this_thread::sleep_for(milliseconds(250));
  return sent;
}

bool RosConnection::stop() {
  if (!master_thread_.joinable()) return ended_clean_;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  publisher_.stop();
  if (!wait_until([this] { return master_ended_.load(); }, std::chrono::seconds(1))) return false;
  master_thread_.join();
  return ended_clean_;
}

void RosConnection::accept_items(std::size_t sink, const std::vector<DiagnosticItem>& items) {
  {
    const std::lock_guard lock(mutex_);
    newest_.resize(std::max(newest_.size(), sink + 1));
    Newest& newest = newest_[sink];
    const bool same = std::equal(items.begin(), items.end(), newest.items.begin(), newest.items.end(),
                                 [](const auto& a, const auto& b) { return a.health == b.health; });
    newest = {items, Clock::now()};
    if (same) return;
    news_ = true;
  }
  wake_.notify_all();
}

std::vector<DiagnosticItem> RosConnection::diagnostics(Stamp now) {
  std::unique_lock lock(mutex_);
  std::vector<DiagnosticItem> items;
  for (const Newest& newest : newest_) items = joined(items, newest.items);
  lock.unlock();
  for (DiagnosticItem& item : own_items(now)) items.push_back(std::move(item));
  return items;
}

/// Items beside those of the sinks.
std::vector<DiagnosticItem> RosConnection::own_items(Stamp now) {
  std::vector<DiagnosticItem> items{own_status()};
  publisher_.add_diagnostics(items, now);
  const std::lock_guard lock(mutex_);
  items.insert(items.end(), component_items_.begin(), component_items_.end());
  return items;
}

DiagnosticItem RosConnection::own_status() const {
  DiagnosticItem item{"ROS"};
  judge_own_status(item);
  item.add("Frames published", publisher_.published());
  item.add("Frames dropped", publisher_.dropped());
  item.add("Frames before the master came", publisher_.without_ros());
  item.add("Subscribers", publisher_.subscribers());
  item.logged = true;
  return item;
}

void RosConnection::judge_own_status(DiagnosticItem& item) const {
  const Span awake = Clock::now() - awake_since_.load();
  const Span stands = std::min<Span>(awake, watch_.since_tick(ThreadWatch::publishing));
  const Span calls = std::min<Span>(awake, watch_.since_tick(ThreadWatch::master));
  if (stands > longest_round) {
    item.set<says::publisher_hangs>(seconds(stands));
  } else if (calls > longest_call) {
    item.set<says::master_call_hangs>(seconds(calls));
  } else if (name_.lacks_files()) {
    item.set<says::too_many_files>();
  } else if (!master_asked_) {
    item.set<says::master_asked>();
  } else if (!master_present_) {
    item.set<says::master_silent>();
  } else if (lacks_threads_) {
    item.set<says::no_thread>();
  } else if (foreign_stops_ > 0 && Clock::now() - last_foreign_stop_.load() < news_of_a_stop) {
    item.set<says::shut_down>();
  } else {
    item.set<says::publishing>();
  }
}

void RosConnection::run_master() {
  MasterClient master(*parse_server_uri(master_uri_), node_);
  while (!stopping_) {
    do_round(master);
    std::unique_lock lock(mutex_);
    // A node that was shut down from outside comes back soon.
    const auto is_urgent = [this] { return stopping_ || news_ || (running_ && !ros::ok()); };
    const auto end = Clock::now() + master_period;
    while (Clock::now() < end && !is_urgent()) {
      watch_.tick(ThreadWatch::master);
      wake_.wait_for(lock, round_period, is_urgent);
    }
  }
  if (running_) {
    const bool leave = !master.pid().has_value();
    ended_clean_ = !leave;
    end_ros(leave);
  }
  master_ended_ = true;
}

void RosConnection::do_round(MasterClient& master) {
  const Clock::time_point now = Clock::now();
  watch_.tick(ThreadWatch::master);
  if (now - std::exchange(last_round_, now) > longest_round) awake_since_ = now;
  if (!name_.lock()) return;
  if (running_ && !ros::ok()) restart_after_foreign_stop(master);
  // Publish news before the master's answer.
  if (running_ && news_.exchange(false)) publish_diagnostics();
  const auto pid = master.pid();
  master_asked_ = true;
  watch_.tick(ThreadWatch::master);
  if (stopping_) return;
  if (pid) {
    master_answered(master, *pid);
  } else {
    master_silent(master);
  }
  if (news_.exchange(false) && running_) next_diagnostics_ = Clock::now();
  if (running_ && Clock::now() >= next_diagnostics_) publish_diagnostics();
}

void RosConnection::master_answered(MasterClient& master, int pid) {
  const ThreadWatch::Call call(watch_);
  master_present_ = true;
  noticed_ = false;
  const bool another = pid != master_pid_;
  master_pid_ = pid;
  if (!running_) {
    if (!name_.conflict().empty() || !name_.is_free(master)) return;
    if (!start_ros()) return;
    log_info("ROS master found at {}; publishing as {}", master_uri_, node_);
  } else if (ros::isShuttingDown()) {
    return;  // from outside; roscpp waits for the master on its way
  } else if (another || !registered_) {
    register_at(master);
  }
  change_components();
  publisher_.advertise();
  for (const Component& component : components_) {
    if (stopping_) return;
    component->poll(master);
    publisher_.advertise_again(component->stale_topics());
  }
}

void RosConnection::register_at(MasterClient& master) {
  std::vector<std::string> services;
  for (const Component& component : components_) {
    for (auto& service : component->master_restarted()) services.push_back(std::move(service));
  }
  registered_ = register_again(master, services, service_port_);
  if (registered_) log_warn("ROS master at {} came back; all topics are registered again", master_uri_);
}

/// May wait for the master if ROS runs.
void RosConnection::change_components() {
  std::unique_lock lock(mutex_);
  const auto now = std::exchange(changes_, {});
  lock.unlock();
  for (const auto& [former, next] : now) {
    if (former != nullptr && running_) former->disconnect(false);
    components_.erase(std::remove(components_.begin(), components_.end(), former), components_.end());
    components_.push_back(next);
    if (running_) next->connected(*callbacks_);
  }
}

void RosConnection::master_silent(const MasterClient& master) {
  master_present_ = false;
  registered_ = false;
  if (noticed_ || Clock::now() < next_notice_) return;
  noticed_ = true;
  next_notice_ = Clock::now() + std::chrono::minutes(1);
  log_warn("no ROS master at {} ({}): {}; start one with `roscore`, or set ROS_MASTER_URI", master_uri_,
           master.error(),
           running_ ? "new subscribers cannot find us" : "data is received but not published");
}

/// False if there is no thread for it.
bool RosConnection::start_ros() {
  change_components();
  ros::master::setRetryTimeout(ros::WallDuration(0.2));
  try {
    // Its threads inherit the name.
    name_this_thread("roscpp");
    ros::start();
    name_this_thread("lidard-master");
    callbacks_ = std::make_unique<RosCallbackThread>(watch_);
  } catch (const std::runtime_error& error) {  // of std::thread or boost::thread
    name_this_thread("lidard-master");
    if (!lacks_threads_.exchange(true)) log_error("{}: {}", text<says::no_thread>(), error.what());
    ros::shutdown();
    return false;
  }
  lacks_threads_ = false;
  service_port_ = ros::ConnectionManager::instance()->getTCPPort();
  publisher_.advertise();
  diagnostics_ = ros::NodeHandle().advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 1);
  for (const Component& component : components_) component->connected(*callbacks_);
  watch_.set_running(true);
  name_.registered();
  running_ = true;
  registered_ = true;
  return true;
}

/// `leave`: without roscpp's destructors, which wait for the master.
void RosConnection::end_ros(bool leave) {
  const ThreadWatch::Call call(watch_);
  watch_.set_running(false);
  callbacks_->stop();
  for (const Component& component : components_) component->disconnect(leave);
  if (leave) leave_behind(std::move(callbacks_));
  callbacks_.reset();
  if (leave) leave_behind(diagnostics_);
  diagnostics_ = {};
  publisher_.withdraw(leave);
  if (!leave) ros::shutdown();
  running_ = false;
}

void RosConnection::restart_after_foreign_stop(MasterClient& master) {
  const ThreadWatch::Call call(watch_);
  ++foreign_stops_;
  last_foreign_stop_ = Clock::now();
  log_error(
      "our ROS node {} was shut down from outside (a node of the same name, or rosnode kill); starting again",
      node_);
  end_ros(false);
  const Span pause = name_.after_foreign_stop(master);
  std::unique_lock lock(mutex_);
  wake_.wait_for(lock, pause, [this] { return stopping_.load(); });
}

void RosConnection::publish_diagnostics() {
  next_diagnostics_ = Clock::now() + std::chrono::seconds(1);
  std::vector<DiagnosticItem> of_components;
  for (const Component& component : components_) {
    for (auto& item : component->diagnostics()) of_components.push_back(std::move(item));
  }
  std::unique_lock lock(mutex_);
  component_items_ = std::move(of_components);
  std::vector<DiagnosticItem> items;
  for (const Newest& newest : newest_) items = joined(items, aged_items(newest));
  lock.unlock();
  for (DiagnosticItem& item : own_items(options_.clock_step->steady(wall_clock())))
    items.push_back(std::move(item));
  diagnostic_msgs::DiagnosticArray message;
  to_ros(items, node_.substr(1), from_ros(ros::Time::now()), message);
  diagnostics_.publish(message);
}

/// The newest items of a sink; as errors if they are too old, since its thread is dead then.
std::vector<DiagnosticItem> RosConnection::aged_items(const Newest& newest) const {
  std::vector<DiagnosticItem> items = newest.items;
  const Span age = Clock::now() - std::max(newest.at, awake_since_.load());
  if (!options_.longest_report_age || age <= *options_.longest_report_age) return items;
  for (DiagnosticItem& item : items) item.set<says::no_report>(seconds(age), std::string(item.message));
  return items;
}

}  // namespace lidard
