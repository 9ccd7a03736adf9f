// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/timing.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace lidard::velodyne {
namespace {

/// Sequence time from the next packet, if the two are consecutive.
void use_next(const NextPacket& next, std::size_t sequences, FiringSchedule& schedule) {
  const Span one = next.step / static_cast<int>(sequences);
  const Span off = one - schedule.sequence;
  if (off > schedule.sequence / 10 || off < -schedule.sequence / 10) return;
  schedule.sequence = one;
}

/// Total duration of the hidden sectors inside the packet.
Span silence_of(const PacketAzimuths& azimuths, Span busy, const std::optional<NextPacket>& next,
                double turn_rate) {
  if (azimuths.hidden_total_deg <= 0) return Span(0);
  const Span estimate = turn_rate > 0 ? span_from_seconds(azimuths.hidden_total_deg / turn_rate) : Span(0);
  if (!next) return estimate;
  // The next packet's stamp gives the exact time, unless packets between them were lost.
  const Span exact = next->step - busy;
  if (exact < Span(0)) return estimate;
  if (estimate > Span(0) && exact - estimate > busy / 2) return estimate;
  return exact;
}

}  // namespace

FiringSchedule schedule_of(const ModelRow& row, const Timing& timing, Span measured_sequence,
                           const PacketAzimuths& azimuths, std::size_t echoes,
                           const std::optional<NextPacket>& next, double turn_rate) {
  FiringSchedule schedule;
  schedule.sequence = row.random_rest ? measured_sequence : timing.sequence;
  const auto per_block = static_cast<int>(row.sequences_per_block());
  const std::size_t sequences = row.sequences_per_packet(echoes);
  schedule.rate_deg_per_s = plausible_rate(azimuths.step_deg / seconds(schedule.sequence * per_block));
  if (row.random_rest && next && azimuths.hidden_total_deg <= 0) {
    use_next(*next, sequences, schedule);
  }
  // Few groups and one step of stamps in microseconds give the rotation only roughly.
  if (row.random_rest && turn_rate > 0) schedule.rate_deg_per_s = turn_rate;
  const Span group = schedule.sequence * per_block;
  const Span busy = group * static_cast<int>(azimuths.groups);
  const Span silence = silence_of(azimuths, busy, next, turn_rate);
  // The stamp may be later than the first firing.
  Span begin = -timing.before;
  for (std::size_t g = 0; g < azimuths.groups; ++g) {
    if (azimuths.hidden_deg[g] > 0) {
      const double part = azimuths.hidden_deg[g] / azimuths.hidden_total_deg;
      begin += Span(std::llround(static_cast<double>(silence.count()) * part));
    }
    schedule.begin[g] = begin;
    begin += group;
  }
  schedule.end = begin;
  return schedule;
}

void TimingChooser::add(Span step, std::size_t sequences) {
  if (row_.timings.size() == 1 && !row_.random_rest) return;
  const std::int64_t one = step.count() / static_cast<std::int64_t>(sequences);
  // A doubled step (a lost packet) is not a period.
  if (one * 2 > row_.timings.front().sequence.count() * 3 || one * 2 < row_.timings.front().sequence.count())
    return;
  const std::size_t slot = count_ % steps_.size();
  auto end = sorted_.begin() + static_cast<std::ptrdiff_t>(std::min(count_, steps_.size()));
  if (count_ >= steps_.size()) {
    sum_ -= steps_[slot];
    const auto oldest = std::lower_bound(sorted_.begin(), end, steps_[slot]);
    end = std::move(oldest + 1, end, oldest);
  }
  steps_[slot] = one;
  sum_ += one;
  ++count_;
  const auto position = std::upper_bound(sorted_.begin(), end, one);
  std::move_backward(position, end, end + 1);
  *position = one;
  const std::int64_t median = sorted_[static_cast<std::size_t>(end + 1 - sorted_.begin()) / 2];
  for (const Timing& timing : row_.timings) {
    if (std::abs(timing.sequence.count() - median) < std::abs(chosen_->sequence.count() - median))
      chosen_ = &timing;
  }
}

