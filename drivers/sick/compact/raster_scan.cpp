// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/compact/raster_scan.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"

namespace lidard::sick {
namespace {

constexpr double turn = two_pi;
/// Rounding of an azimuth on the wire (1/5215 rad), with a margin.
constexpr double azimuth_rounding = 1.5 / 5215;

/// rad from beam to beam. The announced last azimuth of an LRS4000 is the end of the turn, a step after the
/// last beam, so the azimuths of the beams decide. They are rounded, so the announced ends are used if they
/// agree.
double step_of(const SegmentLine& line) {
  const auto steps = static_cast<double>(line.beams - 1);
  const double announced = (line.theta_stop - line.theta_start) / steps;
  if (!line.theta.sent()) return announced;
  const double last = line.azimuth(line.beams - 1);
  if (std::fabs(last - line.theta_stop) < azimuth_rounding) return announced;
  const double measured = (last - line.azimuth(0)) / steps;
  const double around = turn / static_cast<double>(line.beams);
  return std::fabs(measured - around) * steps < azimuth_rounding ? around : measured;
}

/// Median of the first `count` values (reorders them); for an even count the mean of the middle two.
double median(std::array<double, max_segments>& values, std::size_t count) {
  std::sort(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
  return (values[(count - 1) / 2] + values[count / 2]) / 2;
}

}  // namespace

long RasterGrid::nearest(double angle) const { return std::lround((angle - first) / step); }

std::optional<RasterGrid> RasterGrid::of(const SegmentLine& line) {
  if (line.beams < 2) return std::nullopt;
  RasterGrid grid;
  grid.step = step_of(line);
  constexpr double finest = 2e-4;  // rad
  if (!(grid.step >= finest) || grid.step > 0.2) return std::nullopt;
  constexpr double lowest = -0.52 * turn;
  const double before = std::floor((line.theta_start - lowest) / grid.step);
  if (before < 0) return std::nullopt;
  grid.first = line.theta_start - before * grid.step;
  grid.beams = static_cast<std::size_t>(std::ceil(1.06 * turn / grid.step));
  return grid;
}

void RasterGrid::align(const SegmentLine& line) {
  const auto begin = static_cast<double>(nearest(line.theta_start));
  if (line.beams > 1) step = step_of(line);
  first = line.theta_start - begin * step;
}

bool RasterGrid::holds(const SegmentLine& line) const {
  const long begin = nearest(line.theta_start);
  if (begin < 0 || static_cast<std::size_t>(begin) + line.beams > beams) return false;
  const double beside = std::fabs(angle(static_cast<std::size_t>(begin)) - line.theta_start);
  if (beside > 0.1 * step + 1e-5) return false;
  if (line.beams < 2) return true;
  return std::fabs(step_of(line) - step) * static_cast<double>(line.beams - 1) <
         0.1 * step + azimuth_rounding;
}

void RasterScan::begin(const RasterGrid& grid, std::size_t echoes, float range_min, float range_max) {
  grid_ = grid;
  beams_.range_min = range_min;
  beams_.range_max = range_max;
  beams_.reset(grid.beams, echoes, true);
  reflectors_.assign(grid.beams, {});
  reflector_count_ = 0;
  begin_count_ = 0;
  empty_ = true;
}

void RasterScan::note_extent(const SegmentLine& line, std::size_t begin, std::size_t end) {
  if (empty_ || begin < first_beam_) {
    first_beam_ = begin;
    first_segment_ = end - begin;
    grid_.align(line);
  }
  if (empty_ || end > end_beam_) {
    end_beam_ = end;
    last_segment_ = end - begin;
  }
  inside_us_ = static_cast<double>(line.stop_us - line.start_us);
  note_begin(begin, line.start_us);
  empty_ = false;
}

void RasterScan::note_begin(std::size_t beam, std::uint64_t us) {
  if (begin_count_ == begins_.size()) return;
  std::size_t at = begin_count_++;
  for (; at > 0 && begins_[at - 1].beam > beam; --at) begins_[at] = begins_[at - 1];
  begins_[at] = {beam, us};
}

std::size_t RasterScan::add(const SegmentLine& line, std::vector<std::uint8_t>& had_echo) {
  const auto begin = static_cast<std::size_t>(grid_.nearest(line.theta_start));
  note_extent(line, begin, begin + line.beams);
  std::size_t beside = 0;
  const double tolerance = std::max(0.25 * grid_.step, azimuth_rounding);
  for (std::size_t i = 0; i < line.beams; ++i) {
    const std::size_t beam = begin + i;
    if (line.theta.sent() && std::fabs(line.azimuth(i) - grid_.angle(beam)) > tolerance) ++beside;
    put(line, i, beam);
    if (beams_.statuses[beam] != BeamStatus::none) had_echo[beam] = echo_memory;
  }
  return beside;
}

/// The device sends the echoes of a beam nearest first.
void RasterScan::put(const SegmentLine& line, std::size_t from, std::size_t beam) {
  const auto metres = static_cast<float>(line.metres);
  const std::size_t echoes = std::min(line.echoes, beams_.echoes);
  for (std::size_t e = 0; e < echoes; ++e) {
    const std::size_t i = beams_.index(beam, e);
    const float range = static_cast<float>(line.distance[e][from]) * metres;
    if (line.rssi[e].sent()) beams_.intensities[i] = static_cast<float>(line.rssi[e][from]);
    if (range > 0)
      beams_.set_measured(i, range);
    else
      beams_.set_without_hit(i, range == 0 ? BeamStatus::none : BeamStatus::invalid);  // not a number
  }
  for (std::size_t e = echoes; e < beams_.echoes; ++e) {
    beams_.set_without_hit(beams_.index(beam, e), BeamStatus::none);
  }
  if (line.properties.sent() && (static_cast<unsigned>(line.properties[from]) & 1U) != 0)
    put_reflector(line, from, reflectors_[beam]);
}

/// The flag belongs to the last echo (sick_perception_sdk, PointCloudCollector.cpp; sick_scan_xd,
/// compact_parser.cpp): a fence before the reflector has an echo too.
void RasterScan::put_reflector(const SegmentLine& line, std::size_t from, Reflector& reflector) {
  const auto metres = static_cast<float>(line.metres);
  const bool is_known = reflector.range > 0;
  for (std::size_t e = 0; e < line.echoes; ++e) {
    const float range = static_cast<float>(line.distance[e][from]) * metres;
    if (range > 0) reflector = {range, line.rssi[e].sent() ? static_cast<float>(line.rssi[e][from]) : 0};
  }
  if (!is_known && reflector.range > 0) ++reflector_count_;
}

/// Only the start times of segments are used. In a recording of a picoScan150 (5 segments of 240 beams, 0.25
/// deg, 40 turns/s) the stop time of the last segment is that of the end of the view (+138.25 deg), 95 beams
/// before its last, empty beam, and the start time of the first segment is one beam (17 us) early. The median
/// is right in both cases.
RasterTimes RasterScan::times(double known_beam_us) const {
  RasterTimes times;
  std::array<double, max_segments> values{};
  std::size_t count = 0;
  const auto after_us = [&](std::size_t i) {
    return static_cast<double>(static_cast<std::int64_t>(begins_[i].us - base_us()));
  };
  for (std::size_t i = 1; i < begin_count_; ++i) {
    const std::size_t beams = begins_[i].beam - begins_[i - 1].beam;
    if (beams > 0) values[count++] = (after_us(i) - after_us(i - 1)) / static_cast<double>(beams);
  }
  times.beam_us = count > 0 ? median(values, count) : 0;
  if (!(times.beam_us > 0)) {
    const std::size_t beams = end_beam_ - first_beam_;
    times.beam_us = beams < 2 ? 0 : inside_us_ / static_cast<double>(beams - 1);
    if (known_beam_us > 0) times.beam_us = known_beam_us;
    return times;
  }
  for (std::size_t i = 0; i < begin_count_; ++i) {
    const auto beams = static_cast<double>(begins_[i].beam - first_beam_);
    values[i] = after_us(i) - times.beam_us * beams;
  }
  times.first_us = median(values, begin_count_);
  return times;
}

void RasterScan::copy(std::size_t begin, std::size_t count, std::size_t echoes, bool with_intensities,
                      PlanarScan& out) const {
  out.beams = count;
  out.echoes = echoes;
  out.ranges.resize(count * echoes);
  out.statuses.resize(count * echoes);
  out.intensities.resize(with_intensities ? count * echoes : 0);
  for (std::size_t e = 0; e < echoes; ++e) {
    const auto from = static_cast<std::ptrdiff_t>(beams_.index(begin, e));
    const auto to = static_cast<std::ptrdiff_t>(e * count);
    const auto n = static_cast<std::ptrdiff_t>(count);
    std::copy_n(beams_.ranges.begin() + from, n, out.ranges.begin() + to);
    std::copy_n(beams_.statuses.begin() + from, n, out.statuses.begin() + to);
    if (with_intensities) std::copy_n(beams_.intensities.begin() + from, n, out.intensities.begin() + to);
  }
}

}  // namespace lidard::sick
