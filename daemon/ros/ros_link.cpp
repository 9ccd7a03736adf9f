// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_link.h"

#include <fmt/format.h>
#include <ros/exceptions.h>
#include <ros/init.h>
#include <ros/master.h>
#include <ros/names.h>
#include <ros/this_node.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <thread>
#include <utility>

#include "daemon/ros/ros_diagnostics.h"
#include "daemon/ros/ros_master.h"
#include "daemon/ros/ros_name.h"
#include "daemon/ros/ros_publishers.h"
#include "daemon/ros/ros_pulse.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// How often the master is asked whether it is there.
constexpr auto master_period = milliseconds(500);
/// Of the 10 messages that roscpp keeps for a slow subscriber; the rest is slack for its own queue.
constexpr std::size_t most_in_flight = 8;
/// After this long a subscriber that takes nothing counts as stuck, and a replay goes on without it.
constexpr auto stuck_subscriber = std::chrono::seconds(10);
/// A live thread makes ten rounds per second.
constexpr auto longest_round = std::chrono::seconds(2);

void init_ros(const RosOptions& options) {
  ros::M_string remappings;
  for (const auto& remapping : options.remappings) {
    const auto at = remapping.find(":=");
    if (at == std::string::npos || at == 0)
      throw RosError("'" + remapping + "' is not a remapping; expected from:=to");
    remappings[remapping.substr(0, at)] = remapping.substr(at + 2);
  }
  choose_ros_log_folder();
  try {
    ros::init(remappings, options.node_name, ros::init_options::NoSigintHandler);
    for (const auto& topic : options.topics) ros::names::resolve(topic.name);
  } catch (const ros::Exception& problem) {
    throw RosError(std::string(problem.what()) + "; expected names of letters, digits, _ and /");
  }
}

template <typename Condition>
bool wait_until(Condition condition, Span limit) {
  const auto deadline = Clock::now() + limit;
  while (!condition()) {
    if (Clock::now() >= deadline) return false;
    std::this_thread::sleep_for(milliseconds(2));
  }
  return true;
}

}  // namespace

// Shared with the threads: one that hangs in roscpp at the end outlives the RosLink.
struct RosLink::Impl {
  explicit Impl(RosOptions given)
      : options(std::move(given)),
        master_uri(choose_master(options.remappings)),
        queue(options.topics, options.backpressure),
        publishers(options.topics, options.clock),
        diagnostics(options.longest_report_age) {
    init_ros(options);
    node = ros::this_node::getName();
    name = std::make_unique<RosName>(node, wall_clock());
  }

  const RosOptions options;
  const std::string master_uri;
  std::string node;
  FrameQueue queue;
  RosPublishers publishers;
  RosDiagnostics diagnostics;
  std::vector<std::shared_ptr<RosClient>> clients;
  std::unique_ptr<RosName> name;
  RosPulse pulse;

  std::atomic<bool> stopping{false};
  std::atomic<bool> master_present{false};
  std::atomic<bool> master_ended{false};
  std::atomic<bool> ended_clean{true};
  std::atomic<bool> news{false};  // for /diagnostics, not to be held back
  std::atomic<std::uint64_t> published{0};
  std::atomic<std::uint64_t> without_ros{0};
  std::atomic<std::uint64_t> foreign_stops{0};
  std::mutex wake_mutex;
  std::condition_variable wake;
  std::thread ros_thread;
  std::thread master_thread;

  // Belongs to the master thread.
  bool running = false;
  bool registered = false;
  int master_pid = 0;
  Clock::time_point next_notice = Clock::now();
  Clock::time_point next_diagnostics = Clock::now();

  void run_ros();
  void deal_with(QueuedFrame& frame);
  void wait_for_subscribers_of(const QueuedFrame& frame);
  void hurry();
  void run_master();
  void look_after(MasterClient& master);
  void master_answered(MasterClient& master, int pid);
  void master_silent(const MasterClient& master);
  void start_ros();
  void end_ros(bool leave);
  void restart_after_foreign_stop(MasterClient& master);
  void publish_diagnostics();
  DiagnosticItem own_status() const;
  void judge_own_status(DiagnosticItem& item) const;
  void shut_down(MasterClient& master);
};

// ---- ROS thread

void RosLink::Impl::run_ros() {
  name_this_thread("lidard-ros");
  while (!stopping) {
    pulse.tick();
    QueuedFrame* frame = queue.pop(milliseconds(100));
    if (frame == nullptr) continue;
    deal_with(*frame);
    queue.done(frame);
  }
}

