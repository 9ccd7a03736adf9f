// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/reception_verdict.h"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/health/counted.h"
#include "daemon/health/sentences.h"

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
  template <const Sentence& sentence, class... Figures>
  void add(Health health, const Figures&... figures) {
    verdict_.figures += (verdict_.figures.empty() ? "" : ", ") + fact<sentence>(figures...);
    if (health == Health::ok) return;
    if (verdict_.remedy.empty() || health > verdict_.health) verdict_.remedy = sentence.remedy;
    verdict_.health = std::max(verdict_.health, health);
  }
  ReceptionVerdict verdict() const { return verdict_.health == Health::ok ? ReceptionVerdict() : verdict_; }

 private:
  ReceptionVerdict verdict_;
};

Health level(double value, double warn, double error) {
  return value >= error ? Health::error : value >= warn ? Health::warn : Health::ok;
}

bool has_rate(const Reception& r) { return r.expected > 0 && r.frames_s >= judged_after_s; }

/// Share of missing frames, beyond the one that a window may miss.
double missing_frames(const Reception& r) {
  return has_rate(r) ? std::max(0.0, (r.expected - 1 - r.frames) / r.expected) : 0;
}

void judge_frames(const Reception& r, FrameKind kind, Findings& findings) {
  if (!has_rate(r)) return;
  const double missing = missing_frames(r), rate = r.frames / r.frames_s, expected = r.expected / r.frames_s;
  if (r.lost() >= 2)
    findings.add<says::frames_lost>(
        kind == FrameKind::scan ? level(missing, 0.01, 0.05) : level(missing, 0.1, 0.5), rate, expected);
  else if (const Health health = level(missing, 0.1, 0.5); health != Health::ok)
    findings.add<says::frames_missing>(health, rate, expected);
}

void judge_losses(const Reception& r, FrameKind kind, Findings& findings) {
  const std::uint64_t lost = r.lost();
  if (lost < 2) return;
  const double part = share(lost, r.counters.packets + lost);
  const Health health = level(part, 0.01, 0.05);
  kind == FrameKind::cloud ? findings.add<says::packets_lost>(health, percent(part))
                           : findings.add<says::scans_lost>(health, lost);
}

void judge_rejects(const Reception& r, Findings& findings) {
  const std::uint64_t repeated = r.counters.rejected[static_cast<std::size_t>(Reject::duplicate)];
  const double twice = share(repeated, r.counters.packets);
  if (twice >= 0.1) findings.add<says::packets_twice>(Health::warn, percent(twice));
  const std::uint64_t rejected = r.counters.rejected_total() - repeated;
  const double part = share(rejected, r.counters.packets);
  const Health health = level(part, 0.01, 0.99);
  if (rejected >= 2 && health != Health::ok)
    findings.add<says::packets_rejected>(health, percent(part), rejected_text(r.counters));
}

void judge_beams(const Reception& r, FrameKind kind, Findings& findings) {
  if (r.frames_looked < least_looked || r.beams == 0) return;
  const bool cloud = kind == FrameKind::cloud;
  const std::uint64_t seen = r.returns + r.blind;
  const double returned = share(cloud ? seen : r.returns, r.beams);
  const double blind = share(r.blind, cloud ? seen : r.beams);
  if (cloud ? returned < 0.01 : r.returns == 0 && blind < 0.95)
    findings.add<says::no_returns>(Health::warn, percent(returned));
  else if (blind >= 0.95)
    findings.add<says::beams_blind>(Health::warn, percent(blind));
}

}  // namespace

ReceptionVerdict judge(const Reception& r, FrameKind kind) {
  Findings findings;
  const double patience = std::max(judged_after_s, 5 * r.period_s);
  if (r.counters.packets > 0 && r.without_frame_s >= patience) {
    r.period_s > 0 ? findings.add<says::no_frame_of>(Health::error, 1 / r.period_s, r.without_frame_s)
                   : findings.add<says::no_frame>(Health::error, r.without_frame_s);
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
  return text<says::two_senders>(first.to_string(), second.to_string(), port);
}

std::string rejected_text(const Counters& counters) {
  Counted reasons;
  for (std::size_t i = 1; i < reject_reasons; ++i)
    reasons.add(to_string(static_cast<Reject>(i)), counters.rejected[i]);
  return std::to_string(counters.rejected_total()) + reasons.in_brackets();
}

}  // namespace lidard
