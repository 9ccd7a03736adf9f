// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/out/publisher_thread.h"

#include <ros/callback_queue_interface.h>
#include <ros/node_handle.h>
#include <ros/topic_manager.h>

#include <algorithm>
#include <utility>

#include "daemon/health/topic_health.h"
#include "daemon/live/wait_until.h"
#include "daemon/log/log.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

using Clock = std::chrono::steady_clock;

/// Of the 10 messages that roscpp keeps for a slow subscriber; the rest is slack for its own queue.
constexpr std::size_t most_in_flight = 8;
/// Messages that roscpp is sending to slow subscribers beside those in its queues.
constexpr std::size_t most_being_sent = 8;
constexpr std::size_t least_queue = 10;
constexpr std::size_t least_depth = 2;
/// After this long a subscriber that reads nothing counts as stuck, and a replay goes on without it.
constexpr auto stuck_subscriber = std::chrono::seconds(10);
constexpr auto between_counts = std::chrono::milliseconds(100);

bool is_free(const boost::shared_array<std::uint8_t>& buffer) { return buffer.use_count() == 1; }

/// Makes roscpp call back without a queue.
class AtOnce final : public ros::CallbackQueueInterface {
 public:
  void addCallback(const ros::CallbackInterfacePtr& callback, std::uint64_t) override { callback->call(); }
  void removeByID(std::uint64_t) override {}
};

template <class Kept, class Content>
Kept& kept_in(Content& content) {
  Kept* const kept = std::get_if<Kept>(&content);
  return kept != nullptr ? *kept : content.template emplace<Kept>();
}

/// Copies a frame, but swaps the points of a cloud.
template <class Content>
void keep(const Frame& frame, Content& content) {
  const auto keep_one = [&](auto* given) {
    using Kept = std::remove_const_t<std::remove_pointer_t<decltype(given)>>;
    Kept& kept = kept_in<Kept>(content);
    if constexpr (std::is_same_v<Kept, Cloud> || std::is_same_v<Kept, MergedCloud>) {
      kept.frame_id = given->frame_id;
      kept.stamp = given->stamp;
      kept.height = given->height;
      kept.points_bytes.swap(given->points_bytes);
    } else {
      kept = *given;
    }
  };
  std::visit(keep_one, frame);
}

}  // namespace

/// One more frame than may wait: the thread holds one.
PublisherThread::PublishedTopic::PublishedTopic(std::string name, std::unique_ptr<MessageMaker> makes,
                                                std::size_t may_wait)
    : topic(std::move(name)),
      maker(std::move(makes)),
      depth(may_wait),
      queue_size(std::max(least_queue, may_wait)),
      frames(may_wait + 1) {
  for (Queued& frame : frames) {
    frame.output = this;
    free.push_back(&frame);
  }
}

ros::Publisher make_publisher(const std::string& topic, const MessageType& type, std::size_t queue_size,
                              bool latched, const ros::SubscriberStatusCallback& on_subscriber) {
  static auto* const at_once = new AtOnce;  // roscpp uses it to the very end
  ros::AdvertiseOptions options(topic, static_cast<std::uint32_t>(queue_size), type.md5, type.name,
                                type.definition);
  options.has_header = type.begins_with_header;
  options.latch = latched;
  options.connect_cb = on_subscriber;
  options.callback_queue = at_once;
  return ros::NodeHandle().advertise(options);
}

/// The first subscriber gets the next cloud that begins.
ros::Publisher PublisherThread::PublishedTopic::make() const {
  return make_publisher(topic, maker->type(), queue_size, latched,
                        [flag = has_subscribers](const ros::SingleSubscriberPublisher&) { *flag = true; });
}

void PublisherThread::PublishedTopic::send(const Frame& frame, Stamp released, const ClockStep& clock) {
  if (latched) return publisher.publish(*latest);
  if (publisher.getNumSubscribers() == 0) return;
  // ros::Publisher::publish() does just this, but makes the message while roscpp holds the lock of all topics
  // (a cloud would hold up the scans), and hides the buffer, which shows when all sockets have it.
  ros::SerializedMessage serialized = maker->make(frame, released, clock).data;
  ros::TopicManager::instance()->publish(
      publisher.getTopic(), [&] { return serialized; }, serialized);
  // Frees the memory of sent messages: a cloud has 10 MB.
  in_flight();
  if (serialized.buf) sent.push_back(serialized.buf);
  while (sent.size() > queue_size + most_being_sent) sent.pop_front();
}

/// roscpp releases a message before an older one only by dropping it from the full queue of a slow
/// subscriber. The oldest one must be checked last.
std::size_t PublisherThread::PublishedTopic::in_flight() {
  if (sent.size() > 1 && std::any_of(sent.begin() + 1, sent.end(), is_free) && !is_free(sent.front())) {
    const auto kept = std::remove_if(sent.begin() + 1, sent.end(), is_free);
    lost += static_cast<std::uint64_t>(sent.end() - kept);
    lost_at = Clock::now();
    sent.erase(kept, sent.end());
  }
  while (!sent.empty() && is_free(sent.front())) sent.pop_front();
  return sent.size();
}

