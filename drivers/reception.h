// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/counters.h"
#include "core/base/time.h"
#include "core/frames/cloud.h"
#include "core/frames/scan.h"
#include "drivers/address.h"
#include "drivers/model.h"

namespace lidard {

/// Received and expected data of a sensor within a time.
struct Reception {
  Counters counters;                      ///< within the time
  double watched_s = 0;                   ///< s since the first packet, at most the window
  double frames_s = 0;                    ///< s of the time with a known rate of frames
  double frames = 0;                      ///< frames within frames_s
  double expected = 0;                    ///< expected frames within frames_s
  double without_frame_s = 0;             ///< s since the last frame, or since the first packet
  double period_s = 0;                    ///< s between two frames, of the model or learned; 0: unknown
  std::uint64_t frames_looked = 0;        ///< frames of which beams are counted
  std::uint64_t beams = 0;                ///< beams, or shots of a multi-plane lidar
  std::uint64_t returns = 0;              ///< those with a return
  std::uint64_t blind = 0;                ///< those with a too near or invalid return
  std::uint64_t sender_changes = 0;       ///< packets of another sender than the packet before
  std::array<IpAddress, 2> senders = {};  ///< the newest two

  std::uint64_t lost() const { return counters.lost_packets; }
};

/// Silence of a source until a warning and until an error, s. The limits are longer for rare frames;
/// `period_s`: usual time between two frames, 0: unknown. With checks every 0.1 s, a lidar's silence is WARN
/// within 1 s and ERROR within 3 s.
struct SilenceLimits {
  explicit SilenceLimits(double period_s);
  double warn_s, error_s;
};

/// The silence of a source by these limits; of `last_arrival` is its newest data.
enum class SilenceLevel : std::uint8_t { none, brief, lasting };
SilenceLevel silence_of(Stamp last_arrival, double period_s, Stamp now);

/// Measures the reception of one sensor over the last 10 s and since the start. advance() gives the time;
/// jumps of the clock (backwards, or more than 1 s) do not count.
class ReceptionWatch {
 public:
  /// `promised_s`: usual time between two frames by the model and its settings, s; 0: unknown.
  explicit ReceptionWatch(double promised_s);

  /// Adds frames, for their beams and for the rate: the median of the stamps' distances.
  void scan(const PlanarScan& scan);
  void cloud(const Cloud& cloud);
  /// Adds the sender of a data packet, for entries that accept any sender.
  void sender(const IpAddress& address);
  /// Advances the time; `counters`: of the sensor, since the start.
  void advance(Stamp now, const Counters& counters);
  /// Restarts the window (the input starts again).
  void restart();

  Reception recent() const;
  Reception whole() const;
  /// Usual time between two frames, s; 0: unknown.
  double period_s() const { return total_.period_s; }

 private:
  static constexpr std::size_t marks = 11;  // a window of 10 s
  static constexpr std::size_t distances = 8;
  void learn(Stamp stamp, double lasts_s);
  double median_distance() const;
  void add_time(double passed_s, bool packets_came, std::uint64_t frames);
  void mark();
  Reception since(const Reception& begin) const;

  const double promised_s_;
  bool begun_ = false;
  Stamp last_{};
  double idle_s_ = 0;     // since the last packet
  double settles_s_ = 0;  // remaining time after a silence in which drivers count its losses
  double period_s_ = 0;   // of the last frame; 0: not known
  Stamp last_stamp_{};
  std::array<double, distances> distances_{};  // s between stamps, in a ring
  std::size_t distance_count_ = 0;
  Reception total_;
  std::array<Reception, marks> marks_{};  // total_ at the last seconds, in a ring
  std::size_t mark_count_ = 0;
};

}  // namespace lidard
