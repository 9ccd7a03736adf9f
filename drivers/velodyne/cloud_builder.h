// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "core/base/time.h"
#include "core/frames/revolution.h"
#include "drivers/driver.h"
#include "drivers/velodyne/unpacker.h"

namespace lidard::velodyne {

/// Collects firing sequences into frames and hands them on.
class CloudBuilder {
 public:
  CloudBuilder(const DriverConfig& config, const ModelRow& row, Counters& counters);

  Unpacker& unpacker() { return unpacker_; }
  /// From the next frame on.
  void set_calibration(std::shared_ptr<const Calibration> calibration) { fresh_ = std::move(calibration); }
  /// For FrameCut::view: the middle of the sector that the sensor leaves out; empty while there is none.
  void set_hidden_middle(std::optional<double> azimuth_deg);
  /// Makes room for a packet; call before its sequences.
  void begin_packet() { unpacker_.reserve_packet(cloud_); }
  /// Finds the frame of a sequence whose first laser fires at device time `time` and fills in the times that
  /// depend on it.
  /// Call once per sequence, then append() for each of its returns.
  void place(Sequence& sequence, Span time, const DeviceClock& clock, DriverOutput& out);
  void append(const Sequence& sequence) {
    if (visible_) unpacker_.append(sequence, cloud_, points_);
  }
  /// Ends the frame at hand: the stream ends or its clock jumped.
  void cut_off(DriverOutput& out);
  void reset();
  /// Time of one revolution; 0 unknown.
  Span period() const { return cutter_.period(); }
  /// Sequences of a frame are counted per return.
  void set_echoes(std::size_t echoes) { echoes_ = echoes; }

 private:
  RevolutionCutter::Verdict judge(double azimuth_deg, Span time);
  void begin(Span time, bool at_cut, const DeviceClock& clock);
  void end(bool at_cut, DriverOutput& out);

  const DriverConfig& config_;
  const ModelRow& row_;
  Counters& counters_;
  Unpacker unpacker_;
  RevolutionCutter cutter_;
  IntervalCutter interval_;
  std::shared_ptr<const Calibration> fresh_;  // waits for the next frame
  Cloud cloud_;
  std::size_t points_ = 0;
  std::size_t echoes_ = 1;
  std::size_t sequences_ = 0;  // of the frame at hand
  std::size_t most_sequences_;
  bool in_stream_ = false;
  bool began_at_cut_ = false;
  bool visible_ = true;
  Span frame_time_{0};
  SteadyStamps stamps_;
};

}  // namespace lidard::velodyne
