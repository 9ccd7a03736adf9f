// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/firing_schedule.h"

#include <cmath>

namespace lidard::velodyne {
namespace {

/// Sequence time from the next packet, where the two follow each other directly.
void use_next(const NextPacket& next, std::size_t sequences, FiringSchedule& schedule) {
  const Span one = next.step / static_cast<int>(sequences);
  const Span off = one - schedule.sequence;
  if (off > schedule.sequence / 10 || off < -schedule.sequence / 10) return;
  schedule.sequence = one;
}

/// The silences of the hidden sectors inside the packet, together.
Span silence_of(const PacketAzimuths& azimuths, Span busy, const std::optional<NextPacket>& next,
                double turn_rate) {
  if (azimuths.hidden_total_deg <= 0) return Span(0);
  const Span estimate = turn_rate > 0 ? span_from_seconds(azimuths.hidden_total_deg / turn_rate) : Span(0);
  if (!next) return estimate;
  // Counting back from the next packet's stamp is exact, unless packets between them were lost.
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
  // Its few groups tell the rotation only roughly, and so does one step of stamps in whole microseconds.
  if (row.random_rest && turn_rate > 0) schedule.rate_deg_per_s = turn_rate;
  const Span group = schedule.sequence * per_block;
  const Span busy = group * static_cast<int>(azimuths.groups);
  const Span silence = silence_of(azimuths, busy, next, turn_rate);
  // The stamp may stand behind the first firing.
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

}  // namespace lidard::velodyne
