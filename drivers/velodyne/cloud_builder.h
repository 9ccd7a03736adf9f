// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "core/base/time.h"
#include "core/frames/revolution.h"
#include "drivers/driver.h"
#include "drivers/velodyne/calibration.h"
#include "drivers/velodyne/raw_packets.h"
#include "drivers/velodyne/unpacker.h"

namespace lidard::velodyne {

/// Collects firing sequences into frames and publishes them.
class CloudBuilder {
 public:
  /// `config` is the driver's; change() is applied to it. `raw`: handed on before the cloud of its packets.
  CloudBuilder(DriverConfig& config, const ModelRow& row, RawPacketCollector& raw, Counters& counters)
      : config_(config),
        row_(row),
        raw_(raw),
        counters_(counters),
        unpacker_(row, config.keep_origins, config.min_range, config.max_range, own_calibration(config)),
        cutter_(config.cut_angle * deg_per_rad),
        most_sequences_(most_sequences(row)) {
    unpacker_.keep_too_near(config.keep_too_near);
    cloud_.frame_id = config.frame_id;
    cloud_.rings = static_cast<std::uint16_t>(row.lasers);
    cloud_.bank_by_bank = row.bank_by_bank;
    cloud_.max_range = config.max_range;
    find_directions(config.calibration ? *own_calibration(config) : table_of(row));
  }

  Unpacker& unpacker() { return unpacker_; }
  /// From the next frame on.
  void set_calibration(std::shared_ptr<const Calibration> calibration) { fresh_ = std::move(calibration); }
  /// Driver::change().
  void change(const DriverConfig& wanted) { wanted_ = wanted; }

  /// Makes room for a packet; call before its sequences.
  void begin_packet() {
    unpacker_.reserve_packet(cloud_);
    within_ = false;
  }
  /// The same for a packet whose azimuths grow without a wrap from the first to the last sequence: most such
  /// packets lie within a frame as a whole.
  void begin_even_packet(double first_deg, double last_deg, Span first, Span last) {
    begin_packet();
    within_ = in_stream_ && cutter_.pass(first_deg, last_deg, first, last);
  }
  /// Finds the frame of a sequence whose first laser fires at device time `time` and fills in the dependent
  /// times. Call once per sequence, then append() for each of its returns.
  void find_frame(Sequence& sequence, Span time, const DeviceClock& clock, FrameReceiver& out) {
    auto verdict = within_ ? RevolutionCutter::Verdict::same : cutter_.next(sequence.azimuth_deg, time);
    if (++sequences_ > most_sequences_) verdict = RevolutionCutter::Verdict::forced;
    if (!in_stream_) {
      begin(time, false, clock, out);
    } else if (verdict != RevolutionCutter::Verdict::same) {
      const bool at_cut = verdict == RevolutionCutter::Verdict::crossed;
      end(at_cut, out);
      begin(time, at_cut, clock, out);
    }
    // Only packets that overlap by their stamps fire before the frame's first sequence.
    sequence.in_frame = std::max(time - frame_time_, Span(0));
    sequence.stamp = clock.to_host(time) + config_.time_offset;
    // The view is counter-clockwise from the front (REP 103), azimuth clockwise.
    visible_ = config_.in_view(-sequence.azimuth_deg * rad_per_deg);
    if (visible_ && is_thin_) visible_ = in_view_++ % thin_step == 0;
  }

  void append(const Sequence& sequence) {
    if (visible_) unpacker_.append(sequence, cloud_);
  }
  /// Call after a packet's sequences.
  void end_packet() { unpacker_.transform(cloud_, points_); }
  /// Ends the current frame: the stream ended or its clock jumped.
  void cut_off(FrameReceiver& out) {
    end(false, out);
    cutter_.reset();
  }

  void reset() {
    cutter_.reset();
    cloud_.columns.clear();
    in_stream_ = false;
    stamps_.reset();
  }

  /// Sequences of a frame are counted per return.
  void set_echoes(std::size_t echoes) { echoes_ = echoes; }

 private:
  void find_directions(const Calibration& calibration) {
    const std::vector<std::uint16_t> rings = rings_by_elevation(calibration);
    cloud_.directions.resize(rings.size());
    for (std::size_t laser = 0; laser < rings.size(); ++laser) {
      const LaserCalibration& angles = calibration.lasers[laser];
      cloud_.directions[rings[laser]] = {angles.vert_correction, -angles.rot_correction};
    }
  }
  /// A frame ends after this time: RevolutionCutter's limit.
  static constexpr Span longest_turn = std::chrono::milliseconds(1500);
  /// At 600 rpm.
  static constexpr Span usual_turn = std::chrono::milliseconds(100);
  /// One sequence in this number is kept of a frame without consumers.
  static constexpr std::size_t thin_step = 16;