bool PublisherThread::PublishedTopic::loses() const {
  return lost > 0 && Clock::now() - lost_at.load() < incident_lasts;
}

PublisherThread::PublisherThread(const RosOptions& options, ThreadWatch& watch, OnDiagnostics on_diagnostics)
    : block_(options.backpressure == Backpressure::block),
      with_clock_(options.clock),
      watch_(watch),
      clock_step_(options.clock_step),
      on_diagnostics_(std::move(on_diagnostics)),
      tf_(add_output("/tf_static", transforms_maker(), 2)),
      clock_(add_output("/clock", clock_maker(), 2)) {
  tf_.latched = true;
  clock_.wanted = with_clock_;
}

PublisherThread::PublishedTopic& PublisherThread::add_output(const std::string& topic,
                                                             std::unique_ptr<MessageMaker> maker,
                                                             std::size_t depth) {
  return outputs_.emplace_back(topic, std::move(maker), block_ ? least_depth : depth);
}

void PublisherThread::Sink::set_topics(const std::vector<OutputTopic>& topics) {
  publisher_.set_topics(*this, topics, outputs_);
}

void PublisherThread::set_topics(const Sink& sink, const std::vector<OutputTopic>& topics,
                                 std::vector<PublishedTopic*>& outputs) {
  const std::lock_guard lock(mutex_);
  outputs.clear();
  for (const OutputTopic& topic : topics) {
    const MessageRow& row = row_of(topic);
    auto maker = row.maker();
    const auto same = [&](const PublishedTopic& one) {
      return one.topic == topic.name && one.maker->type().name == maker->type().name;
    };
    const auto known = std::find_if(outputs_.begin(), outputs_.end(), same);
    PublishedTopic& output =
        known != outputs_.end() ? *known : add_output(topic.name, std::move(maker), row.queue_depth);
    output.sink = &sink;
    outputs.push_back(&output);
  }
  // Set once, since advertise() may run at the same time.
  for (PublishedTopic& output : outputs_) {
    if (output.sink == &sink)
      output.wanted = std::find(outputs.begin(), outputs.end(), &output) != outputs.end();
  }
}

std::vector<PublisherThread::PublishedTopic*> PublisherThread::outputs() {
  const std::lock_guard lock(mutex_);
  std::vector<PublishedTopic*> all;
  for (PublishedTopic& output : outputs_) all.push_back(&output);
  return all;
}

/// True if a frame must be dropped to make room.
bool PublisherThread::must_drop(const PublishedTopic& output, Stamp released) const {
  constexpr Span longest_wait = std::chrono::seconds(1);
  const std::size_t waiting = output.waiting.size();
  return !block_ && (waiting >= output.depth ||
                     (waiting >= least_depth && released - output.waiting.front()->released > longest_wait));
}

void PublisherThread::push(PublishedTopic& output, const Frame& frame, Stamp released) {
  std::unique_lock lock(mutex_);
  if (block_) emptied_.wait(lock, [&] { return stopping_ || output.waiting.size() < output.depth; });
  if (stopping_) return;
  while (must_drop(output, released)) {
    output.free.push_back(output.waiting.front());
    output.waiting.pop_front();
    ++output.dropped, ++dropped_;
  }
  Queued* const queued = output.free.back();
  output.free.pop_back();
  queued->number = ++pushed_;
  queued->released = released;
  output.watch.released(released);
  keep(frame, queued->content);
  output.waiting.push_back(queued);
  lock.unlock();
  filled_.notify_one();
}

void PublisherThread::skip(PublishedTopic& output, Stamp released) {
  ++(ready_ ? published_ : without_ros_);
  const std::lock_guard lock(mutex_);
  output.watch.released(released);
}

/// The oldest frame; nullptr if none came for a while, or after stop().
PublisherThread::Queued* PublisherThread::pop() {
  std::unique_lock lock(mutex_);
  PublishedTopic* oldest = nullptr;
  filled_.wait_for(lock, between_counts, [&] {
    for (PublishedTopic& one : outputs_) {
      if (one.waiting.empty()) continue;
      if (oldest == nullptr || one.waiting.front()->number < oldest->waiting.front()->number) oldest = &one;
    }
    return stopping_ || oldest != nullptr;
  });
  if (stopping_ || oldest == nullptr) return nullptr;
  Queued* const frame = oldest->waiting.front();
  oldest->waiting.pop_front();
  lock.unlock();
  emptied_.notify_all();
  return frame;
}

void PublisherThread::give_back(Queued& frame, bool is_published) {
  const Span latency = clock_step_->steady(wall_clock()) - frame.released;
  const std::lock_guard lock(mutex_);
  if (is_published) frame.output->watch.published(latency);
  frame.output->free.push_back(&frame);
}