void RosLink::Impl::deal_with(QueuedFrame& frame) {
  if (options.backpressure == Backpressure::block) wait_for_subscribers_of(frame);
  const bool sent = publishers.publish(frame);
  ++(sent ? published : without_ros);
}

void RosLink::Impl::wait_for_subscribers_of(const QueuedFrame& frame) {
  const auto keeps_up = [&] {
    pulse.tick();
    const bool advertised = publishers.ready() || frame.what == QueuedFrame::What::transforms;
    return stopping || (advertised && publishers.in_flight(frame) < most_in_flight);
  };
  while (!wait_until(keeps_up, stuck_subscriber)) {
    if (!publishers.ready()) continue;
    spdlog::warn("a subscriber has taken nothing for 10 s; it loses messages from here on");
    return;
  }
}

// ---- master thread

void RosLink::Impl::hurry() {
  {
    const std::lock_guard lock(wake_mutex);
    news = true;
  }
  wake.notify_all();
}

void RosLink::Impl::run_master() {
  name_this_thread("lidard-master");
  MasterClient master(*parse_server_uri(master_uri), node);
  while (!stopping) {
    look_after(master);
    std::unique_lock lock(wake_mutex);
    wake.wait_for(lock, master_period, [this] { return stopping || news; });
  }
  shut_down(master);
  master_ended = true;
}

void RosLink::Impl::look_after(MasterClient& master) {
  if (running && !ros::ok()) restart_after_foreign_stop(master);
  // News do not wait for the master's answer.
  if (running && news.exchange(false)) publish_diagnostics();
  const auto pid = master.pid();
  if (stopping) return;
  if (pid) {
    master_answered(master, *pid);
  } else {
    master_silent(master);
  }
  if (news.exchange(false) && running) next_diagnostics = Clock::now();
  if (running && Clock::now() >= next_diagnostics) publish_diagnostics();
}

void RosLink::Impl::master_answered(MasterClient& master, int pid) {
  master_present = true;
  const bool another = pid != master_pid;
  master_pid = pid;
  if (!running) {
    if (!name->is_free(master)) return;
    start_ros();
    spdlog::info("ROS master found at {}; publishing as {}", master_uri, node);
  } else if (another || !registered) {
    registered = register_again(master, publishers.types());
    for (const auto& client : clients) registered &= client->register_again(master);
    if (registered) spdlog::warn("ROS master at {} came back; all topics are registered again", master_uri);
  }
  const RosPulse::Call call(pulse);
  for (const auto& client : clients) {
    if (stopping || !running) return;
    client->poll(master);
    publishers.advertise_again(client->stale_topics());
  }
}

void RosLink::Impl::master_silent(const MasterClient& master) {
  master_present = false;
  registered = false;
  if (Clock::now() < next_notice) return;
  next_notice = Clock::now() + std::chrono::seconds(30);
  spdlog::warn("no ROS master at {} ({}): {}; start one with `roscore`, or set ROS_MASTER_URI", master_uri,
               master.error(),
               running ? "new subscribers cannot find us" : "data is received but not published");
}

void RosLink::Impl::start_ros() {
  const RosPulse::Call call(pulse);
  name->answer_others();
  ros::master::setRetryTimeout(ros::WallDuration(0.2));
  ros::start();
  publishers.advertise();
  diagnostics.start();
  for (const auto& client : clients) client->connected();
  pulse.attach();
  name->taken();
  running = true;
  registered = true;
}

void RosLink::Impl::end_ros(bool leave) {
  const RosPulse::Call call(pulse);
  pulse.detach();
  for (const auto& client : clients) client->disconnected(leave);
  diagnostics.drop(leave);
  publishers.drop(leave);
  if (!leave) ros::shutdown();
  running = false;
}

void RosLink::Impl::restart_after_foreign_stop(MasterClient& master) {
  ++foreign_stops;
  spdlog::error(
      "our ROS node {} was shut down from outside (a node of the same name, or rosnode kill); starting again",
      node);
  end_ros(false);
  const Span pause = name->thrown_out(master);
  std::unique_lock lock(wake_mutex);
  wake.wait_for(lock, pause, [this] { return stopping.load(); });
}

void RosLink::Impl::publish_diagnostics() {
  next_diagnostics = Clock::now() + std::chrono::seconds(1);
  std::vector<DiagnosticItem> more{own_status()};
  for (const auto& client : clients) {
    for (auto& item : client->diagnostics()) more.push_back(std::move(item));
  }
  diagnostics.publish(more);
}

