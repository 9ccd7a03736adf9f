// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/cloud_builder.h"

#include <algorithm>

namespace lidard::velodyne {
namespace {

/// A frame ends by its stamps after so long: RevolutionCutter's limit.
constexpr Span longest_turn = std::chrono::milliseconds(1500);

/// Firing sequences that a frame can hold, with some to spare; more of them are no frame. Stamps that stand
/// still, or nearly so, would let it grow for ever.
std::size_t most_sequences(const DriverConfig& config, const ModelRow& row) {
  Span shortest = row.timings.front().sequence;
  for (const Timing& timing : row.timings) shortest = std::min(shortest, timing.sequence);
  const Span longest = config.frame_cut == FrameCut::time ? config.frame_duration : longest_turn;
  return static_cast<std::size_t>(longest / shortest) * 5 / 4 + 100;
}

}  // namespace

CloudBuilder::CloudBuilder(const DriverConfig& config, const ModelRow& row, Counters& counters)
    : config_(config),
      row_(row),
      counters_(counters),
      unpacker_(row, config.keep_origins, config.min_range, config.max_range, config.calibration.get()),
      cutter_(config.cut_angle * deg_per_rad),
      interval_(std::max(config.frame_duration, Span(1))),
      most_sequences_(most_sequences(config, row)) {
  unpacker_.keep(config.keep_confidence, config.keep_too_near);
  cloud_.frame_id = config.frame_id;
  cloud_.rings = static_cast<std::uint16_t>(row.lasers);
}

void CloudBuilder::set_hidden_middle(std::optional<double> azimuth_deg) {
  const bool moved = cutter_.set_cut(azimuth_deg.value_or(config_.cut_angle * deg_per_rad));
  // The frame at hand began elsewhere than it will end: no whole revolution.
  if (moved) began_at_cut_ = false;
}

RevolutionCutter::Verdict CloudBuilder::judge(double azimuth_deg, Span time) {
  using Verdict = RevolutionCutter::Verdict;
  const Verdict turn = cutter_.next(azimuth_deg, time);  // it measures the period in any case
  if (config_.frame_cut != FrameCut::time) return turn;
  return interval_.next(time) ? Verdict::crossed : Verdict::same;
}

void CloudBuilder::place(Sequence& sequence, Span time, const DeviceClock& clock, DriverOutput& out) {
  auto verdict = judge(sequence.azimuth_deg, time);
  if (++sequences_ > most_sequences_) verdict = RevolutionCutter::Verdict::forced;
  if (!in_stream_) {
    begin(time, false, clock);
  } else if (verdict != RevolutionCutter::Verdict::same) {
    const bool at_cut = verdict == RevolutionCutter::Verdict::crossed;
    end(at_cut, out);
    begin(time, at_cut, clock);
  }
  // Only packets that overlap by their stamps fire before the frame's first sequence.
  sequence.in_frame = std::max(time - frame_time_, Span(0));
  sequence.stamp = clock.to_host(time) + config_.time_offset;
  // The view counts counter-clockwise from the front (REP 103), azimuth clockwise.
  visible_ = config_.in_view(-sequence.azimuth_deg * rad_per_deg);
}

void CloudBuilder::begin(Span time, bool at_cut, const DeviceClock& clock) {
  in_stream_ = true;
  began_at_cut_ = at_cut;
  frame_time_ = time;
  sequences_ = 1;
  cloud_.columns.clear();
  cloud_.origins.clear();
  cloud_.confidences.clear();
  cloud_.too_near.clear();
  points_ = 0;
  if (fresh_) unpacker_.set_calibration(*std::exchange(fresh_, nullptr));
  unpacker_.reserve_packet(cloud_);
  cloud_.stamp = stamps_.next(clock.to_host(time) + config_.time_offset);
}

void CloudBuilder::end(bool at_cut, DriverOutput& out) {
  if (!in_stream_) return;
  in_stream_ = false;
  if (cloud_.columns.empty()) return;
  cloud_.complete = began_at_cut_ && at_cut;
  if (!cloud_.complete && !config_.keep_partial) {
    ++counters_.partial_frames;
    return;
  }
  cloud_.end = cloud_.columns.back().stamp;
  const Span whole = config_.frame_cut == FrameCut::time ? config_.frame_duration : cutter_.period();
  cloud_.expected_columns = static_cast<std::size_t>(whole / row_.timings.front().sequence) * echoes_;
  cloud_.points_bytes.resize(points_ * sizeof(CloudPoint));
  ++counters_.frames;
  out.cloud(cloud_);
}

void CloudBuilder::cut_off(DriverOutput& out) {
  end(false, out);
  cutter_.reset();
  interval_.reset();
}

void CloudBuilder::reset() {
  cutter_.reset();
  interval_.reset();
  cloud_.columns.clear();
  in_stream_ = false;
}

}  // namespace lidard::velodyne
