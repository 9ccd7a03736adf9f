// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "core/base/number_text.h"
#include "core/frames/scan.h"
#include "drivers/driver_base.h"
#include "drivers/sick/compact/frame_builder.h"
#include "drivers/sick/compact/raster_scan.h"

namespace lidard::sick {
namespace {

constexpr std::string_view reflectors_topic = "reflectors";

class ScanBuilder final : public FrameBuilder {
 public:
  ScanBuilder(const DriverConfig& config, const DeviceClock& clock, SegmentWarnings& warnings)
      : config_(config), clock_(clock), warnings_(warnings) {
    prepare_scan(config, scan_);
    prepare_scan(config, marked_);
    scan_.scan_time = static_cast<float>(config.model->frame_period);
  }

  Reject check(const Segment& segment) override {
    const bool planar = segment.line_count == 1;
    if (planar) {
      warnings_.clear(SegmentTrouble::layers);
    } else if (!warnings_.is_set(SegmentTrouble::layers)) {
      warnings_.set(SegmentTrouble::layers, "the device sends " + std::to_string(segment.line_count) +
                                                " layers, so it is no " +
                                                std::string(config_.model->product) +
                                                ": set the model, for instance sick_multiscan136");
    }
    if (!planar) return Reject::model;
    const SegmentLine& line = segment.lines[0];
    return grid_ || SweepGrid::of(line) ? Reject::none : Reject::field;
  }

  bool continues(const Segment& segment) const override {
    if (!grid_ || !grid_->holds(segment.lines[0])) return false;
    return !config_.publish_multiecho || segment.lines[0].echoes == echoes_;
  }

  void adopt(const Segment& segment) override {
    const auto grid = SweepGrid::of(segment.lines[0]);
    if (!grid) return;
    if (grid_) {
      warnings_.set(
          SegmentTrouble::geometry,
          printed("the device changed from beams each %.4f deg to %.4f deg or to other angles or echoes; "
                  "restart whatever expects the former",
                  grid_->step * deg_per_rad, grid->step * deg_per_rad));
    }
    grid_ = grid;
    echoes_ = config_.publish_multiecho ? segment.lines[0].echoes : 1;
    had_echo_.assign(grid_->beams, 0);
    window_segments_ = 0;
    beam_us_ = 0;
  }

  void begin(std::size_t slot) override {
    sweeps_[slot].begin(*grid_, echoes_, scan_.range_min, scan_.range_max);
  }

  void add(std::size_t slot, const Segment& segment, std::uint32_t /*packet*/) override {
    if (sweeps_[slot].add(segment.lines[0], had_echo_) == 0 || warnings_.is_set(SegmentTrouble::uneven))
      return;
    warnings_.set(
        SegmentTrouble::uneven,
        "beams of the device are not evenly spaced; each is taken for the nearest even angle, which "
        "is wrong by up to half a step");
  }

  bool end(std::size_t slot, const FrameEnd& how, DriverOutput& out) override {
    const RasterScan& sweep = sweeps_[slot];
    if (sweep.is_empty()) return false;
    if (how.complete() && how.expected != window_segments_) learn_window(sweep, how.expected);
    const bool wanted = config_.keep_partial || (window_segments_ != 0 && !how.torn);
    if (!wanted) return false;
    BeamWindow all = window_;
    if (window_segments_ == 0) {
      all = {sweep.first_beam(), sweep.end_beam() - sweep.first_beam()};
      first_segment_ = sweep.first_segment();
      last_segment_ = sweep.last_segment();
    }
    if (kept(all).count == 0) return false;
    publish(sweep, all, out);
    return true;
  }

  void restart() override {
    stamps_.reset();
    last_first_us_ = 0;
  }

 private:
  void learn_window(const RasterScan& sweep, std::uint64_t segments) {
    const BeamWindow found{sweep.first_beam(), sweep.end_beam() - sweep.first_beam()};
    if (window_segments_ != 0 && (found.first != window_.first || found.count != window_.count)) {
      warnings_.set(
          SegmentTrouble::geometry,
          printed("the device changed from %zu beams from %.3f deg to %zu beams from %.3f deg; restart "
                  "whatever expects the former",
                  window_.count, grid_->angle(window_.first) * deg_per_rad, found.count,
                  grid_->angle(found.first) * deg_per_rad));
    }
    window_segments_ = segments;
    window_ = found;
    first_segment_ = sweep.first_segment();
    last_segment_ = sweep.last_segment();
  }

  /// The part of the window that the configured angles leave.
  BeamWindow kept(BeamWindow window) {
    BeamWindow part = beams_between(grid_->angle(window.first), grid_->step, window.count, config_.angle_min,
                                    config_.angle_max);
    part.first += window.first;
    warnings_.set(SegmentTrouble::no_beams,
                  part.count > 0
                      ? ""
                      : "no beam of the device lies between angle_min and angle_max; correct the angles "
                        "in the configuration");
    return part;
  }

