// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/sensor_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "daemon/health/reception_verdict.h"
#include "daemon/health/sentences.h"
#include "daemon/log/log.h"

namespace lidard {
namespace {

constexpr auto tick_period = std::chrono::milliseconds(100);
/// A timer that fires later shows that this thread got no processor.
constexpr double longest_usual_s = 0.5;

void log_sensor(const SensorStatus& sensor) {
  const Counters& c = sensor.counters;
  log_info("{} ({}): {} packets, {} frames, {} lost, rejected {}", sensor.name, sensor.model, c.packets,
           c.frames, c.lost_packets, rejected_text(c));
}

}  // namespace

SensorLoop::SensorLoop(const Config& config, DaemonClock& clock, BlackBox& box, TransformSource& transforms,
                       DiagnosticSink& sink)
    : clock_(clock),
      box_(box),
      pipeline_(config, transforms, sink),
      reporter_(pipeline_, sink,
                [this](std::vector<DiagnosticItem>& items) {
                  add_items(items);
                  items.push_back(load_item());
                  ports_.add_diagnostics(items);
                  connections_.add_diagnostics(items);
                  host_causes_.add_diagnostics(items);
                }),
      ports_(io_, config, [this](std::vector<Packet>& packets) { handle(packets); }),
      host_causes_(config, ports_),
      connections_(
          io_, config,
          {[this](std::size_t sensor, const Packet& packet) {
             chunk_[0] = packet;
             handle(chunk_, sensor);
           },
           [this](std::size_t sensor, HostStamp at) { pipeline_.connected(sensor, clock_.steady(at)); },
           [this](std::size_t sensor) { pipeline_.disconnected(sensor); },
           [this](std::size_t sensor) { return pipeline_.frames(sensor); },
           [this](std::size_t sensor) { return host_causes_.status(sensor); },
           [this] { return clock_.now(); }}),
      interfaces_(io_,
                  [this] {
                    host_causes_.interfaces_changed();
                    ports_.interfaces_changed();
                    connections_.interfaces_changed();
                  }),
      timer_(io_),
      event_timer_(io_) {
  pipeline_.set_connections(&connections_);
}

void SensorLoop::post(std::function<void(Stamp)> task) {
  boost::asio::post(io_, [this, task = std::move(task), received = clock_.now()] {
    task(received);
    arm();
  });
}

void SensorLoop::run() {
  ports_.start();
  connections_.start();
  if (const int error = interfaces_.start(); error != 0)
    log_warn("{}", text<says::no_interface_news>(std::strerror(error)));
  next_tick_ = std::chrono::steady_clock::now();
  schedule_tick();
  io_.run();
}

void SensorLoop::configure(const Config& config) {
  pipeline_.configure(config);
  ports_.configure(config);
  connections_.configure(config);
  host_causes_.configure(config);
  next_event_.reset();
  arm();
}

void SensorLoop::finish() {
  interfaces_.stop();
  ports_.stop();
  pipeline_.finish(clock_.now());
  connections_.stop();
  for (const SensorStatus& sensor : pipeline_.status(clock_.now()).sensors) log_sensor(sensor);
}

/// Calls on_round if it is due.
void SensorLoop::report_round() {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_round_) return;
  next_round_ = now + tick_period;
  ++rounds_;
  on_round();
}

/// Uses every packet of a batch, or a chunk of the connection of that sensor.
void SensorLoop::handle(std::vector<Packet>& packets, std::optional<std::size_t> connection) {
  report_round();
  clock_.set_arrivals(packets);
  for (const Packet& packet : packets) {
    box_.add(packet);
    connection ? pipeline_.chunk(*connection, packet) : pipeline_.packet(packet);
  }
  arm();
}

/// Calls `then` with the present time after handling all packets that have arrived: a packet that waited
/// while this thread was busy is not late.
template <class Then>
void SensorLoop::catch_up(Then then) {
  // The first posted handler runs before those of sockets that became ready meanwhile, the second one after
  // them. Busy ports are read by catch_up().
  boost::asio::post(io_, [this, then, now = clock_.now()] {
    boost::asio::post(io_, [this, then, now] {
      ports_.catch_up();
      then(now);
    });
  });
}

void SensorLoop::schedule_tick() {
  // Ticks missed while the process was stopped are skipped.
  next_tick_ = std::max(next_tick_ + tick_period, std::chrono::steady_clock::now());
  timer_.expires_at(next_tick_);
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (error) return;
    report_round();
    const auto now = std::chrono::steady_clock::now();
    const double late_s = std::chrono::duration<double>(now - next_tick_).count();
    if (late_s > longest_usual_s) stalled_s_ = late_s, stalled_at_ = now;
    catch_up([this](Stamp at) { tick(at); });
    schedule_tick();
  });
}

DiagnosticItem SensorLoop::load_item() const {
  DiagnosticItem item{"computer"};
  const bool stalled = stalled_at_ && std::chrono::steady_clock::now() - *stalled_at_ < incident_lasts;
  stalled ? item.set<says::too_busy>(stalled_s_) : item.set<says::read_in_time>();
  return item;
}

/// Sets the timer to the pipeline's next event.
void SensorLoop::arm() {
  const auto event = pipeline_.next_event();
  if (!event || event == next_event_) return;
  next_event_ = event;
  event_timer_.expires_after(std::max(Span(0), *event - clock_.now()));
  event_timer_.async_wait([this](const boost::system::error_code& error) {
    if (error) return;
    catch_up([this](Stamp now) {
      next_event_.reset();
      pipeline_.tick(now);
      arm();
    });
  });
}

void SensorLoop::tick(Stamp now) {
  pipeline_.tick(now);
  arm();
  ports_.note_changes();
  host_causes_.watch_addresses();
  on_tick(now);
}

}  // namespace lidard
