// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/velodyne_http.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "daemon/live/http_client.h"

namespace lidard {
namespace {

using Clock = std::chrono::steady_clock;

/// A setting is written so often until it counts as refused; tried again when the sensor was away meanwhile.
constexpr int most_attempts = 3;

constexpr const char* stopped = "stopped";
constexpr const char* form = "application/x-www-form-urlencoded";

void replace_section(VelodyneTree& tree, const std::string& prefix, const VelodyneTree& section) {
  if (prefix.empty()) {
    tree = section;
    return;
  }
  const auto begin = tree.lower_bound(prefix);
  auto end = begin;
  while (end != tree.end() && end->first.compare(0, prefix.size(), prefix) == 0) ++end;
  tree.erase(begin, end);
  for (const auto& [key, value] : section) tree.emplace(prefix + key, value);
}

}  // namespace

class VelodyneHttp::Worker {
 public:
  Worker(std::string name, const IpAddress& address, const VelodyneControl& control,
         const VelodyneHttpTiming& timing)
      : name_(std::move(name)),
        host_(address.to_string()),
        where_(Endpoint{address, control.port}.to_string()),
        control_(control),
        timing_(timing) {}
  ~Worker() { stop(); }

  void start() {
    if (control_.read && !thread_.joinable()) thread_ = std::thread([this] { run(); });
  }
  void stop() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_all();
    client_.stop();
    if (thread_.joinable()) thread_.join();
  }
  VelodyneHttpState state() const {
    const std::lock_guard lock(mutex_);
    VelodyneHttpState copy = state_;
    copy.settling = wrote_any_ && Clock::now() - last_write_ < timing_.spin_up;
    return copy;
  }

 private:
  void run();
  bool read_all();
  bool read(const char* path, const std::string& prefix);
  bool write_differences();
  bool write(const VelodyneChange& change);
  void save();
  HttpAnswer request(const char* path, const std::string& body, Span limit);
  void fail(const std::string& what);
  bool pause(Span span);

  /// Changes the state that others see.
  template <class Change>
  void update(Change change) {
    const std::lock_guard lock(mutex_);
    change(state_);
  }

  const std::string name_, host_, where_;
  const VelodyneControl control_;
  const VelodyneHttpTiming timing_;
  HttpClient client_;

  // Of the worker's thread alone.
  Clock::time_point next_request_{};
  VelodyneTree tree_;
  bool present_ = true;  // the last connection was taken
  bool snapshot_is_new_ = false;
  std::map<std::string, int> attempts_;  // by request
  bool unverified_ = false;              // something was written and not seen in a snapshot yet

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  VelodyneHttpState state_;
  bool wrote_any_ = false;
  Clock::time_point last_write_{};
  std::thread thread_;
};

void VelodyneHttp::Worker::run() {
  Span retry = timing_.first_retry;
  Span wait{0};
  while (pause(wait)) {
    const bool complete = read_all();
    const bool wrote = snapshot_is_new_ && write_differences();
    if (complete) retry = timing_.first_retry;
    wait = wrote ? timing_.settle : complete ? control_.period : retry;
    if (!complete && !wrote) retry = std::min(2 * retry, timing_.last_retry);
  }
}

/// False if anything was not answered.
bool VelodyneHttp::Worker::read_all() {
  tree_.clear();
  snapshot_is_new_ = read("/cgi/snapshot.hdl", "");
  bool complete = snapshot_is_new_;
  if (present_) complete = read("/cgi/status.json", "status.") && complete;
  if (present_) complete = read("/cgi/diag.json", "diag.") && complete;
  if (!present_) attempts_.clear();  // it may come back with other settings, or be another one
  update([&](VelodyneHttpState& state) {
    state.tree = tree_;
    if (complete) state.trouble.clear();
    state.answered = state.answered || !tree_.empty();
    const auto serial = tree_.find("info.serial");
    if (serial != tree_.end()) state.serial = serial->second;
  });
  return complete;
}