  /// For a part of a segment that the angle filter hides, the device sends zeros, as for no echo. So the
  /// outermost beams count as not observed until the first echo; only in the first and last segment, since
  /// segments that are hidden altogether are not sent.
  void hide_unseen_edges(BeamWindow all, BeamWindow kept) {
    const auto hide = [&](std::size_t beam) {
      if (beam < kept.first || beam >= kept.first + kept.count) return;
      for (std::size_t e = 0; e < scan_.echoes; ++e) {
        const std::size_t i = scan_.index(beam - kept.first, e);
        if (scan_.statuses[i] == BeamStatus::none) scan_.set_without_hit(i, BeamStatus::invalid);
      }
    };
    const std::size_t end = all.first + all.count;
    for (std::size_t b = all.first; b < all.first + std::min(first_segment_, all.count) && had_echo_[b] == 0;
         ++b)
      hide(b);
    for (std::size_t b = end; b > end - std::min(last_segment_, all.count) && had_echo_[b - 1] == 0; --b)
      hide(b - 1);
  }

  void publish(const RasterScan& sweep, BeamWindow all, DriverOutput& out) {
    const BeamWindow part = kept(all);
    sweep.copy(part.first, part.count, echoes_, config_.publish_intensity, scan_);
    hide_unseen_edges(all, part);
    set_times(sweep, part);
    out.scan(scan_);
    if (!config_.model->extra_scans.empty() && sweep.reflectors() > 0) publish_reflectors(sweep, part, out);
  }

  /// Stamp, time from beam to beam and from scan to scan.
  void set_times(const RasterScan& sweep, BeamWindow part) {
    const SweepTimes times = sweep.times(beam_us_);
    if (sweep.segments() > 1) beam_us_ = times.beam_us;
    const double before = static_cast<double>(part.first) - static_cast<double>(sweep.first_beam());
    const double to_first_us = times.first_us + times.beam_us * before;
    const Span first =
        device_span(sweep.base_us()) + std::chrono::nanoseconds(std::llround(to_first_us * 1e3));
    scan_.stamp = stamps_.next(clock_.to_host(first) + config_.time_offset);
    scan_.time_increment = static_cast<float>(times.beam_us * 1e-6);
    const double turn_s = times.beam_us * 1e-6 * two_pi / grid_->step;
    if (turn_s > 0) scan_.scan_time = static_cast<float>(turn_s);
    const auto first_us = static_cast<std::uint64_t>(first.count() / 1000);
    const double since_s =
        first_us > last_first_us_ ? static_cast<double>(first_us - last_first_us_) * 1e-6 : 0;
    // A frame may have been lost in between.
    if (last_first_us_ != 0 && since_s > 0.5 * turn_s && since_s < 1.5 * turn_s)
      scan_.scan_time = static_cast<float>(since_s);
    last_first_us_ = first_us;
  }

  /// The scan with only the beams that met a reflector.
  void publish_reflectors(const RasterScan& sweep, BeamWindow kept, DriverOutput& out) {
    marked_.stamp = scan_.stamp;
    marked_.time_increment = scan_.time_increment;
    marked_.scan_time = scan_.scan_time;
    sweep.copy(kept.first, kept.count, 1, config_.publish_intensity, marked_);
    for (std::size_t i = 0; i < kept.count; ++i) {
      if (!sweep.reflector(kept.first + i)) marked_.set_without_hit(i, BeamStatus::invalid);
    }
    out.extra_scan(reflectors_topic, marked_);
  }

  DriverConfig config_;
  const DeviceClock& clock_;
  SegmentWarnings& warnings_;
  std::optional<SweepGrid> grid_;
  std::size_t echoes_ = 1;
  std::array<RasterScan, OpenFrames::most> sweeps_;
  std::vector<std::uint8_t> had_echo_;
  std::uint64_t window_segments_ = 0;  // of the window; 0: not yet known
  BeamWindow window_;
  std::size_t first_segment_ = 0, last_segment_ = 0;
  SteadyStamps stamps_;
  double beam_us_ = 0;  // from beam to beam, by the last frame that shows it; 0: unknown
  std::uint64_t last_first_us_ = 0;
  PlanarScan scan_;
  PlanarScan marked_;
};

}  // namespace

std::unique_ptr<FrameBuilder> make_scan_builder(const DriverConfig& config, const DeviceClock& clock,
                                                SegmentWarnings& warnings) {
  return std::make_unique<ScanBuilder>(config, clock, warnings);
}

}  // namespace lidard::sick
