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
    return grid_ || RasterGrid::of(line) ? Reject::none : Reject::field;
  }

  bool continues(const Segment& segment) const override {
    if (!grid_ || !grid_->holds(segment.lines[0])) return false;
    return !config_.publish_multiecho || segment.lines[0].echoes == echoes_;
  }

  void adopt(const Segment& segment) override {
    const auto grid = RasterGrid::of(segment.lines[0]);
    if (!grid) return;
    if (grid_) {
      warnings_.set(
          SegmentTrouble::geometry,
          printed("the device changed from beams every %.4f deg to %.4f deg or to other angles or echoes; "
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
    rasters_[slot].begin(*grid_, echoes_, scan_.range_min, scan_.range_max);
  }

  void add(std::size_t slot, const Segment& segment, std::uint32_t /*packet*/) override {
    if (rasters_[slot].add(segment.lines[0], had_echo_) == 0 || warnings_.is_set(SegmentTrouble::uneven))
      return;
    warnings_.set(SegmentTrouble::uneven,
                  "beams of the device are not evenly spaced; every beam is assigned to the nearest "
                  "even angle, with an error of up to half a step");
  }

  bool end(std::size_t slot, const FrameEnd& how, FrameReceiver& out) override {
    const RasterScan& raster = rasters_[slot];
    if (raster.is_empty()) return false;
    if (how.complete() && how.expected != window_segments_) learn_window(raster, how.expected);
    const bool wanted = config_.keep_partial || (window_segments_ != 0 && !how.torn);
    if (!wanted) return false;
    BeamWindow all = window_;
    if (window_segments_ == 0) {
      all = {raster.first_beam(), raster.end_beam() - raster.first_beam()};
      first_segment_ = raster.first_segment();
      last_segment_ = raster.last_segment();
    }
    if (kept(all).count == 0) return false;
    publish(raster, all, out);
    return true;
  }

  void restart() override { stamps_.reset(); }

 private:
  void learn_window(const RasterScan& raster, std::uint64_t segments) {
    const BeamWindow found{raster.first_beam(), raster.end_beam() - raster.first_beam()};
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
    // Else the angles would depend on which segment came first, by a unit in the last digit.
    grid_ = raster.grid();
    first_segment_ = raster.first_segment();
    last_segment_ = raster.last_segment();
  }

  /// The part of the window within the configured angles.
  BeamWindow kept(BeamWindow window) {
    BeamWindow part = beams_inside(config_.sector(), grid_->angle(window.first), grid_->step, window.count);
    part.first += window.first;
    warnings_.set(SegmentTrouble::no_beams,
                  part.count > 0
                      ? ""
                      : "no beam of the device lies between angle_min and angle_max; correct the angles "
                        "in the configuration");
    return part;
  }

  /// In a segment that the angle filter hides partly, the device sends zeros, as for no echo. So the
  /// outermost beams of the first and the last segment count as not observed up to one with a recent echo:
  /// the filter may be narrowed while scans come.
  void hide_unseen_edges(BeamWindow all, BeamWindow kept) {
    const auto hide = [&](std::size_t beam) {
      if (beam < kept.first || beam >= kept.first + kept.count) return;
      for (std::size_t e = 0; e < scan_.echoes; ++e) {
        const std::size_t i = scan_.index(beam - kept.first, e);
        if (scan_.statuses[i] == BeamStatus::none) scan_.set_without_hit(i, BeamStatus::invalid);
      }
    };
    const std::size_t end = all.first + all.count;
    for (std::size_t b = all.first; b < all.first + first_segment_ && had_echo_[b] == 0; ++b) hide(b);
    for (std::size_t b = end; b > end - last_segment_ && had_echo_[b - 1] == 0; --b) hide(b - 1);
    for (std::uint8_t& scans : had_echo_) {
      if (scans > 0) --scans;
    }
  }

  void copy(const RasterScan& raster, BeamWindow part, std::size_t echoes, PlanarScan& to) const {
    raster.copy(part.first, part.count, echoes, config_.publish_intensity, to);
    to.set_angles(static_cast<float>(grid_->angle(part.first)), static_cast<float>(grid_->step));
  }

  void publish(const RasterScan& raster, BeamWindow all, FrameReceiver& out) {
    const BeamWindow part = kept(all);
    copy(raster, part, echoes_, scan_);
    hide_unseen_edges(all, part);
    scan_.hide_gap(part);
    set_times(raster, part);
    out.scan(scan_);
    if (!config_.model->extra_scans.empty() && raster.reflectors() > 0) publish_reflectors(raster, part, out);
  }

  /// Stamp, time from beam to beam and from scan to scan.
  void set_times(const RasterScan& raster, BeamWindow part) {
    const RasterTimes times = raster.times(beam_us_);
    if (raster.segments() > 1) beam_us_ = times.beam_us;
    const double before = static_cast<double>(part.first) - static_cast<double>(raster.first_beam());
    const double to_first_us = times.first_us + times.beam_us * before;
    const Span first =
        device_span(raster.base_us()) + std::chrono::nanoseconds(std::llround(to_first_us * 1e3));
    scan_.stamp = stamps_.next(clock_.to_host(first) + config_.time_offset);
    scan_.time_increment = static_cast<float>(times.beam_us * 1e-6);
    // Of this frame alone: the one before may be damaged.
    const double turn_s = times.beam_us * 1e-6 * two_pi / grid_->step;
    if (turn_s > 0) scan_.scan_time = static_cast<float>(turn_s);
  }

  /// Publishes the scan with only the beams that hit a reflector.
  void publish_reflectors(const RasterScan& raster, BeamWindow kept, FrameReceiver& out) {
    marked_.stamp = scan_.stamp;
    marked_.time_increment = scan_.time_increment;
    marked_.scan_time = scan_.scan_time;
    copy(raster, kept, 1, marked_);
    for (std::size_t i = 0; i < kept.count; ++i) {
      const RasterScan::Reflector& reflector = raster.reflector(kept.first + i);
      if (reflector.range > 0)
        marked_.set_measured(i, reflector.range);
      else
        marked_.set_without_hit(i, BeamStatus::invalid);
      if (!marked_.intensities.empty()) marked_.intensities[i] = reflector.intensity;
    }
    marked_.hide_gap(kept);
    out.extra_scan(reflectors_topic, marked_);
  }

  DriverConfig config_;
  const DeviceClock& clock_;
  SegmentWarnings& warnings_;
  std::optional<RasterGrid> grid_;
  std::size_t echoes_ = 1;
  std::array<RasterScan, OpenFrames::most> rasters_;
  std::vector<std::uint8_t> had_echo_;  // by beam: RasterScan::echo_memory, less the scans since
  std::uint64_t window_segments_ = 0;   // segments of the window; 0: not yet known
  BeamWindow window_;
  std::size_t first_segment_ = 0, last_segment_ = 0;
  SteadyStamps stamps_;
  double beam_us_ = 0;  // from beam to beam, of the last frame that shows it; 0: unknown
  PlanarScan scan_;
  PlanarScan marked_;
};

}  // namespace

std::unique_ptr<FrameBuilder> make_scan_builder(const DriverConfig& config, const DeviceClock& clock,
                                                SegmentWarnings& warnings) {
  return std::make_unique<ScanBuilder>(config, clock, warnings);
}

}  // namespace lidard::sick