bool VelodyneHttp::Worker::read(const char* path, const std::string& prefix) {
  const HttpAnswer answer = request(path, "", timing_.limit);
  // An answer that ends early or whose length is wrong is good enough if it is all there.
  const auto section = answer.status == 200 ? read_velodyne_json(answer.body) : std::optional<VelodyneTree>();
  if (section) {
    replace_section(tree_, prefix, *section);
    return true;
  }
  if (!answer.connected)
    fail("no web interface at " + where_ + ": " + answer.error + "; check control.port and the network");
  else if (answer.status != 0 && answer.status != 200)
    fail(where_ + path + " answers with HTTP status " + std::to_string(answer.status) +
         "; is this the configured sensor?");
  else if (!answer.error.empty())
    fail(where_ + path + ": " + answer.error + "; the sensor may be busy or restarting");
  else
    fail(where_ + path + " answers with what is no JSON object; is this the configured sensor?");
  return false;
}

/// False if there was nothing (more) to write.
bool VelodyneHttp::Worker::write_differences() {
  if (!control_.allow_write) return false;
  const VelodynePlan todo = plan(tree_, control_.wanted);
  std::vector<std::string> refused;
  bool wrote = false;
  for (const auto& change : todo.changes) {
    if (attempts_[change.path + change.body] >= most_attempts)
      refused.push_back(change.text);
    else
      wrote = write(change) || wrote;
  }
  update([&](VelodyneHttpState& state) {
    state.refused = refused;
    state.unknown = todo.unknown;
  });
  if (!todo.changes.empty() || !unverified_) return wrote;
  spdlog::info("{}: the sensor reports the written settings", name_);
  unverified_ = false;
  attempts_.clear();
  if (control_.save) save();
  return false;
}

bool VelodyneHttp::Worker::write(const VelodyneChange& change) {
  ++attempts_[change.path + change.body];
  const HttpAnswer answer = request(change.path.c_str(), change.body, timing_.limit);
  if (!answer.connected && answer.error == stopped) return false;
  const bool taken = answer.status >= 200 && answer.status <= 206;
  // Without an answer nobody knows whether it was taken; the next snapshot tells.
  unverified_ = unverified_ || answer.connected;
  if (taken)
    spdlog::info("{}: wrote {} to {}", name_, change.text, where_);
  else
    spdlog::warn("{}: could not write {} to {}: {}", name_, change.text, where_,
                 answer.status == 0 ? answer.error : "HTTP status " + std::to_string(answer.status));
  const std::lock_guard lock(mutex_);
  wrote_any_ = true;
  last_write_ = Clock::now();
  ++state_.writes;
  return true;
}

/// POST /cgi/save, UniBwTAS/velodyne: the sensor needs some ten seconds for it (unverified).
void VelodyneHttp::Worker::save() {
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    const HttpAnswer answer = request("/cgi/save", "data=submit", timing_.save_limit);
    const bool taken = answer.status >= 200 && answer.status <= 206;
    if (taken) spdlog::info("{}: the sensor at {} saved its settings", name_, where_);
    if (!pause(timing_.after_save) || taken) return;
  }
  spdlog::warn("{}: the sensor at {} did not save its settings; they are lost when it is switched off", name_,
               where_);
}

/// Waits for its turn first. An empty body: GET.
HttpAnswer VelodyneHttp::Worker::request(const char* path, const std::string& body, Span limit) {
  if (!pause(next_request_ - Clock::now())) {
    HttpAnswer nothing;
    nothing.error = stopped;
    return nothing;
  }
  HttpAnswer answer = client_.request({host_, control_.port, path, body.empty() ? "" : form, body}, limit);
  next_request_ = Clock::now() + timing_.pace;
  present_ = answer.connected;
  update([&](VelodyneHttpState& state) {
    ++state.requests;
    if (answer.connected) state.local_address = answer.local_address;
  });
  return answer;
}

void VelodyneHttp::Worker::fail(const std::string& what) {
  update([&](VelodyneHttpState& state) {
    ++state.failures;
    state.trouble = what;
  });
}

/// False if the worker is to end.
bool VelodyneHttp::Worker::pause(Span span) {
  std::unique_lock lock(mutex_);
  return !wake_.wait_for(lock, std::max(span, Span(0)), [this] { return stopping_; });
}

VelodyneHttp::VelodyneHttp(std::string name, const IpAddress& address, const VelodyneControl& control,
                           const VelodyneHttpTiming& timing)
    : worker_(std::make_unique<Worker>(std::move(name), address, control, timing)) {}
VelodyneHttp::~VelodyneHttp() = default;
void VelodyneHttp::start() { worker_->start(); }
void VelodyneHttp::stop() { worker_->stop(); }
VelodyneHttpState VelodyneHttp::state() const { return worker_->state(); }

}  // namespace lidard
