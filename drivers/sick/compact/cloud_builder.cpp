// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "drivers/model.h"
#include "drivers/sick/compact/frame_builder.h"

namespace lidard::sick {
namespace {

/// An incomplete frame.
struct OpenCloud {
  Cloud cloud;
  std::size_t points = 0;
  std::uint64_t base_us = 0;  // device time of the points' time 0
  std::uint64_t end_us = 0;
};

class CloudBuilder final : public FrameBuilder {
 public:
  CloudBuilder(const DriverConfig& config, const DeviceClock& clock) : config_(config), clock_(clock) {
    const double least = std::max(config.min_range, config.model->range_min);
    const double most = config.max_range > 0 ? config.max_range : config.model->range_max;
    nearest_ = least;
    farthest_ = std::min(most, config.model->range_max);
    for (OpenCloud& open : open_) {
      open.cloud.frame_id = config.frame_id;
      open.cloud.max_range = config.max_range;
    }
  }

  Reject check(const Segment& /*segment*/) override { return Reject::none; }
  bool continues(const Segment& /*segment*/) const override { return true; }
  void adopt(const Segment& /*segment*/) override {}

  void begin(std::size_t slot) override {
    OpenCloud& open = open_[slot];
    open.cloud.clear();
    open.cloud.rings = 0;
    open.points = 0;
    open.base_us = open.end_us = 0;
  }

  void add(std::size_t slot, const Segment& segment, std::uint32_t packet) override {
    OpenCloud& open = open_[slot];
    if (open.cloud.columns.empty()) open.base_us = segment.start_us();
    open.end_us = std::max(open.end_us, segment.stop_us());
    prepare(segment, open);
    std::size_t most = open.points;
    for (std::size_t i = 0; i < segment.line_count; ++i)
      most += segment.lines[i].beams * segment.lines[i].echoes;
    if (open.cloud.size() < most) open.cloud.points_bytes.resize(most * sizeof(CloudPoint));
    open.cloud.rings = std::max(open.cloud.rings, static_cast<std::uint16_t>(segment.line_count));
    std::uint8_t number = 0;
    for (std::size_t begin = 0; begin < segment.line_count;) {
      std::size_t end = begin + 1;
      const SegmentLine& line = segment.lines[begin];
      while (end < segment.line_count && segment.lines[end].beams == line.beams &&
             segment.lines[end].echoes == line.echoes)
        ++end;
      add_group(segment, {begin, end, number++}, packet, open);
      begin = end;
    }
  }

  bool end(std::size_t slot, const FrameEnd& how, FrameReceiver& out) override {
    OpenCloud& open = open_[slot];
    if (open.cloud.columns.empty()) return false;
    const bool known = how.expected != 0;
    if (!config_.keep_partial && (how.torn || !known)) return false;
    Cloud& cloud = open.cloud;
    cloud.points_bytes.resize(open.points * sizeof(CloudPoint));
    float earliest = 0;
    for (std::size_t i = 0; i < open.points; ++i) {
      const float time = cloud.points()[i].time;  // a copy: the member is not aligned
      earliest = std::min(earliest, time);
    }
    // A reordered segment may hold the first beams.
    for (std::size_t i = 0; earliest < 0 && i < open.points; ++i) cloud.points()[i].time -= earliest;
    const Span first = device_span(open.base_us) + span_from_seconds(static_cast<double>(earliest));
    cloud.complete = how.complete() && !how.torn;
    cloud.stamp = stamps_.next(clock_.to_host(first) + config_.time_offset);
    cloud.end = clock_.to_host(device_span(open.end_us)) + config_.time_offset;
    out.cloud(cloud);
    return true;
  }

  void restart() override { stamps_.reset(); }

 private:
  /// Lines of one telegram whose beams fire together.
  struct Group {
    std::size_t begin, end;
    std::uint8_t number;
  };
  /// Common values of a line's beams.
  struct LineTable {
    double cos_elevation, sin_elevation;
    std::uint16_t ring;
    double start_s;  // after the cloud's base
  };

