// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lidard {

/// Why a packet was not used. Bad input is a value and a counter, never an exception.
enum class Reject : std::uint8_t {
  none,       ///< used
  size,       ///< wrong number of bytes
  magic,      ///< does not begin like the protocol
  version,    ///< a protocol version we do not know
  checksum,   ///< checksum or CRC wrong
  field,      ///< a field holds an impossible value
  model,      ///< the packet of another model
  duplicate,  ///< seen before
  stale,      ///< belongs to something already finished or given up
  count_
};
constexpr std::size_t reject_reasons = static_cast<std::size_t>(Reject::count_);

/// Short name for tables and diagnostics.
inline const char* to_string(Reject reason) {
  constexpr std::array<const char*, reject_reasons> names = {
      "none", "size", "magic", "version", "checksum", "field", "model", "duplicate", "stale"};
  return names.at(static_cast<std::size_t>(reason));
}

/// A counter of `Owner` and its names: reports, diagnostics and JSON are made from lists of these.
template <class Owner>
struct NamedCounter {
  std::uint64_t Owner::*value;
  const char* key;    ///< in JSON
  const char* words;  ///< for people, fit to follow a number
};

/// What happened to one sensor's input since the start. Every loss shows up here.
struct Counters {
  std::uint64_t packets = 0;         ///< data packets received, good or bad
  std::uint64_t bytes = 0;           ///< their payload bytes
  std::uint64_t other_packets = 0;   ///< other packets of the sensor (telemetry), recognised and set aside
  std::uint64_t frames = 0;          ///< scans or revolutions handed on
  std::uint64_t partial_frames = 0;  ///< cut off by begin, end or a hole, not handed on unless asked for
  std::uint64_t lost_packets = 0;    ///< packets (or scans, where those are counted) missing between others
  std::uint64_t incomplete = 0;      ///< telegrams given up because a part never came; lost_packets has them
  std::uint64_t reordered = 0;       ///< packets older than one already used
  std::uint64_t clock_steps = 0;     ///< jumps of the device clock
  std::uint64_t wrong_product = 0;  ///< whose model byte is not the configured model's; decoded as configured
  std::array<std::uint64_t, reject_reasons> rejected{};  ///< by reason, [Reject]

  void reject(Reject reason) { ++rejected[static_cast<std::size_t>(reason)]; }
  std::uint64_t rejected_total() const {
    std::uint64_t sum = 0;
    for (const auto n : rejected) sum += n;
    return sum;
  }
};

/// The counters reported for every sensor, beside those of rejected packets.
constexpr NamedCounter<Counters> usual_counters[] = {
    {&Counters::packets, "data_packets", "packets"},
    {&Counters::other_packets, "other_packets", "other packets"},
    {&Counters::frames, "frames", "frames"},
    {&Counters::lost_packets, "lost_packets", "lost packets"}};
/// Counters of faults.
constexpr NamedCounter<Counters> trouble_counters[] = {
    {&Counters::incomplete, "incomplete", "incomplete telegrams"},
    {&Counters::partial_frames, "partial_frames", "partial frames dropped"},
    {&Counters::reordered, "reordered", "reordered packets"},
    {&Counters::clock_steps, "clock_steps", "clock steps"},
    {&Counters::wrong_product, "wrong_product", "packets with a wrong product byte"}};

}  // namespace lidard
