// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/sick_segments.h"

#include <algorithm>
#include <cmath>

#include "test/sim/devices/sick_telegram.h"

namespace lidard::sim {
namespace {

constexpr std::uint16_t imu_port = 7503;

/// Lines that are sent in one module: they fire together.
struct Layers {
  std::vector<double> elevation_deg;
  double behind_deg;  ///< its mirror looks so much further around
  double step_deg;
};

/// A multiScan136: elevations as in recordings of one, azimuths of the layers without their small offsets.
std::vector<Layers> many_layers() {
  return {{{22.31, 17.27, 12.32, 7.52, 2.53, -2.07, -6.87}, 0, 1},
          {{-13.6, -17.9, -22.54, -27.3, -32.24, -37.34, -42.93}, 180, 1},
          {{0.05}, 0, 0.125},
          {{-35.04}, 180, 0.125}};
}

/// One line of one segment of the frame, and where its beams stand among the frame's. `measured` of its beams
/// lie in the view.
struct Part {
  std::size_t segment, module;
  double elevation_deg, first_deg, step_deg;
  std::size_t beams, measured;
  Stamp start;
  double beam_ns;
  std::size_t first_beam;

  double angle_deg(std::size_t beam) const { return first_deg + step_deg * static_cast<double>(beam); }
  Stamp time(std::size_t beam) const {
    return start + Span(std::llround(beam_ns * static_cast<double>(beam)));
  }
};

double wrapped(double deg) { return deg - 360 * std::floor((deg + 180) / 360); }

/// The layout of the telegrams is that of SICK's descriptions (KaitaiStructDescriptions, ScanSegmentAPI),
/// checked on recordings of a multiScan136 and a picoScan150. So is how a frame of a single layer begins and
/// ends (picoscan150_compact_frag: 5 segments of 240 beams each 0.25 deg from -138 deg, 40 turns/s): the last
/// segment has as many beams as the others; those beyond the end of the view are zero; its stop time is one
/// beam after the last that is not (2517 us = 145 * 17.36 us); the first segment's start time is one beam
/// early (from it to the second segment's 4185 us = 241 * 17.36 us).
class SickSegments final : public SensorModel {
 public:
  SickSegments(const SickSegmentsOptions& options, const SensorEntry& entry, Stamp start)
      : options_(options), clock_offset_(entry.clock_offset), start_(start), next_imu_(start) {
    if (options.several_layers)
      layers_ = many_layers();
    else
      layers_ = {{{0}, 0, options.resolution_deg}};
    begin_deg_ = options.several_layers ? -180 : options.start_deg;
    const double end = options.several_layers ? 180 - 1e-9 : options.end_deg + 1e-9;
    segments_ = static_cast<std::size_t>(std::ceil((end - begin_deg_) / options.segment_deg));
    end_deg_ = end;
  }

  const std::vector<Beam>& next() override {
    beams_.clear();
    parts_.clear();
    for (std::size_t s = 0; s < segments_; ++s) {
      for (std::size_t m = 0; m < layers_.size(); ++m) add_parts(s, m);
    }
    ++frame_;
    return beams_;
  }

  void encode(const std::vector<Answer>& answers, const Surroundings& /*around*/,
              std::vector<Datagram>& datagrams, std::vector<SlotTruth>& slots) override {
    for (const Part& part : parts_) {
      for (std::size_t b = 0; b < part.beams; ++b) add_truth(part, b, answers[part.first_beam + b], slots);
    }
    for (std::size_t s = 0; s < segments_; ++s) add_segment(s, answers, datagrams);
    add_imu(datagrams);
    std::stable_sort(datagrams.begin(), datagrams.end(),
                     [](const Datagram& a, const Datagram& b) { return a.ready < b.ready; });
  }

 private:
  void add_parts(std::size_t segment, std::size_t module) {
    const Layers& layers = layers_[module];
    const double first = begin_deg_ + options_.segment_deg * static_cast<double>(segment);
    const double last = first + options_.segment_deg - 1e-9;
    Part part{};
    part.segment = segment;
    part.module = module;
    part.first_deg = wrapped(first + layers.behind_deg);
    part.step_deg = layers.step_deg;
    part.beams = static_cast<std::size_t>(std::floor((last - first) / layers.step_deg)) + 1;
    part.measured = part.beams;
    if (last > end_deg_)
      part.measured = static_cast<std::size_t>(std::floor((end_deg_ - first) / layers.step_deg)) + 1;
    part.beam_ns = static_cast<double>(options_.turn.count()) * layers.step_deg / 360;
    const Stamp frame = start_ + options_.turn * static_cast<std::int64_t>(frame_);
    part.start =
        frame + Span(std::llround(static_cast<double>(options_.turn.count()) * (first - begin_deg_) / 360));
    for (const double elevation : layers.elevation_deg) {
      part.elevation_deg = elevation;
      part.first_beam = beams_.size();
      parts_.push_back(part);
      for (std::size_t b = 0; b < part.beams; ++b) beams_.push_back(beam(part, b));
    }
  }

  static Beam beam(const Part& part, std::size_t b) {
    const double theta = part.angle_deg(b) * rad_per_deg, phi = part.elevation_deg * rad_per_deg;
    Beam beam;
    beam.time = part.time(b);
    beam.azimuth = theta;
    beam.ray.direction = {std::cos(phi) * std::cos(theta), std::cos(phi) * std::sin(theta), std::sin(phi)};
    return beam;
  }

