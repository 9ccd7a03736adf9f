// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/publisher.h>

#include <atomic>
#include <boost/shared_array.hpp>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "daemon/health/diagnostics.h"
#include "daemon/health/topic_watch.h"
#include "daemon/ros/master/environment.h"
#include "daemon/ros/master/thread_watch.h"
#include "daemon/ros/out/message_rows.h"

namespace lidard {

/// Advertises a topic; may wait for the master. `queue_size`: messages kept for a slow subscriber.
/// `on_subscriber` is called by roscpp's thread when a subscriber connects.
ros::Publisher make_publisher(const std::string& topic, const MessageType& type, std::size_t queue_size,
                              bool latched, const ros::SubscriberStatusCallback& on_subscriber = {});

/// Publishes the frames of all sinks: a bounded queue for each topic, its publisher, and a thread that
/// converts and publishes in the order in which the frames came. Live, what has waited for a second makes
/// room for what comes. Frames and their buffers are recycled: no allocation after warm-up.
class PublisherThread {
  struct PublishedTopic;

 public:
  /// `sink`: its number, in the order of add_sink().
  using OnDiagnostics = std::function<void(std::size_t sink, const std::vector<DiagnosticItem>&)>;

  /// What the pipeline of one thread publishes through; all calls come from that thread and never wait,
  /// unless Backpressure::block.
  class Sink final : public DiagnosticSink {
   public:
    Sink(PublisherThread& publisher, std::size_t number) : publisher_(publisher), number_(number) {}

    /// From the next call of publish() on the topics are these, by OutputTopic::id. A topic that stays, also
    /// from another sink, keeps its queue, its figures and its subscribers.
    void set_topics(const std::vector<OutputTopic>& topics);
    /// Swaps the points_bytes of a cloud with a recycled buffer.
    void publish(const OutputTopic& topic, const Frame& frame, Stamp released) override {
      publisher_.push(output_of(topic), frame, released);
    }
    bool wants(const OutputTopic& topic) const override { return publisher_.wants(output_of(topic)); }
    void skip(const OutputTopic& topic, Stamp released) override {
      publisher_.skip(output_of(topic), released);
    }
    void transforms(const std::vector<StaticTransform>& transforms, Stamp released) override {
      publisher_.push(publisher_.tf_, transforms, released);
    }
    void diagnostics(const std::vector<DiagnosticItem>& items, Stamp) override {
      publisher_.on_diagnostics_(number_, items);
    }

   private:
    PublishedTopic& output_of(const OutputTopic& topic) const { return *outputs_[topic.id]; }

    PublisherThread& publisher_;
    const std::size_t number_;
    std::vector<PublishedTopic*> outputs_;  // by OutputTopic::id
  };

  /// `watch` must outlive this.
  PublisherThread(const RosOptions& options, ThreadWatch& watch, OnDiagnostics on_diagnostics);
  ~PublisherThread() { stop(); }

  /// Call it before start().
  Sink& add_sink() { return sinks_.emplace_back(*this, sinks_.size()); }
  void start();
  /// Publishes nothing any more.
  void stop();

  /// The time of a replay, on /clock.
  void publish_clock(Stamp now) { push(clock_, now, now); }

  // For the master thread; these three may wait for the master.
  /// Advertises new topics, and withdraws removed ones.
  void advertise();
  /// Withdraws topics and advertises them anew, so that subscribers see a new publisher. Frames of these
  /// topics are lost meanwhile.
  void advertise_again(const std::vector<std::string>& topics);
  /// Withdraws everything. `leave`: without roscpp's destructors, which wait for the master.
  void withdraw(bool leave);

  // For any thread; roscpp does not block these.
  /// True if the topics are advertised.
  bool ready() const { return ready_; }
  /// Figures of a topic.
  TopicFigures figures(const std::string& topic, Stamp now);
  /// Adds an item for each topic with frames.
  void add_diagnostics(std::vector<DiagnosticItem>& items, Stamp now);
  /// Of all topics of frames, as counted last.
  std::size_t subscribers() const { return subscribers_; }
  std::uint64_t published() const { return published_; }
  std::uint64_t dropped() const { return dropped_; }
  std::uint64_t without_ros() const { return without_ros_; }
  /// Messages that have not reached the sockets of all subscribers. roscpp may block it.
  std::size_t in_flight();

