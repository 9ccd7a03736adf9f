// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "drivers/model.h"
#include "test/sim/devices/sick_telegram.h"
#include "test/support/collector.h"

namespace lidard::test {

constexpr double bench_rad = 3.14159265358979323846 / 180;

/// A device of one layer on the desk: ten segments a frame, 0.5 deg, 20 turns/s, -138 to 138 deg. Beam k of a
/// frame (0 at -138 deg) has the distance 2000 + k mm.
class SegmentBench final : public DriverBench {
 public:
  explicit SegmentBench(const char* model = "sick_picoscan150", DriverConfig config = {})
      : DriverBench(model, std::move(config)) {}

  void scan(PlanarScan& scan) override {
    if (keep) DriverBench::scan(scan);
    ++released;
  }

  static constexpr int segments = 10;
  static constexpr int beams_of(int index) { return index == 9 ? 13 : 60; }
  static constexpr std::size_t all_beams = 553;
  static constexpr std::uint64_t frame_us = 50'000;
  double beam_us() const { return 50'000.0 / 720; }

  std::uint64_t time_us(std::uint64_t frame, std::size_t beam) const {
    return start_us + frame * frame_us +
           static_cast<std::uint64_t>(std::llround(static_cast<double>(beam) * beam_us()));
  }
  sim::SickSegment segment(std::uint64_t frame, int index) const {
    sim::SickSegment out;
    out.counter = 1000 + frame * segments + static_cast<std::uint64_t>(index);
    out.frame = 70 + frame;
    out.index = static_cast<std::uint64_t>(index);
    out.sender = 23370016;
    sim::SickLine line;
    const auto first = static_cast<std::size_t>(index) * 60;
    const int n = beams_of(index);
    line.start_us = time_us(frame, first);
    line.stop_us = time_us(frame, first + static_cast<std::size_t>(n) - 1);
    line.theta_start = (-138 + 30.0 * index) * bench_rad;
    line.theta_stop = line.theta_start + 0.5 * bench_rad * (n - 1);
    for (int b = 0; b < n; ++b) {
      sim::SickBeam beam;
      const double mm = 2000.0 + static_cast<double>(first) + b;
      beam.echoes.push_back({mm, 5000});
      for (int e = 1; e < echoes; ++e) beam.echoes.push_back({b % 2 == 0 ? mm + 1000 * e : 0, 300});
      beam.theta = line.theta_start + 0.5 * bench_rad * b;
      line.beams.push_back(beam);
    }
    out.modules = {{line}};
    return out;
  }
  /// When the segment's last beam was measured, on the host's clock, and 2 ms.
  Stamp arrival(std::uint64_t frame, int index) const {
    const auto last = static_cast<std::size_t>(index) * 60 + static_cast<std::size_t>(beams_of(index)) - 1;
    return host_of(time_us(frame, last)) + std::chrono::milliseconds(2);
  }
  Stamp host_of(std::uint64_t us) const {
    return epoch + std::chrono::microseconds(static_cast<std::int64_t>(us - start_us));
  }
  sim::SickBytes encode(const sim::SickSegment& what) const {
    return version == 0 ? sim::msgpack_scan(what) : sim::compact_scan(what, version);
  }
  Reject send(const sim::SickBytes& bytes, Stamp when, std::uint16_t port = 2115) {
    Packet packet;
    packet.payload = ByteView(bytes.data(), bytes.size());
    packet.arrival = when;
    packet.from = {IpAddress::v4(192, 168, 0, 30), 2115};
    packet.to = {IpAddress::v4(192, 168, 0, 1), port};
    const Verdict verdict = driver->receive(packet, *this);
    device = verdict.device;
    return verdict.reject;
  }
  Reject send(std::uint64_t frame, int index) {
    return send(encode(segment(frame, index)), arrival(frame, index));
  }
  void send_frame(std::uint64_t frame, int leave_out = -1) {
    for (int i = 0; i < segments; ++i) {
      if (i != leave_out) send(frame, i);
    }
  }

  std::string device;  // of the newest datagram
  std::uint64_t start_us = 92'040'000'000;
  Stamp epoch{1'767'225'600'000'000'000};
  int echoes = 1;
  std::uint32_t version = 4;  ///< 0: MSGPACK
  bool keep = true;
  std::size_t released = 0;
};

/// Number of beams that the scan says nothing of.
inline std::size_t unobserved(const PlanarScan& scan) {
  return static_cast<std::size_t>(
      std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::invalid));
}

inline void expect_geometry(const PlanarScan& scan) {
  EXPECT_EQ(scan.beams, SegmentBench::all_beams);
  EXPECT_NEAR(static_cast<double>(scan.angle_min) / bench_rad, -138, 1e-4);
  EXPECT_NEAR(static_cast<double>(scan.angle_max) / bench_rad, 138, 1e-3);
  EXPECT_NEAR(static_cast<double>(scan.angle_increment) / bench_rad, 0.5, 1e-6);
}

/// Bytes of a file; empty where it cannot be read.
inline std::vector<std::uint8_t> file_bytes(const std::string& path) {
  std::vector<std::uint8_t> bytes;
  if (std::FILE* file = std::fopen(path.c_str(), "rb")) {
    for (int c = 0; (c = std::fgetc(file)) != EOF;) bytes.push_back(static_cast<std::uint8_t>(c));
    std::fclose(file);
  }
  return bytes;
}

inline ByteView view_of(const std::vector<std::uint8_t>& bytes) { return {bytes.data(), bytes.size()}; }

}  // namespace lidard::test