void PublisherThread::start() {
  thread_ = std::thread([this] { run(); });
}

void PublisherThread::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  filled_.notify_all();
  emptied_.notify_all();
  if (thread_.joinable()) thread_.join();
}

/// roscpp is called without the mutex: the last copy of a publisher waits for the master.
void PublisherThread::replace_publisher(PublishedTopic& output, ros::Publisher next, bool leave) {
  {
    const std::lock_guard lock(send_mutex_);
    std::swap(output.publisher, next);
    if (!output.publisher) output.sent.clear();
    if (output.publisher && output.latest) output.publisher.publish(*output.latest);
  }
  if (leave) leave_behind(next);
}

void PublisherThread::advertise() {
  for (PublishedTopic* const output : outputs()) {
    if (output->wanted && !output->publisher) {
      replace_publisher(*output, output->make());
    } else if (!output->wanted && output->publisher) {
      replace_publisher(*output, {});
      // The memory of clouds.
      const std::lock_guard lock(mutex_);
      for (Queued* const frame : output->free) frame->content = {};
    }
  }
  ready_ = true;
}

void PublisherThread::advertise_again(const std::vector<std::string>& topics) {
  for (PublishedTopic* const output : outputs()) {
    if (!output->publisher || std::find(topics.begin(), topics.end(), output->topic) == topics.end())
      continue;
    replace_publisher(*output, {});
    replace_publisher(*output, output->make());
  }
}

void PublisherThread::withdraw(bool leave) {
  ready_ = false;
  for (PublishedTopic* const output : outputs()) replace_publisher(*output, {}, leave);
}

TopicFigures PublisherThread::figures_of(const PublishedTopic& output, Stamp now) {
  std::unique_lock lock(mutex_);
  // A replay releases frames at the times of the capture.
  TopicFigures figures = output.watch.figures(block_ ? output.watch.newest() : now);
  figures.dropped = output.dropped;
  lock.unlock();
  figures.lost = output.lost;
  figures.loses = output.loses();
  return figures;
}

TopicFigures PublisherThread::figures(const std::string& topic, Stamp now) {
  for (const PublishedTopic* const output : outputs()) {
    if (output->topic == topic && output->wanted) return figures_of(*output, now);
  }
  return {};
}

void PublisherThread::add_diagnostics(std::vector<DiagnosticItem>& items, Stamp now) {
  for (const PublishedTopic* const output : outputs()) {
    if (!output->wanted || output == &tf_ || output == &clock_) continue;
    const TopicFigures figures = figures_of(*output, now);
    if (figures.frames > 0) items.push_back(topic_health(output->topic, figures));
  }
}

std::size_t PublisherThread::in_flight() {
  std::size_t sum = 0;
  for (PublishedTopic* const output : outputs()) {
    const std::scoped_lock lock(mutex_, send_mutex_);
    sum += output->frames.size() - output->free.size() + output->in_flight();
  }
  return sum;
}

void PublisherThread::count_subscribers() {
  std::size_t sum = 0;
  for (PublishedTopic* const output : outputs()) {
    const std::lock_guard lock(send_mutex_);
    const std::size_t count = output->publisher.getNumSubscribers();
    *output->has_subscribers = count > 0;
    if (output != &tf_ && output != &clock_) sum += count;
  }
  subscribers_ = sum;
}

void PublisherThread::run() {
  auto counted = Clock::now();
  while (!stopping_) {
    watch_.tick(ThreadWatch::publishing);
    Queued* const frame = pop();
    if (const auto now = Clock::now(); now - counted >= between_counts) {
      count_subscribers();
      counted = now;
    }
    if (frame == nullptr) continue;
    if (block_) wait_for_subscribers_of(*frame->output);
    const bool is_sent = send(*frame);
    ++(is_sent ? published_ : without_ros_);
    give_back(*frame, is_sent);
  }
}

/// Converts and publishes; false if nothing is advertised.
bool PublisherThread::send(Queued& frame) {
  PublishedTopic& output = *frame.output;
  const std::lock_guard lock(send_mutex_);
  if (output.latched) output.latest = output.maker->make(frame.frame(), frame.released, *clock_step_);
  if (!ready_ || !ros::ok() || !output.publisher) return false;
  output.send(frame.frame(), frame.released, *clock_step_);
  return true;
}

void PublisherThread::wait_for_subscribers_of(PublishedTopic& output) {
  const auto keeps_up = [&] {
    watch_.tick(ThreadWatch::publishing);
    const std::lock_guard lock(send_mutex_);
    return stopping_ || ((ready_ || output.latched) && output.in_flight() < most_in_flight);
  };
  if (output.is_stuck && !keeps_up()) return;
  output.is_stuck = false;
  while (!wait_until(keeps_up, stuck_subscriber)) {
    if (!ready_) continue;
    log_warn("a subscriber of {} has read nothing for 10 s; it loses messages until it reads again",
             output.topic);
    output.is_stuck = true;
    return;
  }
}

}  // namespace lidard
