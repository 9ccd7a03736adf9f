// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/cloud_worker.h"

#include <utility>

#include "daemon/health/sentences.h"
#include "daemon/live/thread_priority.h"
#include "daemon/live/wait_until.h"

namespace lidard {

CloudWorker::CloudWorker(const Config& part, DaemonClock& clock, BlackBox& box, TransformSource& transforms,
                         DiagnosticSink& sink, SensorLoop& sensors)
    : clock_(clock), sensors_(sensors), loop_(part, clock, box, transforms, sink) {
  loop_.pipeline().set_forward(
      [this](const std::string& source, const PlanarScan& scan, Stamp now) { forward(source, scan, now); });
  set_part(part);
}

void CloudWorker::set_part(const Config& part) {
  forwards_ = !part.elsewhere.merged.empty();
  const std::lock_guard lock(mutex_);
  names_.clear();
  for (const SensorConfig& sensor : part.sensors) names_.insert(sensor.name);
}

void CloudWorker::start(const Config& part) {
  if (thread_.joinable() || part.sensors.empty()) return;
  thread_ = std::thread([this] { run(); });
}

void CloudWorker::run() {
  name_this_thread("lidard-clouds");
  yield_this_thread();
  loop_.run();
  loop_.finish();
  ended_ = true;
}

/// Runs `task` in the thread, then `then` in the sensor thread.
void CloudWorker::in_thread(std::function<void()> task, std::function<void()> then) {
  const auto work = [this, task = std::move(task), then = std::move(then)](Stamp now) {
    task();
    loop_.pipeline().tick(now);
    sensors_.post([then](Stamp) { then(); });
  };
  thread_.joinable() ? loop_.post(work) : work(clock_.now());
}

void CloudWorker::when_done(std::function<void()> then) {
  in_thread([] {}, std::move(then));
}

void CloudWorker::configure(std::shared_ptr<const Division> division, std::function<void()> first,
                            std::function<void()> then) {
  set_part(division->clouds);
  const auto apply = [this, division = std::move(division), first = std::move(first)] {
    first();
    loop_.configure(division->clouds);
  };
  in_thread(apply, std::move(then));
}

bool CloudWorker::post(const std::string& sensor, std::function<void(Pipeline&, Stamp)> task) {
  const std::lock_guard lock(mutex_);
  const bool is_ours = sensor.empty() ? !names_.empty() : names_.count(sensor) > 0;
  if (is_ours)
    loop_.post([this, task = std::move(task)](Stamp received) { task(loop_.pipeline(), received); });
  return is_ours;
}

/// In the thread.
void CloudWorker::forward(const std::string& source, const PlanarScan& scan, Stamp now) {
  constexpr int most_waiting = 100;
  if (waiting_ >= most_waiting) {
    ++dropped_;
    dropped_at_ = now;
    return;
  }
  ++waiting_;
  sensors_.post([this, source, scan](Stamp received) {
    --waiting_;
    sensors_.pipeline().forwarded_scan(source, scan, received);
  });
}

bool CloudWorker::is_stalled() {
  const std::uint64_t rounds = loop_.rounds();
  if (thread_.joinable() && rounds == rounds_) return true;
  rounds_ = rounds;
  return false;
}

void CloudWorker::add_items(std::vector<DiagnosticItem>& items) const {
  if (!forwards_) return;
  DiagnosticItem item{"virtual scans to merge"};
  item.add("Scans dropped", dropped_.load());
  dropped_ > 0 && clock_.now() - dropped_at_.load() < incident_lasts ? item.set<says::scans_dropped>()
                                                                     : item.set<says::all_handed_over>();
  items.push_back(std::move(item));
}

bool CloudWorker::stop() {
  if (!thread_.joinable()) return true;
  loop_.stop();
  const bool ended = wait_until([this] { return ended_.load(); }, std::chrono::seconds(1));
  ended ? thread_.join() : thread_.detach();
  return ended;
}

}  // namespace lidard
