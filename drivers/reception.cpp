// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/reception.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace lidard {
namespace {

/// A longer step is a stall of the program, a jump of the clock or a hole in a capture.
constexpr double longest_step_s = 1;
/// m; a nearer return is a cover or a hand before the window.
constexpr float too_near = 0.3F;
/// No product sends frames more seldom: it turns at a third of its usual rate, or sends every tenth scan.
constexpr double slowest = 10;
/// No product turns eight times as fast (an LMS511 turns four times as fast).
constexpr double fastest = 1.0 / 8;

std::uint64_t less(std::uint64_t now, std::uint64_t before) { return now > before ? now - before : 0; }

Counters less(const Counters& now, const Counters& before) {
  Counters d;
  d.bytes = less(now.bytes, before.bytes);
  const auto subtract = [&](const NamedCounter<Counters>& counter) {
    d.*counter.value = less(now.*counter.value, before.*counter.value);
  };
  std::for_each(std::begin(usual_counters), std::end(usual_counters), subtract);
  std::for_each(std::begin(trouble_counters), std::end(trouble_counters), subtract);
  for (std::size_t i = 0; i < reject_reasons; ++i) d.rejected[i] = less(now.rejected[i], before.rejected[i]);
  return d;
}

}  // namespace

SilenceLimits::SilenceLimits(double period_s)
    : warn_s(std::max(0.8, 2.5 * period_s)), error_s(std::max(2.8, 2.5 * period_s + 2)) {}

SilenceLevel silence_of(Stamp last_arrival, double period_s, Stamp now) {
  const SilenceLimits limits(period_s);
  const double age = seconds(now - last_arrival);
  return age > limits.error_s  ? SilenceLevel::lasting
         : age > limits.warn_s ? SilenceLevel::brief
                               : SilenceLevel::none;
}

ReceptionWatch::ReceptionWatch(double promised_s) : promised_s_(promised_s) { total_.period_s = promised_s; }

void ReceptionWatch::scan(const PlanarScan& scan) {
  ++total_.frames_looked;
  total_.beams += scan.beams;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const BeamStatus status = scan.statuses[i];
    const bool near = status == BeamStatus::hit && scan.ranges[i] < too_near;
    const bool blind = near || status == BeamStatus::near || status == BeamStatus::invalid;
    total_.blind += blind ? 1U : 0U;
    total_.returns += status == BeamStatus::hit && !near ? 1U : 0U;
  }
  learn(scan.stamp, static_cast<double>(scan.scan_time));
}

void ReceptionWatch::cloud(const Cloud& cloud) {
  // One point in 64 is enough.
  constexpr std::size_t step = 64;
  std::uint64_t near = 0, looked = 0;
  const CloudPoint* const points = cloud.points();
  for (std::size_t i = 0; i < cloud.size(); i += step, ++looked) {
    const CloudPoint p = points[i];
    near += p.x * p.x + p.y * p.y + p.z * p.z < too_near * too_near ? 1U : 0U;
  }
  const std::uint64_t size = cloud.size();
  const std::uint64_t blind = looked == 0 ? 0 : size * near / looked;
  ++total_.frames_looked;
  total_.beams += cloud.columns.size() * cloud.rings;
  total_.returns += size - blind;
  total_.blind += blind;
  learn(cloud.stamp, seconds(cloud.end - cloud.stamp));
}

/// No frame follows the one before faster than it is measured: stamps of scans that a busy computer reads in
/// bursts may lie together.
void ReceptionWatch::learn(Stamp stamp, double lasts_s) {
  distances_[distance_count_++ % distances] = seconds(stamp - last_stamp_);
  last_stamp_ = stamp;
  const double measured = median_distance();
  const double learned = measured > 0 ? std::max(measured, 0.98 * lasts_s) : 0;
  // Stamps of frames that arrive in a burst are not usable.
  period_s_ = learned < fastest * promised_s_ ? 0 : std::min(learned, slowest * promised_s_);
}

/// 0 while too few distances are known. The first one is invalid.
double ReceptionWatch::median_distance() const {
  if (distance_count_ <= distances / 2) return 0;
  const std::size_t count = std::min(distance_count_, distances);
  std::array<double, distances> sorted = distances_;
  const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(count);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(sorted.begin(), middle, end);
  return std::max(0.0, *middle);
}

void ReceptionWatch::sender(const IpAddress& address) {
  if (address == total_.senders[0]) return;
  total_.senders[1] = std::exchange(total_.senders[0], address);
  ++total_.sender_changes;
}

void ReceptionWatch::add_time(double passed_s, bool packets_came, std::uint64_t frames) {
  idle_s_ = packets_came ? 0 : idle_s_ + passed_s;
  total_.watched_s += passed_s;
  // SilenceLevel is judged separately from packets without frames.
  if (idle_s_ < longest_step_s) total_.without_frame_s += passed_s;
  if (frames > 0) total_.without_frame_s = 0;
  if (period_s_ <= 0) return;
  if (total_.frames_s > 0) total_.frames += static_cast<double>(frames);
  total_.period_s = period_s_;
  total_.frames_s += passed_s;
  total_.expected += passed_s / period_s_;
}

void ReceptionWatch::advance(Stamp now, const Counters& counters) {
  if (!begun_ && counters.packets == 0) return;
  const double step = begun_ ? seconds(now - last_) : 0;
  const double passed_s = step > 0 && step <= longest_step_s ? step : 0;
  // An arrival slightly before the last time is not a jump.
  if (step >= 0 || step < -longest_step_s) last_ = now;
  const bool packets_came = counters.packets != total_.counters.packets;
  const std::uint64_t frames = less(counters.frames, total_.counters.frames);
  total_.counters = counters;
  add_time(passed_s, packets_came, frames);
  // A silence that was reported as ERROR is not reported again as a loss: drivers count its losses with the
  // first complete frame.
  const bool is_silent = idle_s_ >= SilenceLimits(total_.period_s).error_s;
  settles_s_ = is_silent ? std::max(0.3, 3 * total_.period_s) : settles_s_ - passed_s;
  if (!begun_ || settles_s_ > 0) restart();
  begun_ = true;
  if (total_.watched_s - marks_[(mark_count_ - 1) % marks].watched_s < 1) return;
  mark();
}

void ReceptionWatch::restart() {
  mark_count_ = 0;
  total_.without_frame_s = 0;
  mark();
}

void ReceptionWatch::mark() { marks_[mark_count_++ % marks] = total_; }

Reception ReceptionWatch::since(const Reception& begin) const {
  Reception r = total_;
  r.counters = less(total_.counters, begin.counters);
  r.watched_s -= begin.watched_s;
  r.frames_s -= begin.frames_s;
  r.frames -= begin.frames;
  r.expected -= begin.expected;
  r.frames_looked -= begin.frames_looked;
  r.beams -= begin.beams;
  r.returns -= begin.returns;
  r.blind -= begin.blind;
  r.sender_changes -= begin.sender_changes;
  return r;
}

Reception ReceptionWatch::recent() const {
  if (mark_count_ == 0) return total_;
  return since(mark_count_ < marks ? marks_[0] : marks_[mark_count_ % marks]);
}

Reception ReceptionWatch::whole() const {
  Reception r = total_;
  if (r.counters.frames > 0) r.without_frame_s = 0;
  return r;
}

}  // namespace lidard