 private:
  /// A frame that waits for the thread; a Stamp is the time of a replay.
  struct Queued {
    PublishedTopic* output = nullptr;
    std::uint64_t number = 0;
    Stamp released{};
    std::variant<PlanarScan, Cloud, MergedCloud, DeviceMessage, std::vector<StaticTransform>, Stamp>
        content{};
    Frame frame() {
      return std::visit([](auto& held) { return Frame(held); }, content);
    }
  };
  struct PublishedTopic {
    PublishedTopic(std::string name, std::unique_ptr<MessageMaker> makes, std::size_t depth);

    ros::Publisher make() const;
    void send(const Frame& frame, Stamp released, const ClockStep& clock);
    std::size_t in_flight();
    bool loses() const;

    const std::string topic;
    const std::unique_ptr<MessageMaker> maker;  // of the publishing thread
    const std::size_t depth;                    // frames that may wait
    const std::size_t
        queue_size;  // messages that roscpp keeps for a slow subscriber before it drops the oldest
    // Shared with roscpp, which may outlive this.
    const std::shared_ptr<std::atomic<bool>> has_subscribers = std::make_shared<std::atomic<bool>>(false);
    const Sink* sink = nullptr;  // that publishes on it; nullptr: this class alone
    std::atomic<bool> wanted{true};
    std::atomic<std::uint64_t> lost{0};  // messages that a subscriber has not got
    std::atomic<std::chrono::steady_clock::time_point> lost_at{std::chrono::steady_clock::time_point()};
    bool latched = false;
    bool is_stuck =
        false;  // of the publishing thread: a subscriber reads nothing, a replay goes on without it
    // Guarded by mutex_:
    std::vector<Queued> frames;
    std::deque<Queued*> waiting;
    std::vector<Queued*> free;
    std::uint64_t dropped = 0;
    TopicWatch watch;
    // Guarded by send_mutex_:
    ros::Publisher publisher;
    std::deque<boost::shared_array<std::uint8_t>> sent;  // buffers that roscpp may still hold
    std::optional<RawMessage> latest;                    // of a latched topic
  };

  void set_topics(const Sink& sink, const std::vector<OutputTopic>& topics,
                  std::vector<PublishedTopic*>& outputs);
  PublishedTopic& add_output(const std::string& topic, std::unique_ptr<MessageMaker> maker,
                             std::size_t depth);
  std::vector<PublishedTopic*> outputs();
  bool wants(const PublishedTopic& output) const { return block_ || *output.has_subscribers; }
  bool must_drop(const PublishedTopic& output, Stamp released) const;
  void push(PublishedTopic& output, const Frame& frame, Stamp released);
  void skip(PublishedTopic& output, Stamp released);
  Queued* pop();
  void give_back(Queued& frame, bool is_published);
  TopicFigures figures_of(const PublishedTopic& output, Stamp now);
  void replace_publisher(PublishedTopic& output, ros::Publisher next, bool leave = false);
  void run();
  bool send(Queued& frame);
  void wait_for_subscribers_of(PublishedTopic& output);
  void count_subscribers();

  const bool block_, with_clock_;
  ThreadWatch& watch_;
  const std::shared_ptr<const ClockStep> clock_step_;
  const OnDiagnostics on_diagnostics_;
  std::mutex mutex_;
  std::condition_variable filled_, emptied_;
  std::deque<PublishedTopic> outputs_;  // guarded by mutex_, which their addresses do not need
  std::uint64_t pushed_ = 0;            // guarded by mutex_
  std::deque<Sink> sinks_;
  PublishedTopic &tf_, &clock_;
  std::mutex send_mutex_;
  std::atomic<bool> ready_{false}, stopping_{false};
  std::atomic<std::size_t> subscribers_{0};
  std::atomic<std::uint64_t> published_{0}, without_ros_{0}, dropped_{0};
  std::thread thread_;
};

}  // namespace lidard