  /// Limit of the firing sequences of a frame, for stamps that do not advance.
  static std::size_t most_sequences(const ModelRow& row) {
    Span shortest = row.timings.front().sequence;
    for (const Timing& timing : row.timings) shortest = std::min(shortest, timing.sequence);
    return static_cast<std::size_t>(longest_turn / shortest) * 5 / 4 + 100;
  }

  void begin(Span time, bool at_cut, const DeviceClock& clock, FrameReceiver& out) {
    in_stream_ = true;
    is_thin_ = !out.wants_cloud();
    in_view_ = 0;
    began_at_cut_ = at_cut;
    frame_time_ = time;
    sequences_ = 1;
    cloud_.columns.clear();
    cloud_.origins.clear();
    cloud_.too_near.clear();
    points_ = 0;
    if (fresh_) {
      unpacker_.set_calibration(*fresh_);
      find_directions(*std::exchange(fresh_, nullptr));
    }
    if (wanted_) apply(*std::exchange(wanted_, std::nullopt));
    reserve_revolution();
    unpacker_.reserve_packet(cloud_);
    cloud_.stamp = stamps_.next(clock.to_host(time) + config_.time_offset);
  }

  /// Reserves the size of the last frame, or of a full turn, so that the buffer (10 MB) is not copied while
  /// packets arrive.
  void reserve_revolution() {
    if (is_thin_) return;
    std::size_t bytes = last_bytes_;
    if (bytes == 0) {
      const Span turn = cutter_.period() > Span(0) ? std::min(cutter_.period(), longest_turn) : usual_turn;
      bytes = static_cast<std::size_t>(turn / row_.timings.front().sequence) * echoes_ * row_.lasers *
              sizeof(CloudPoint);
    }
    if (cloud_.points_bytes.capacity() >= bytes) return;
    cloud_.points_bytes.clear();
    cloud_.points_bytes.reserve(bytes + bytes / 16);
  }

  void apply(const DriverConfig& wanted) {
    config_.time_offset = wanted.time_offset;
    config_.min_range = wanted.min_range;
    config_.max_range = cloud_.max_range = wanted.max_range;
    config_.view_direction = wanted.view_direction;
    config_.view_width = wanted.view_width;
    unpacker_.set_ranges(wanted.min_range, wanted.max_range);
  }

  void end(bool at_cut, FrameReceiver& out) {
    if (!in_stream_) return;
    in_stream_ = false;
    unpacker_.transform(cloud_, points_);
    if (cloud_.columns.empty()) return;
    cloud_.complete = began_at_cut_ && at_cut;
    if (!cloud_.complete && !config_.keep_partial) {
      ++counters_.partial_frames;
      return;
    }
    cloud_.end = cloud_.columns.back().stamp;
    cloud_.expected_columns =
        static_cast<std::size_t>(cutter_.period() / row_.timings.front().sequence) * echoes_;
    cloud_.points_bytes.resize(points_ * sizeof(CloudPoint));
    if (!is_thin_ && cloud_.complete) last_bytes_ = cloud_.points_bytes.size();
    ++counters_.frames;
    raw_.publish(out);
    out.cloud(cloud_);
  }

  DriverConfig& config_;
  const ModelRow& row_;
  RawPacketCollector& raw_;
  Counters& counters_;
  Unpacker unpacker_;
  RevolutionCutter cutter_;
  std::shared_ptr<const Calibration> fresh_;  // applied with the next frame
  std::optional<DriverConfig> wanted_;        // applied with the next frame
  Cloud cloud_;
  std::size_t points_ = 0;
  std::size_t echoes_ = 1;
  std::size_t sequences_ = 0;  // of the current frame
  std::size_t most_sequences_;
  bool in_stream_ = false;
  bool within_ = false;  // the current frame holds all sequences of the packet
  bool began_at_cut_ = false;
  bool visible_ = true;
  std::size_t last_bytes_ = 0;  // points of the last frame with consumers
  bool is_thin_ = false;        // the current frame has no consumers
  std::size_t in_view_ = 0;     // sequences of a thin frame so far
  Span frame_time_{0};
  SteadyStamps stamps_;
};

}  // namespace lidard::velodyne
