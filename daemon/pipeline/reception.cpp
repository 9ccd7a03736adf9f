// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/reception.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "daemon/pipeline/report.h"

namespace lidard {
namespace {

/// A longer step is a stall of the program, a jump of the clock or a hole in a capture.
constexpr double longest_step_s = 1;
constexpr double judged_after_s = 2;
constexpr std::uint64_t least_looked = 10;
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

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

std::string percent(double part) { return fmt::format(part < 0.0995 ? "{:.1f} %" : "{:.0f} %", 100 * part); }

/// Collects faults; the worst one decides.
class Findings {
 public:
  void add(Health health, const std::string& figure, const char* remedy) {
    if (!figure.empty()) verdict_.figures += (verdict_.figures.empty() ? "" : ", ") + figure;
    if (health == Health::ok) return;
    if (verdict_.remedy.empty() || health > verdict_.health) verdict_.remedy = remedy;
    verdict_.health = std::max(verdict_.health, health);
  }
  ReceptionVerdict verdict() const { return verdict_.health == Health::ok ? ReceptionVerdict() : verdict_; }

 private:
  ReceptionVerdict verdict_;
};

Health level(double value, double warn, double error) {
  return value >= error ? Health::error : value >= warn ? Health::warn : Health::ok;
}

constexpr const char* check_network = "check the cable, the switch and the load of this computer";
constexpr const char* check_path = "look for a proxy, a mirror port or a loop between sensor and computer";
constexpr const char* check_sensor = "check the sensor's state and settings, and the load of this computer";
constexpr const char* check_model = "is it the configured model, and the only one that sends here?";
constexpr const char* check_window = "is its window covered? An empty field looks the same";

bool has_rate(const Reception& r) { return r.expected > 0 && r.frames_s >= judged_after_s; }

/// Share of missing frames, beyond the one that a window may miss.
double missing_frames(const Reception& r) {
  return has_rate(r) ? std::max(0.0, (r.expected - 1 - r.frames) / r.expected) : 0;
}

std::string rate_text(const Reception& r) {
  return fmt::format("{:.1f} of {:.1f} frames/s", r.frames / r.frames_s, r.expected / r.frames_s);
}

void judge_frames(const Reception& r, FrameKind kind, Findings& findings) {
  const double missing = missing_frames(r);
  Health health = level(missing, 0.1, 0.5);
  if (kind == FrameKind::scan && r.lost() >= 2) health = level(missing, 0.01, 0.05);
  const bool loss = r.lost() >= 2;
  if (has_rate(r) && (health != Health::ok || loss))
    findings.add(health, rate_text(r), loss ? check_network : check_sensor);
}

void judge_losses(const Reception& r, FrameKind kind, Findings& findings) {
  const std::uint64_t lost = r.lost();
  if (lost < 2) return;
  const double part = share(lost, r.counters.packets + lost);
  findings.add(level(part, 0.01, 0.05),
               kind == FrameKind::cloud ? percent(part) + " of packets lost"
                                        : fmt::format("{} packets or scans lost", lost),
               check_network);
}

void judge_rejects(const Reception& r, Findings& findings) {
  const std::uint64_t repeated = r.counters.rejected[static_cast<std::size_t>(Reject::duplicate)];
  const double twice = share(repeated, r.counters.packets);
  if (twice >= 0.1) findings.add(Health::warn, percent(twice) + " of packets came twice", check_path);
  const std::uint64_t rejected = r.counters.rejected_total() - repeated;
  const double part = share(rejected, r.counters.packets);
  const Health health = level(part, 0.01, 0.99);
  if (rejected >= 2 && health != Health::ok)
    findings.add(health, percent(part) + " of packets rejected: " + rejected_text(r.counters), check_model);
}

void judge_beams(const Reception& r, FrameKind kind, Findings& findings) {
  if (r.frames_looked < least_looked || r.beams == 0) return;
  const bool cloud = kind == FrameKind::cloud;
  const std::uint64_t seen = r.returns + r.blind;
  const double returned = share(cloud ? seen : r.returns, r.beams);
  const double blind = share(r.blind, cloud ? seen : r.beams);
  if (cloud ? returned < 0.01 : r.returns == 0 && blind < 0.95)
    findings.add(Health::warn, percent(returned) + " of the beams with a return", check_window);
  else if (blind >= 0.95)
    findings.add(Health::warn, percent(blind) + " of the beams blind (too near or invalid)", check_window);
}

}  // namespace

SilenceLimits::SilenceLimits(double period_s)
    : warn_s(std::max(0.8, 2.5 * period_s)), error_s(std::max(2.8, 2.5 * period_s + 2)) {}

ReceptionVerdict judge(const Reception& r, FrameKind kind) {
  Findings findings;
  const double patience = std::max(judged_after_s, 5 * r.period_s);
  if (r.counters.packets > 0 && r.without_frame_s >= patience) {
    const std::string rate = r.period_s > 0 ? fmt::format("0 of {:.1f} frames/s, ", 1 / r.period_s) : "";
    findings.add(Health::error,
                 rate + fmt::format("no frame for {:.1f} s although packets come", r.without_frame_s),
                 check_sensor);
  } else {
    judge_frames(r, kind, findings);
  }
  if (r.watched_s >= judged_after_s) {
    judge_losses(r, kind, findings);
    judge_rejects(r, findings);
  }
  judge_beams(r, kind, findings);
  return findings.verdict();
}

std::string rivals_text(const Reception& r, std::uint16_t port) {
  constexpr std::uint64_t astray = 20;
  if (r.sender_changes < astray || r.sender_changes * 100 < r.counters.packets) return {};
  const auto& [first, second] = std::minmax(r.senders[0], r.senders[1]);
  return fmt::format(
      "{0} and {1} both send to port {2}; one entry takes one sensor: set ip_address: {0} here, "
      "and give each other sensor an entry of its own",
      first.to_string(), second.to_string(), port);
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
  // Silence is judged separately from packets without frames.
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