void RosLink::Impl::judge_own_status(DiagnosticItem& item) const {
  const Span stands = pulse.since_tick();
  if (stands > longest_round) {
    item.health = Health::error;
    item.message = fmt::format("the thread that publishes has stood still for {:.1f} s", seconds(stands));
  } else if (!master_present) {
    item.health = Health::warn;
    item.message = "the master does not answer; check roscore";
  } else if (foreign_stops > 0) {
    item.health = Health::warn;
    item.message = "shut down from outside; look for a node of the same name";
  } else {
    item.message = "publishing";
  }
}

DiagnosticItem RosLink::Impl::own_status() const {
  DiagnosticItem item;
  item.name = "ROS";
  judge_own_status(item);
  item.values = {{"Frames published", std::to_string(published)},
                 {"Frames dropped", std::to_string(queue.dropped())},
                 {"Frames before the master came", std::to_string(without_ros)},
                 {"Subscribers", std::to_string(publishers.subscribers())}};
  return item;
}

void RosLink::Impl::shut_down(MasterClient& master) {
  if (!running) return;
  const bool leave = !master.pid().has_value();
  ended_clean = !leave;
  end_ros(leave);
}

// ---- interface

RosLink::RosLink(RosOptions options) : impl_(std::make_shared<Impl>(std::move(options))) {}
RosLink::~RosLink() { stop(); }

void RosLink::add_client(std::shared_ptr<RosClient> client) { impl_->clients.push_back(std::move(client)); }

void RosLink::start() {
  impl_->ros_thread = std::thread([impl = impl_] { impl->run_ros(); });
  impl_->master_thread = std::thread([impl = impl_] { impl->run_master(); });
}

void RosLink::scan(const std::string& topic, const PlanarScan& scan, Stamp released) {
  impl_->queue.push(topic, scan, released);
}
void RosLink::cloud(const std::string& topic, Cloud& cloud, Stamp released) {
  impl_->queue.push(topic, cloud, released);
}
void RosLink::fix(const std::string& topic, const GnssFix& fix, Stamp released) {
  impl_->queue.push(topic, fix, released);
}
void RosLink::time_reference(const std::string& topic, const TimeReference& reference, Stamp released) {
  impl_->queue.push(topic, reference, released);
}
void RosLink::imu(const std::string& topic, const ImuSample& sample, Stamp released) {
  impl_->queue.push(topic, sample, released);
}
void RosLink::state(const std::string& topic, const DeviceState& state, Stamp released) {
  impl_->queue.push(topic, state, released);
}
void RosLink::transforms(const std::vector<StaticTransform>& transforms, Stamp released) {
  impl_->queue.push(transforms, released);
}
void RosLink::diagnostics(const std::vector<DiagnosticItem>& items, Stamp) {
  if (impl_->diagnostics.set(items)) impl_->hurry();
}
void RosLink::publish_clock(Stamp now) { impl_->queue.push_clock(now); }

bool RosLink::wait_for_master(Span limit) {
  return wait_until([this] { return impl_->publishers.ready(); }, limit);
}

bool RosLink::wait_for_subscribers(std::size_t count, Span limit) {
  return wait_until([&] { return impl_->publishers.subscribers() >= count; }, limit);
}

bool RosLink::flush(Span limit) {
  const bool sent =
      wait_until([this] { return impl_->queue.idle() && impl_->publishers.in_flight() == 0; }, limit);
  // A subscriber drops what it has not read yet when the master tells it that we are gone.
  if (impl_->publishers.subscribers() > 0) std::this_thread::sleep_for(milliseconds(250));
  return sent;
}

RosStatus RosLink::status() const {
  RosStatus status;
  status.master = impl_->master_present;
  status.connected = impl_->publishers.ready();
  status.subscribers = impl_->publishers.subscribers();
  status.published = impl_->published;
  status.dropped = impl_->queue.dropped();
  status.without_ros = impl_->without_ros;
  status.foreign_stops = impl_->foreign_stops;
  status.ticks = impl_->pulse.ticks();
  return status;
}

bool RosLink::has_master() const { return impl_->master_present; }
std::string RosLink::standing_threads() { return impl_->pulse.standing(impl_->master_present); }
std::string RosLink::conflict() const { return impl_->name->conflict(); }

bool RosLink::stop() {
  if (!impl_->master_thread.joinable()) return impl_->ended_clean;
  {
    const std::lock_guard lock(impl_->wake_mutex);
    impl_->stopping = true;
  }
  impl_->wake.notify_all();
  impl_->queue.stop();
  impl_->ros_thread.join();
  if (wait_until([this] { return impl_->master_ended.load(); }, std::chrono::seconds(1))) {
    impl_->master_thread.join();
  } else {
    impl_->master_thread.detach();
    impl_->ended_clean = false;
  }
  return impl_->ended_clean;
}

}  // namespace lidard
