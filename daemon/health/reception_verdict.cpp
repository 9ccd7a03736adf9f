// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/reception_verdict.h"

#include <fmt/format.h>

#include <algorithm>

namespace lidard {
namespace {

constexpr double judged_after_s = 2;
constexpr std::uint64_t least_looked = 10;

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

std::string rejected_text(const Counters& counters) {
  std::string reasons;
  for (std::size_t i = 1; i < reject_reasons; ++i) {
    if (counters.rejected[i] == 0) continue;
    reasons += std::string(reasons.empty() ? " (" : ", ") + to_string(static_cast<Reject>(i)) + " " +
               std::to_string(counters.rejected[i]);
  }
  return std::to_string(counters.rejected_total()) + (reasons.empty() ? "" : reasons + ")");
}

}  // namespace lidard
