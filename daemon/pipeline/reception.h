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
#include "daemon/pipeline/sink.h"
#include "drivers/address.h"
#include "drivers/model.h"

namespace lidard {

/// What came from a sensor within a time, beside what should have come.
struct Reception {
  Counters counters;                ///< of that time alone
  double watched_s = 0;             ///< s since the first packet, at most the window
  double frames_s = 0;              ///< s of that time in which the rate of frames was known
  double frames = 0;                ///< frames within frames_s
  double expected = 0;              ///< frames that should have come within frames_s
  double without_frame_s = 0;       ///< s since the last frame, or since the first packet
  double period_s = 0;              ///< s between two frames, as promised or learned; 0: not known
  std::uint64_t frames_looked = 0;  ///< frames whose beams are counted here:
  std::uint64_t beams = 0;          ///< beams, or shots of a multi-plane lidar
  std::uint64_t returns = 0;        ///< those with a return
  std::uint64_t blind = 0;          ///< those with something too near, or that the device does not vouch for

  std::uint64_t lost() const { return counters.lost_packets; }
};

/// How long a source may say nothing, s: until a warning, until an error. One that sends seldom may be silent
/// for longer; `period_s`: usual time between two of its frames, 0: not known. With the rounds of a tenth of
/// a second in which all is looked at, a lidar's silence is told as WARN within 1 s and as ERROR within 3 s.
struct SilenceLimits {
  explicit SilenceLimits(double period_s);
  double warn_s, error_s;
};

/// What is wrong with it.
struct ReceptionVerdict {
  Health health = Health::ok;
  std::string figures;  ///< "7.4 of 10.0 frames/s, 10 % of packets lost"; empty: all is well
  std::string remedy;   ///< what to look at
};

/// Compares what came with what should have come.
///
/// - No frame though packets come: ERROR after 2 s or 5 periods. The slowest turn takes 0.2 s, so whole turns
///   fit in.
/// - Frames missing: WARN below 90 %, since a window counts one frame more or less and nominal rates are off
///   by 2 %; ERROR below 50 %, where a sensor is of no use for driving.
/// - Packets lost: WARN from 1 % and two packets on, since a cable loses nothing and a host that stalls loses
///   bursts; ERROR from 5 % on, which is 18 degrees of each turn.
/// - Packets that came twice: WARN from 10 % on, since they cost nothing but show how the network is.
/// - Packets rejected otherwise: WARN from 1 % and two packets on, since foreign packets beside good ones
/// take nothing
///   away; ERROR from 99 % on, when another device sends.
/// - Beams blind: WARN where 95 % are too near (0.3 m) or invalid, or none has a return; of a multi-plane
///   lidar, which sees the ground, less than 1 % of the shots. Only people can tell a cover from an empty
///   field.
///
/// How much a scanner that counts scans has lost shows in its frames, so after a loss the missing frames are
/// judged by the limits for losses. All is judged after 2 s, what beams see after 10 frames. The limits are
/// our choice.
ReceptionVerdict judge(const Reception& reception, FrameKind kind);

/// The sentence for several senders into one entry.
std::string rivals_text(const std::vector<std::string>& senders, std::uint16_t port);

/// Follows what comes from one sensor: over the last 10 s, and since the start. Time is what advance() says;
/// a jump of the clock (backwards, or more than 1 s at once) is no time that passed.
class ReceptionWatch {
 public:
  /// `promised_s`: usual time between two frames by the model and its settings, s; 0: nobody promises.
  explicit ReceptionWatch(double promised_s);

  /// The frames, for what their beams see and for the rate: a scanner's own scan_time, or the median of the
  /// stamps' distances. A device that sends more seldom than its scan_time says, without a loss, was told to.
  void scan(const PlanarScan& scan);
  void cloud(const Cloud& cloud);
  /// A data packet came from there, where any sender is taken.
  void sender(const IpAddress& address);
  /// Time passed; `counters`: of the sensor, since the start.
  void advance(Stamp now, const Counters& counters);
  /// The input starts again: what came until now is no part of the window.
  void restart();

  Reception recent() const;
  Reception whole() const;
  /// Usual time between two frames, s; 0: not known.
  double period_s() const { return total_.period_s; }
  /// Who sends to this sensor, if several do: in each of the last two seconds, or at any time.
  const std::vector<std::string>& rivals() const { return rivals_; }
  const std::vector<std::string>& rivals_ever() const { return rivals_ever_; }

 private:
  static constexpr std::size_t marks = 11;  // a window of 10 s
  static constexpr std::size_t distances = 8;
  static constexpr std::size_t most_senders = 4;
  struct Sender {
    IpAddress address;
    std::uint64_t now = 0, before = 0;  // packets in this second and in the last one
  };
  void learn(Stamp stamp, double declared_s);
  double median_distance() const;
  double period(double declared_s) const;
  void add_time(double passed_s, bool packets_came, std::uint64_t frames);
  void compare_senders();
  void mark();
  Reception since(const Reception& begin) const;

  const double promised_s_;
  bool begun_ = false;
  Stamp last_{};
  double idle_s_ = 0;     // since the last packet
  double settles_s_ = 0;  // time left after a silence, in which drivers count what was lost in it
  double period_s_ = 0;   // of the last frame; 0: not known
  Stamp last_stamp_{};
  std::array<double, distances> distances_{};  // s between stamps, in a ring
  std::size_t distance_count_ = 0;
  Reception total_;
  std::array<Reception, marks> marks_{};  // total_ at the last seconds, in a ring
  std::size_t mark_count_ = 0;
  std::array<Sender, most_senders> senders_{};
  std::vector<std::string> rivals_, rivals_ever_;
};

}  // namespace lidard
