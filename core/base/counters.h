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
const char* to_string(Reject reason);

/// What happened to one sensor's input since the start. Every loss shows up here.
struct Counters {
  std::uint64_t packets = 0;  ///< data packets received, good or bad
  std::uint64_t bytes = 0;    ///< their payload bytes
  std::uint64_t other_packets =
      0;  ///< packets of another kind of the same sensor (telemetry), recognised and set aside
  std::uint64_t frames = 0;  ///< scans or revolutions handed on
  std::uint64_t partial_frames =
      0;                         ///< frames cut off by begin, end or a hole, not handed on unless asked for
  std::uint64_t incomplete = 0;  ///< telegrams given up because a part never came; lost_packets has them
  std::uint64_t lost_packets =
      0;  ///< packets (or scans, for scanners that count scans) missing between those received
  std::uint64_t reordered = 0;    ///< packets older than one already used
  std::uint64_t clock_steps = 0;  ///< jumps of the device clock
  std::uint64_t lying_packets =
      0;  ///< packets whose model byte contradicts the configured model; decoded as configured
  std::array<std::uint64_t, reject_reasons> rejected{};  ///< by reason, [Reject]

  void reject(Reject reason) { ++rejected[static_cast<std::size_t>(reason)]; }
  std::uint64_t rejected_total() const {
    std::uint64_t sum = 0;
    for (const auto n : rejected) sum += n;
    return sum;
  }
};

}  // namespace lidard