  bool is_kept(double deg) const {
    if (deg > end_deg_) return false;
    return !options_.keep_deg ||
           (deg >= options_.keep_deg->first - 1e-9 && deg <= options_.keep_deg->second + 1e-9);
  }
  static double millimetres(const Answer::Echo& echo) {
    return std::min(65535.0, std::round(echo.distance * 1000));
  }

  void add_truth(const Part& part, std::size_t b, const Answer& answer, std::vector<SlotTruth>& slots) const {
    const Beam& beam = beams_[part.first_beam + b];
    for (std::size_t e = 0; e < options_.echoes; ++e) {
      SlotTruth slot;
      slot.time = beam.time;
      slot.azimuth = beam.azimuth;
      slot.echo = static_cast<std::uint8_t>(e);
      if (!is_kept(part.angle_deg(b))) slot.wire = std::nan("");
      if (e < answer.count) {
        const Answer::Echo& echo = answer.echoes[e];
        slot.exact = echo.exact;
        slot.reflectivity = echo.reflectivity;
        if (is_kept(part.angle_deg(b)))
          slot.wire = wire_distance(static_cast<std::uint32_t>(millimetres(echo)), 1);
      }
      slot.xyz = slot.exact * beam.ray.direction;
      slots.push_back(slot);
    }
  }

  std::uint64_t device_us(Stamp time) const {
    return static_cast<std::uint64_t>((time + clock_offset_).ns / 1000);
  }

  Stamp told_start(const Part& part) const {
    const bool early = !options_.several_layers && part.segment == 0;
    return early ? part.time(0) - Span(std::llround(part.beam_ns)) : part.time(0);
  }
  static Stamp told_stop(const Part& part) { return part.time(std::min(part.measured, part.beams - 1)); }

  SickBeam beam_on_wire(const Part& part, std::size_t b, const Answer& answer) const {
    SickBeam out;
    out.theta = part.angle_deg(b) * rad_per_deg;
    const bool kept = is_kept(part.angle_deg(b));
    for (std::size_t e = 0; e < options_.echoes; ++e) {
      if (!kept || e >= answer.count) {
        out.echoes.push_back({});
        continue;
      }
      const double rssi = std::min(65535.0, std::round(answer.echoes[e].reflectivity * 20000));
      out.echoes.push_back({millimetres(answer.echoes[e]), static_cast<std::uint16_t>(rssi)});
      out.reflector = out.reflector || answer.echoes[e].reflectivity > 1;
    }
    return out;
  }

  void add_segment(std::size_t number, const std::vector<Answer>& answers, std::vector<Datagram>& datagrams) {
    SickSegment segment;
    segment.index = number;
    segment.frame = options_.first_frame + frame_ - 1;
    segment.sender = options_.serial;
    segment.modules.resize(layers_.size());
    Stamp last = start_;
    bool any_kept = false;
    for (const Part& part : parts_) {
      if (part.segment != number) continue;
      SickLine line;
      line.start_us = device_us(told_start(part));
      line.stop_us = device_us(told_stop(part));
      line.elevation = part.elevation_deg * rad_per_deg;
      line.theta_start = part.angle_deg(0) * rad_per_deg;
      line.theta_stop = part.angle_deg(part.beams - 1) * rad_per_deg;
      for (std::size_t b = 0; b < part.beams; ++b) {
        line.beams.push_back(beam_on_wire(part, b, answers[part.first_beam + b]));
        any_kept = any_kept || is_kept(part.angle_deg(b));
      }
      last = std::max(last, told_stop(part));
      segment.modules[part.module].push_back(std::move(line));
    }
    if (!any_kept) return;
    segment.counter = ++counter_;
    segment.transmit_us = device_us(last) + 1000;
    datagrams.push_back({last, 0, encoded(segment)});
  }

  SickBytes encoded(const SickSegment& segment) const {
    if (options_.format == SickSegmentsOptions::Format::msgpack) return msgpack_scan(segment);
    return compact_scan(segment, options_.format == SickSegmentsOptions::Format::compact3 ? 3 : 4);
  }

  /// The vehicle stands or drives evenly on level ground: the inertial unit feels its weight.
  void add_imu(std::vector<Datagram>& datagrams) {
    if (options_.imu_hz <= 0) return;
    const Stamp end = beams_.back().time;
    for (; next_imu_ <= end; next_imu_ = next_imu_ + span_from_seconds(1 / options_.imu_hz)) {
      datagrams.push_back(
          {next_imu_, imu_port, compact_imu(device_us(next_imu_), {0, 0, 9.81F}, {0, 0, 0}, {1, 0, 0, 0})});
    }
  }

  SickSegmentsOptions options_;
  Span clock_offset_;
  Stamp start_;
  Stamp next_imu_;
  std::vector<Layers> layers_;
  double begin_deg_ = 0, end_deg_ = 0;
  std::size_t segments_ = 0;
  std::uint64_t frame_ = 0;
  std::uint64_t counter_ = 0;
  std::vector<Part> parts_;
  std::vector<Beam> beams_;
};

}  // namespace

ModelMaker make_sick_segments(const SickSegmentsOptions& options) {
  return [options](const SensorEntry& entry, Stamp start) {
    return std::make_unique<SickSegments>(options, entry, start);
  };
}

}  // namespace lidard::sim
