// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <poll.h>
#include <ros/ros.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "test/support/ros_master.h"

namespace lidard::test {

/// A roscpp subscriber in a process of its own. It waits for the master by itself and keeps every message
/// until the test takes it. Create it before anything that starts threads.
template <typename Message>
class Listener {
 public:
  explicit Listener(const std::string& topic, std::uint32_t queue_size = 10000) {
    int ends[2];
    if (pipe(ends) != 0) std::abort();
    read_end_ = ends[0];
    const int write_end = ends[1];
    child_ = Child([=] { listen(topic, queue_size, write_end); });
    close(write_end);
  }
  ~Listener() { close(read_end_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  /// The next `count` messages, fewer if they do not come within `limit`.
  std::vector<Message> take(std::size_t count, std::chrono::milliseconds limit = std::chrono::seconds(30)) {
    const auto deadline = std::chrono::steady_clock::now() + limit;
    std::vector<Message> messages;
    while (messages.size() < count) {
      if (unpack(messages)) continue;
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
      pollfd wait{read_end_, POLLIN, 0};
      if (left.count() <= 0 || ::poll(&wait, 1, static_cast<int>(left.count())) <= 0) break;
      char buffer[65536];
      const auto got = read(read_end_, buffer, sizeof buffer);
      if (got <= 0) break;
      bytes_.insert(bytes_.end(), buffer, buffer + got);
    }
    return messages;
  }
  Child& process() { return child_; }

 private:
  /// Moves one message out of the bytes received; each begins with its length, as on the wire.
  bool unpack(std::vector<Message>& messages) {
    std::uint32_t length = 0;
    if (bytes_.size() < sizeof length) return false;
    std::memcpy(&length, bytes_.data(), sizeof length);
    if (bytes_.size() < sizeof length + length) return false;
    ros::serialization::IStream stream(bytes_.data() + sizeof length, length);
    messages.emplace_back();
    ros::serialization::deserialize(stream, messages.back());
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(sizeof length + length));
    return true;
  }

  static void listen(const std::string& topic, std::uint32_t queue_size, int write_end) {
    ros::init(ros::M_string(), "listener", ros::init_options::AnonymousName | ros::init_options::NoRosout);
    std::mutex mutex;
    std::condition_variable filled;
    std::deque<ros::SerializedMessage> waiting;
    std::thread writer([&] {
      for (;;) {
        std::unique_lock lock(mutex);
        filled.wait(lock, [&] { return !waiting.empty(); });
        const auto next = waiting.front();
        waiting.pop_front();
        lock.unlock();
        for (std::size_t done = 0; done < next.num_bytes;) {
          const auto n = write(write_end, next.buf.get() + done, next.num_bytes - done);
          if (n <= 0) _exit(0);
          done += static_cast<std::size_t>(n);
        }
      }
    });
    ros::NodeHandle node;
    const boost::function<void(const boost::shared_ptr<Message const>&)> callback = [&](const auto& message) {
      const std::lock_guard lock(mutex);
      waiting.push_back(ros::serialization::serializeMessage(*message));
      filled.notify_one();
    };
    const auto subscriber = node.subscribe<Message>(topic, queue_size, callback);
    ros::spin();
    _exit(0);
  }

  int read_end_ = -1;
  std::vector<std::uint8_t> bytes_;
  Child child_;
};

}  // namespace lidard::test
