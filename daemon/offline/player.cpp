// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/player.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <utility>

#include "core/base/number_text.h"
#include "daemon/log/log.h"
#include "daemon/offline/progress.h"
#include "drivers/capture/tcp_reassembler.h"
#include "drivers/net/wall_clock.h"

namespace lidard {

Player::Player(const PlayOptions& options, MergedCapture& capture, Pipeline& pipeline)
    : rest([](auto until) { std::this_thread::sleep_until(until); }),
      options_(options),
      capture_(capture),
      pipeline_(pipeline) {}

std::chrono::steady_clock::time_point Player::due(Stamp stamp) const {
  const std::chrono::duration<double> since(seconds(stamp - begin_) / options_.rate);
  return wall_begin_ + std::chrono::duration_cast<std::chrono::nanoseconds>(since);
}

Stamp Player::now() const {
  if (options_.rate <= 0) return last_;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - wall_begin_;
  return std::clamp(begin_ + span_from_seconds(since.count() * options_.rate), last_, std::max(last_, next_));
}

/// Waits until `stamp`. Runs the pipeline's events before at their times.
bool Player::wait_for(Stamp stamp, const std::function<bool()>& stop) {
  next_ = stamp;
  rest({});
  while (options_.rate > 0 && !stop()) {
    const auto event = pipeline_.next_event();
    const bool has_event = event && *event < stamp;
    const auto until = due(has_event ? *event : stamp);
    const auto now = std::chrono::steady_clock::now();
    if (now < until) {
      // In short steps, to react to a stop during a long silence.
      rest(std::min(until, now + std::chrono::milliseconds(100)));
    } else if (has_event) {
      show_time(*event);
      pipeline_.advance(*event);
    } else {
      return true;
    }
  }
  return !stop();
}

bool Player::next(Packet& packet) {
  at_hand_.reset();
  if (held_.empty()) return capture_.next(packet);
  at_hand_.emplace(std::move(held_.front()));
  held_.pop_front();
  packet = at_hand_->packet;
  return true;
}

const Packet* Player::peek(std::size_t skipped) {
  for (Packet packet; held_.size() <= skipped; held_.emplace_back(packet)) {
    if (!capture_.next(packet)) return nullptr;
  }
  return &held_[skipped].packet;
}

bool Player::is_stray(Packet& packet, Span step) {
  constexpr std::size_t most_held = 10'000;
  // Reading ahead invalidates a packet that the capture holds.
  if (!at_hand_) packet.payload = at_hand_.emplace(packet).packet.payload;
  for (std::size_t skipped = 0; skipped < most_held; ++skipped) {
    const Packet* const later = peek(skipped);
    if (later == nullptr) break;
    const Span since = later->arrival - round_.hidden - packet.arrival;
    // Half, so that a clock that was set back by just over the limit is not taken for its former self.
    if (std::chrono::abs(since) >= restart_limit / 2)
      return std::chrono::abs(since + step) < std::chrono::abs(since);
  }
  // No later packet shows it. It is one if a clock is known that is as far away.
  return std::chrono::abs(step - round_.stray) < restart_limit;
}

bool Player::follow_clock(Packet& packet) {
  constexpr Span longest_silence = std::chrono::minutes(1);
  // A chunk of a connection may have waited behind a hole.
  const Span set_back =
      restart_limit + (packet.transport == Transport::tcp ? TcpReassembler::patience : Span(0));
  packet.arrival = packet.arrival - round_.hidden;
  const Span step = packet.arrival - round_.newest;
  const bool is_near = step > -set_back && step < restart_limit;
  const bool is_other = !is_near && is_stray(packet, step);
  const bool was_set = !is_near && !is_other && (step < Span(0) || step >= longest_silence);
  if (is_other) {
    if (std::chrono::abs(step - round_.stray) >= restart_limit) round_.stray = step;
    packet.arrival = packet.arrival - round_.stray;
  } else if (was_set) {
    log_warn("after {:.1f} s the capture's clock goes {} by {:.1f} s; the replay does not wait for it",
             played_s(), step > Span(0) ? "ahead" : "back", std::abs(seconds(step)));
    if (options_.loop || options_.restamp) {
      round_.hidden += step;
      packet.arrival = round_.newest;
    } else {
      for (Stamp* const moved : {&begin_, &last_, &round_.begin, &round_.newest}) *moved = *moved + step;
    }
  }
  round_.newest = std::max(round_.newest, packet.arrival);
  return !was_set;
}

void Player::show_time(Stamp stamp) {
  last_ = std::max(last_, stamp);
  if (on_time) on_time(last_);
}

bool Player::step(const std::function<bool()>& stop) {
  Packet packet;
  if (!next(packet)) return false;
  if (!std::exchange(round_.is_read, true)) round_.begin = round_.newest = packet.arrival;
  const bool waits = follow_clock(packet);
  const double into = seconds(packet.arrival - round_.begin);
  if (!round_.is_played && into < options_.start) {
    ++skipped_;
    return true;
  }
  round_.is_played = true;
  if (options_.duration >= 0 && into >= options_.start + options_.duration) return false;
  if (!started_ && options_.restamp)
    loop_shift_ = restamp_shift_ = ClockStep().steady(wall_clock()) - packet.arrival;
  packet.arrival = packet.arrival + loop_shift_;
  if (!started_) {
    started_ = true;
    begin_ = first_ = last_ = packet.arrival;
    wall_begin_ = std::chrono::steady_clock::now();
  }
  const Stamp at = pipeline_.time_of(packet);
  const double made = seconds(at - packet.arrival);
  if (options_.duration >= 0 && into + made >= options_.start + options_.duration) return false;
  // The time that a clock was set ahead by has no events.
  if (waits && !wait_for(at, stop)) return false;
  show_time(at);
  pipeline_.packet(packet);
  pipeline_.tick(at);
  return true;
}

bool Player::play_once(const std::function<bool()>& stop) {
  Progress progress;
  const double played_before = played_s();
  round_ = {};
  while (step(stop)) {
    if (!progress.is_due()) continue;
    std::uint64_t frames = 0;
    std::uint64_t lost = 0;
    for (const auto& sensor : pipeline_.status(pipeline_.now()).sensors)
      frames += sensor.counters.frames, lost += sensor.counters.lost_packets;
    const double elapsed = progress.elapsed();
    progress.show(capture_.progress(),
                  printed("%.1f s  %.1f x  %llu frames  %llu lost", played_s(),
                          elapsed > 0 ? (played_s() - played_before) / elapsed : 0,
                          static_cast<unsigned long long>(frames), static_cast<unsigned long long>(lost)));
  }
  progress.clear();
  return started_;
}

std::string Player::why_nothing() const {
  if (started_ || skipped_ == 0) return {};
  return printed("--start %g: the capture ends before, after %.1f s", options_.start,
                 seconds(round_.newest - round_.begin));
}

void Player::play(const std::function<bool()>& stop) {
  bool more = play_once(stop);
  while (more && options_.loop && !stop()) {
    pipeline_.finish(last_);
    pipeline_.restart();
    capture_.rewind();
    held_.clear();
    // first_ is that of the first round, so the shift grows by one round per repetition.
    loop_shift_ = restamp_shift_ + (last_ - first_) + options_.loop_gap;
    more = play_once(stop);
  }
  finish();
}

void Player::play(TimedMessages& messages, const std::function<bool()>& stop) {
  const std::optional<Stamp> first = messages.next();
  if (!first) return;
  const Stamp from = *first + span_from_seconds(options_.start);
  messages.feed(nullptr, from - Span(1));
  if (!messages.next()) throw std::runtime_error(printed("--start %g: the bag ends before", options_.start));
  begin_ = first_ = last_ = from;
  wall_begin_ = std::chrono::steady_clock::now();
  for (auto at = messages.next(); at; at = messages.next()) {
    if (options_.duration >= 0 && seconds(*at - from) >= options_.duration) break;
    if (!wait_for(*at, stop)) break;
    show_time(*at);
    messages.feed(&pipeline_, *at);
    pipeline_.tick(*at);
  }
  pipeline_.finish(last_);
}

}  // namespace lidard