Span TimingChooser::measured_sequence() const {
  if (count_ == 0) return chosen_->sequence;
  return Span(sum_ / static_cast<std::int64_t>(std::min(count_, steps_.size())));
}

void Rotation::add(double azimuth_deg, Span step) {
  // Long compared with the resolution of stamps and azimuths, short enough to follow the motor.
  constexpr double window_s = 0.2;
  constexpr Span longest_step = std::chrono::milliseconds(40);  // below one turn at 1200 rpm
  const double turned = std::fmod(azimuth_deg - std::exchange(last_azimuth_deg_, azimuth_deg) + 360.5, 360);
  if (step <= Span(0) || step > longest_step) return;
  turned_deg_ += turned - 0.5;
  turned_s_ += seconds(step);
  if (turned_s_ < window_s) return;
  turned_deg_ /= 2;
  turned_s_ /= 2;
}

double Rotation::rate() const { return turned_s_ > 0 ? plausible_rate(turned_deg_ / turned_s_) : 0; }

double Rotation::rate_at(const PacketAzimuths& azimuths, Span time, Span sequence, std::size_t per_block) {
  const double usual = rate();
  if (azimuths.hidden_total_deg <= 0) return usual;
  std::size_t g = 1;
  while (g + 1 < azimuths.groups && azimuths.hidden_deg[g] <= 0) ++g;
  const Edge edge{time + sequence * static_cast<int>((g - 1) * per_block), azimuths.group_deg(g - 1)};
  const std::optional<Edge> before = std::exchange(edge_, edge);
  if (!before) return usual;
  const double elapsed = seconds(edge.time - before->time);
  const double beyond = std::remainder(edge.azimuth_deg - before->azimuth_deg, 360);
  const double turns = std::round((usual * elapsed - beyond) / 360);
  constexpr double recent_turns = 3;
  return turns < 1 || turns > recent_turns ? usual : plausible_rate((360 * turns + beyond) / elapsed);
}

namespace {

/// Weight of the table's period, in packets.
constexpr double table_weight = 500;
/// Packets; long enough for a precision of 1e-5 despite the jitter, short enough to follow the temperature.
constexpr double period_window = 50'000;
/// Packets, about a fifth of a turn; the motor changes its speed slowly.
constexpr double turn_window = 512;
/// The azimuth counts if a packet is at most this number of packets late or as many periods early.
constexpr double latest_packets = 8;
constexpr double slack_packets = 10;
/// After a longer pause the number of turns is unknown.
constexpr Span longest_pause = std::chrono::seconds(1);

constexpr double hour_ns = 3.6e12;

/// Share of the lag by which the stamps follow the arrivals, so that clock differences do not accumulate; the
/// lag of late packets is limited to the usual jitter.
constexpr double follow = 1.0 / 128;
constexpr double usual_jitter_ns = 200e3;

double turned_deg(double from, double to) { return to < from ? to - from + 360 : to - from; }

}  // namespace

void ArrivalStamps::Mean::add(double amount, double count, double window) {
  sum += amount;
  packets += count;
  if (packets < window) return;
  sum /= 2;
  packets /= 2;
}

ArrivalStamps::ArrivalStamps(const ModelRow& row) : usual_period_(row.packet_period(row.timings.front(), 1)) {
  reset();
}

void ArrivalStamps::reset() {
  period_ns_ = {static_cast<double>(usual_period_.count()) * table_weight, table_weight};
  turn_deg_ = {};
  started_ = false;
}

