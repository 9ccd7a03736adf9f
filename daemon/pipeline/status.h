// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/counters.h"
#include "core/base/time.h"
#include "core/frames/frame_filter.h"
#include "core/merge/merger.h"
#include "core/merge/scheduler.h"
#include "core/motion/pose_gate.h"
#include "core/mounts/mount_check.h"
#include "daemon/config/config.h"
#include "drivers/driver.h"
#include "drivers/model.h"
#include "drivers/net/tcp_source.h"
#include "drivers/net/udp_socket.h"
#include "drivers/reception.h"
#include "drivers/unknown_senders.h"

/// \file
/// States and counters of a pipeline; daemon/health turns them into sentences.
namespace lidard {

/// Stamps that are further apart are of different clocks: a bag's or a simulator's beside this host's.
constexpr Span another_clock = std::chrono::seconds(10);
/// s; poses that lag further behind the data are a fault, and an older speed is none.
constexpr double longest_lag_s = 0.5;

/// The filter of a sensor's frames on one topic.
struct FilterStatus {
  std::string topic;
  FilterCounters counters;
};

/// Two readings of this host's network and the time between them.
struct HostCounts {
  HostNetwork before, now;
  double time_s = 0;
  bool others_talk = false;  ///< packets of other sensors may be among the received ones
};

/// The way from a sensor to this daemon.
struct ConnectionStatus {
  UdpFault port;                             ///< of the sensor's port
  TcpState tcp{TcpState::Phase::connected};  ///< of a sensor that streams over TCP
  std::optional<HostNetwork> network;        ///< of this host
  bool has_route = false;                    ///< this host has one to the sensor
  std::optional<HostCounts> counts;          ///< may show why nothing comes
};

struct SensorStatus {
  std::string name;
  std::string model;                     ///< or "topic"
  const SensorConfig* config = nullptr;  ///< valid as long as the sensor is configured
  Counters counters;
  DeviceInfo info;
  std::vector<FilterStatus> filters;       ///< of its own frames, then of the ring that is a scan
  std::optional<PoseGate> gate;            ///< of its clouds; none: they are not transformed
  bool seen = false;                       ///< data was received
  Stamp last_arrival;                      ///< of data
  std::optional<Stamp> last_telemetry;     ///< of telemetry
  ConnectionStatus connection;             ///< while silent
  std::vector<const Model*> other_models;  ///< those of the rejected packets; empty: unknown
  std::string rivals;                      ///< what two devices with its address are; empty: there is one
  IpAddress address;                       ///< the configured one, or where its data come from
  std::optional<Span> clock_ahead;         ///< by which stamps of its topic, another clock's, are ahead
  std::uint64_t stamps_replaced = 0;       ///< of its topic
  bool starting = false;                   ///< the first second after the start: silence is no fault yet
  Reception recent, whole;                 ///< of the last 10 s, and since the start
};

/// The motion of the vehicle.
struct MotionStatus {
  bool has_poses = false;
  std::string topic;                ///< of poses or of turn rates; empty: tf
  std::string speed_topic;          ///< empty: none
  bool lacks_speed = false;         ///< the newest turn rate came without a speed
  std::optional<Span> clock_ahead;  ///< by which stamps of the topic, another clock's, are ahead
  bool data_live = false;           ///< sensors deliver
  bool poses_live = false;
  std::optional<double> data_ahead_s;   ///< s from the newest pose to the newest data; none: one is missing
  std::optional<double> poses_ahead_s;  ///< s from the newest data to the oldest pose
  std::string why_refused;              ///< why the newest pose could not be used; empty: it could
  std::uint64_t knots = 0, jumps_back = 0, not_rigid = 0, refused = 0, without_speed = 0, stamps_replaced = 0,
                out_of_order = 0;
};

/// What an output did since the start.
struct MakerCounters {
  std::uint64_t published = 0;
  std::uint64_t held_back = 0;  ///< outputs not published, since they would show the former instant again
  std::uint64_t no_pose = 0;    ///< inputs not used because the pose of a frame was not known
  std::string why_no_pose;      ///< the newest reason; it may be over
  Stamp no_pose_at{};           ///< when it was found
  Stamp last_published{};
  double most_silence = 3;  ///< s without an output that are no error

  void count_no_pose(Stamp now) {
    ++no_pose;
    no_pose_at = now;
  }
};

/// A source of an output that merges.
struct SourceStatus {
  std::string name;
  SourceState state = SourceState::never;
  SourceState lasting = SourceState::never;  ///< Scheduler::lasting_state()
  double period_s = 0, age_s = 0;
  double late_s = 0;  ///< by which it misses the deadline
};

struct MergeStatus {
  std::vector<SourceStatus> sources;
  std::vector<SourceUse> uses;  ///< in the newest output
  Span apart{0};                ///< between the stamps of the newest output's sources
  std::uint64_t deadlines_missed = 0;
  const PoseTrack* track = nullptr;  ///< nullptr: nobody knows how the vehicle moves
  PoseGate gate;
  std::vector<MountDifference> mounts;     ///< pairs of sources that see the same surfaces
  std::optional<std::size_t> wrong_mount;  ///< the source whose mount is wrong
};

/// The virtual scans of an entry.
struct VirtualStatus {
  std::vector<std::string> frames;
  std::vector<std::string> why_unplaced;  ///< by frame; empty: the newest cloud was seen from there
  std::string why_no_surfaces;            ///< what the cloud lacks; empty: nothing
  std::optional<PoseGate> gate;
};

/// An entry of merged_scans:, merged_clouds: or virtual_scans:.
struct MakerStatus {
  MakerId id;
  std::vector<std::string> sources, topics;
  MakerCounters counters;
  bool starting = false;  ///< waiting for input is no fault yet
  bool is_wanted = true;  ///< false: nobody gets what it makes
  std::optional<MergeStatus> merge;
  std::optional<VirtualStatus> planes;
  std::vector<std::pair<const char*, std::uint64_t>> figures;  ///< further counters
};

/// The messages on one topic or in one file.
struct TopicTotals {
  std::string name;
  std::uint64_t messages = 0;
  Stamp first{}, last{};  ///< when the first and the last one were released
  bool promised = true;   ///< false: it depends on the state of the device
  std::string remark{};   ///< why there is no output, or what was missing

  void count(Stamp released) {
    if (messages++ == 0) first = released;
    last = released;
  }
  /// Messages per second; 0: fewer than two.
  double rate() const {
    const double span = seconds(last - first);
    return messages < 2 || span <= 0 ? 0 : static_cast<double>(messages - 1) / span;
  }
};

struct PipelineStatus {
  Stamp now;
  std::vector<SensorStatus> sensors;
  std::optional<MotionStatus> motion;  ///< none: there is no source of motion
  std::vector<MakerStatus> makers;
  const UnknownSenders* unknown_senders = nullptr;
};

}  // namespace lidard
