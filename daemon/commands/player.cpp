// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/player.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "core/base/number_text.h"
#include "daemon/commands/progress.h"
#include "daemon/pipeline/log.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

/// Packets whose order was mixed up, or that came after a hole in a connection, are not so old.
constexpr Span set_back = std::chrono::seconds(10);

}  // namespace

Player::Player(const ReplayOptions& options, MergedCapture& capture, Pipeline& pipeline)
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

void Player::follow_clock(Stamp arrival) {
  constexpr Span longest_silence = std::chrono::minutes(1);
  const Span ahead = arrival - last_;
  if (ahead > -set_back && ahead < longest_silence) return;
  log_warn("after {:.1f} s the capture's clock goes {} by {:.1f} s; the replay does not wait for it",
           played_s(), ahead > Span(0) ? "ahead" : "back", std::abs(seconds(ahead)));
  begin_ = begin_ + ahead;
  last_ = arrival;
}

void Player::show_time(Stamp stamp) {
  if (stamp > shown_ || shown_ - stamp > set_back) shown_ = stamp;
  if (on_time) on_time(shown_);
}

bool Player::play_once(const std::function<bool()>& stop) {
  Progress progress;
  const double played_before = played_s();
  Packet packet;
  bool first = true, begun = false;
  Stamp capture_begin{};
  while (capture_.next(packet)) {
    if (first) capture_begin = packet.arrival;
    first = false;
    const double into = seconds(packet.arrival - capture_begin);
    if (!begun && into < options_.start) {
      ++skipped_;
      continue;
    }
    begun = true;
    if (options_.duration >= 0 && into >= options_.start + options_.duration) break;
    if (!started_ && options_.restamp)
      loop_shift_ = restamp_shift_ = ClockStep().steady(wall_clock()) - packet.arrival;
    packet.arrival = packet.arrival + loop_shift_;
    if (!started_) {
      started_ = true;
      begin_ = first_ = last_ = packet.arrival;
      wall_begin_ = std::chrono::steady_clock::now();
    }
    follow_clock(packet.arrival);
    if (!wait_for(packet.arrival, stop)) return false;
    last_ = std::max(last_, packet.arrival);
    show_time(packet.arrival);
    pipeline_.packet(packet);
    pipeline_.tick(packet.arrival);
    if (progress.is_due()) {
      std::uint64_t frames = 0;
      std::uint64_t lost = 0;
      for (const auto& sensor : pipeline_.report())
        frames += sensor.counters.frames, lost += sensor.counters.lost_packets;
      const double elapsed = progress.elapsed();
      progress.show(capture_.progress(),
                    printed("%.1f s  %.1f x  %llu frames  %llu lost", played_s(),
                            elapsed > 0 ? (played_s() - played_before) / elapsed : 0,
                            static_cast<unsigned long long>(frames), static_cast<unsigned long long>(lost)));
    }
  }
  progress.clear();
  return started_;
}

void Player::play(const std::function<bool()>& stop) {
  bool more = play_once(stop);
  while (more && options_.loop && !stop()) {
    pipeline_.finish(last_);
    pipeline_.restart();
    capture_.rewind();
    // first_ is that of the first round, so the shift grows by one round per repetition.
    loop_shift_ = restamp_shift_ + (last_ - first_) + options_.loop_gap;
    more = play_once(stop);
  }
  pipeline_.finish(last_);
}

}  // namespace lidard