  /// Rings count from the lowest line up. Elevations are positive upwards (SICK developer guide; sick_scan_xd
  /// differs): in a recording of an upright multiScan136 (by its inertial unit) all layers of negative
  /// elevation hit the floor at the same height.
  void prepare(const Segment& segment, const OpenCloud& open) {
    for (std::size_t i = 0; i < segment.line_count; ++i) {
      const SegmentLine& line = segment.lines[i];
      std::uint16_t lower = 0;
      for (std::size_t k = 0; k < segment.line_count; ++k) {
        const double other = segment.lines[k].elevation;
        if (other < line.elevation || (other == line.elevation && k > i)) ++lower;
      }
      const double after_us = static_cast<double>(static_cast<std::int64_t>(line.start_us - open.base_us));
      tables_[i] = {std::cos(line.elevation), std::sin(line.elevation), lower, after_us * 1e-6};
    }
  }

  void add_group(const Segment& segment, Group group, std::uint32_t packet, OpenCloud& open) {
    const SegmentLine& first = segment.lines[group.begin];
    for (std::size_t beam = 0; beam < first.beams; ++beam) {
      for (std::size_t echo = 0; echo < first.echoes; ++echo) {
        CloudColumn column{};
        column.first_point = static_cast<std::uint32_t>(open.points);
        column.packet = packet;
        column.block = group.number;
        column.echo = static_cast<std::uint8_t>(echo);
        column.azimuth = static_cast<float>(first.azimuth(beam));
        column.stamp = clock_.to_host(device_span(first.start_us) +
                                      std::chrono::nanoseconds(std::llround(first.time_us(beam) * 1e3))) +
                       config_.time_offset;
        open.cloud.columns.push_back(column);
        for (std::size_t line = group.begin; line < group.end; ++line)
          add_point(segment, line, beam, echo, group, open);
        // Second and third echoes are rare: drop a column without a point.
        if (echo > 0 && open.points == column.first_point) open.cloud.columns.pop_back();
      }
    }
  }

  void add_point(const Segment& segment, std::size_t index, std::size_t beam, std::size_t echo, Group group,
                 OpenCloud& open) {
    const SegmentLine& line = segment.lines[index];
    const double distance = line.distance[echo][beam] * line.metres;
    if (!(distance > 0) || distance < nearest_ || distance > farthest_) return;
    const double azimuth = line.azimuth(beam);
    if (!config_.in_view(azimuth)) return;
    const LineTable& table = tables_[index];
    const double level = distance * table.cos_elevation;
    const double after_us = line.time_us(beam);
    CloudPoint& point = open.cloud.points()[open.points++];
    point.x = static_cast<float>(level * std::cos(azimuth));
    point.y = static_cast<float>(level * std::sin(azimuth));
    point.z = static_cast<float>(distance * table.sin_elevation);
    point.intensity = line.rssi[echo].sent() ? static_cast<float>(line.rssi[echo][beam]) : 0.0F;
    point.ring = table.ring;
    point.time = static_cast<float>(table.start_s + after_us * 1e-6);
    if (!config_.keep_origins) return;
    ReturnOrigin origin{};
    origin.column = static_cast<std::uint32_t>(open.cloud.columns.size() - 1);
    // The device numbers its layers from the top.
    origin.laser = static_cast<std::uint16_t>(segment.line_count - table.ring);
    origin.block = group.number;
    origin.azimuth_deg = azimuth * deg_per_rad;
    origin.distance_m = distance;
    const auto in_line = std::chrono::nanoseconds(std::llround(after_us * 1e3));
    origin.offset_ns = (device_span(line.start_us) - device_span(segment.start_us()) + in_line).count();
    origin.stamp = clock_.to_host(device_span(line.start_us) + in_line) + config_.time_offset;
    open.cloud.origins.push_back(origin);
  }

  DriverConfig config_;
  const DeviceClock& clock_;
  double nearest_ = 0, farthest_ = 0;  // m
  std::array<OpenCloud, OpenFrames::most> open_;
  std::array<LineTable, max_lines> tables_{};
  SteadyStamps stamps_;
};

}  // namespace

std::unique_ptr<FrameBuilder> make_cloud_builder(const DriverConfig& config, const DeviceClock& clock) {
  return std::make_unique<CloudBuilder>(config, clock);
}

}  // namespace lidard::sick