/// An integer; 0: a duplicate, negative: a late packet.
double ArrivalStamps::packets_since(Span elapsed, double azimuth_deg) const {
  const double by_arrival = static_cast<double>(elapsed.count()) / period_ns_.value();
  const double most = by_arrival + slack_packets;
  const double turn = turn_deg_.packets > 0 ? turn_deg_.value() : 0;
  constexpr double slowest_deg = 0.1;  // per packet: 43 rpm
  if (elapsed < longest_pause && elapsed > -longest_pause && turn > slowest_deg) {
    const double part = turned_deg(last_azimuth_deg_, azimuth_deg) / turn;
    const double packets_per_turn = 360 / turn;
    if (part <= most)
      return std::max(1.0,
                      std::round(part + packets_per_turn * std::floor((most - part) / packets_per_turn)));
    // More than can have been sent since: the packet is before the last one.
    if (packets_per_turn - part <= latest_packets) return std::round(part - packets_per_turn);
  }
  return std::max(1.0, std::round(by_arrival));
}

bool ArrivalStamps::is_repeated(const std::uint8_t* packet) const {
  return std::memcmp(packet, last_.data(), last_.size()) == 0;
}

void ArrivalStamps::learn(Span elapsed, double turned, double packets) {
  constexpr double certain = 4;  // packets that are counted right despite the jitter
  if (packets < 1 || packets > certain) return;
  const auto usual_ns = static_cast<double>(usual_period_.count());
  const auto elapsed_ns = static_cast<double>(elapsed.count());
  // Late packets, and those read together with them, do not show the period.
  constexpr double most_jitter = 0.9;
  if (std::abs(elapsed_ns - packets * usual_ns) > most_jitter * usual_ns) return;
  period_ns_.add(elapsed_ns, packets, period_window);
  if (turned < 180) turn_deg_.add(turned, packets, turn_window);
}

void ArrivalStamps::advance(Span elapsed, double turned, double packets) {
  learn(elapsed, turned, packets);
  double step = packets * period_ns_.value();
  lag_ns_ += static_cast<double>(elapsed.count()) - step;
  // The host's clock was set, or turns were miscounted: restart the lag.
  if (std::abs(lag_ns_) > static_cast<double>(longest_pause.count())) lag_ns_ = 0;
  const double correction = follow * std::clamp(lag_ns_, -usual_jitter_ns, usual_jitter_ns);
  lag_ns_ -= correction;
  step += correction;
  time_ns_ = std::fmod(time_ns_ + step + hour_ns, hour_ns);
}

void ArrivalStamps::stamp(Stamp arrival, const PacketAzimuths& azimuths, std::uint8_t* packet) {
  const double azimuth = azimuths.group_deg(0);
  // A burst of a network card has fewer packets that stand.
  constexpr std::size_t most_in_burst = 8;
  const double beyond_s = std::remainder(seconds(arrival - last_arrival_), 1);
  standing_ = std::abs(beyond_s) * 8e9 < period_ns_.value() ? standing_ + 1 : 0;
  if (!started_) {
    started_ = true;
    time_ns_ = lag_ns_ = 0;
    turn_deg_.add(azimuths.step_deg * static_cast<double>(azimuths.groups), 1, turn_window);
  } else if (azimuths.step_deg <= 0 || !is_repeated(packet)) {
    const bool stands = standing_ > most_in_burst;
    const Span elapsed = stands ? Span(0) : arrival - last_arrival_;
    const double packets = packets_since(elapsed, azimuth);
    const Span by_period(std::llround(packets * period_ns_.value()));
    advance(stands ? by_period : elapsed, turned_deg(last_azimuth_deg_, azimuth), packets);
  }
  last_arrival_ = arrival;
  last_azimuth_deg_ = azimuth;
  std::memcpy(last_.data(), packet, last_.size());
  const auto us = static_cast<std::uint32_t>(std::llround(time_ns_ / 1000));
  for (std::size_t i = 0; i < 4; ++i) packet[stamp_offset + i] = static_cast<std::uint8_t>(us >> (8 * i));
}

}  // namespace lidard::velodyne
