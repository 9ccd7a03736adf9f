// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/models.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard {
namespace {

/// A return of one laser: the number of its firing sequence, its azimuth counted on over the turns, deg, and
/// m.
struct Sample {
  std::size_t sequence;
  double azimuth_deg, distance_m;
};
/// Where a laser's beam goes from one surface to another that is more than a metre nearer or farther.
struct Edge {
  double azimuth_deg, near_m;
  bool outward;
};

/// The samples of each laser; `interpolated`: azimuths as decoded, else those of the blocks.
class Samples final : public FrameReceiver {
 public:
  Samples(const velodyne::ModelRow& row, bool interpolated)
      : row_(row), interpolated_(interpolated), lasers(row.lasers) {}
  void scan(PlanarScan& /*scan*/) override {}
  void cloud(Cloud& cloud) override {
    for (const ReturnOrigin& origin : cloud.origins) {
      const double block = cloud.columns[origin.column].azimuth * 180 / M_PI;
      const double azimuth =
          interpolated_ ? origin.azimuth_deg : block - row_.laser[origin.laser].rot_correction_deg;
      auto& samples = lasers[origin.laser];
      const double before = samples.empty() ? azimuth : samples.back().azimuth_deg;
      samples.push_back(
          {sequences_ + origin.column, before + std::remainder(azimuth - before, 360), origin.distance_m});
    }
    sequences_ += cloud.columns.size();
  }

 private:
  const velodyne::ModelRow& row_;
  bool interpolated_;
  std::size_t sequences_ = 0;

 public:
  std::vector<std::vector<Sample>> lasers;
};

std::vector<Edge> edges_of(const std::vector<Sample>& samples) {
  constexpr double jump_m = 1;
  constexpr double flat_m = 1;  // beside it the surfaces go on
  std::vector<Edge> edges;
  for (std::size_t i = 1; i + 2 < samples.size(); ++i) {
    const Sample* s = &samples[i];
    if (s[2].sequence - s[-1].sequence != 3) continue;
    const double jump = s[1].distance_m - s[0].distance_m;
    if (std::fabs(jump) < jump_m || std::fabs(s[0].distance_m - s[-1].distance_m) > flat_m ||
        std::fabs(s[2].distance_m - s[1].distance_m) > flat_m)
      continue;
    edges.push_back(
        {(s[0].azimuth_deg + s[1].azimuth_deg) / 2, std::min(s[0].distance_m, s[1].distance_m), jump > 0});
  }
  return edges;
}

/// Mean azimuth difference of the edges that two lasers see of the same objects.
struct Offset {
  double mean_deg = 0;
  std::size_t edges = 0;
};

Offset offset_of(const std::vector<Edge>& a, const std::vector<Edge>& b) {
  constexpr double reach_deg = 0.5;
  constexpr double same_m = 1;
  Offset offset;
  double sum = 0;
  for (const Edge& edge : a) {
    auto at = std::lower_bound(b.begin(), b.end(), edge.azimuth_deg - reach_deg,
                               [](const Edge& e, double azimuth) { return e.azimuth_deg < azimuth; });
    double best = reach_deg;
    bool found = false;
    for (; at != b.end() && at->azimuth_deg < edge.azimuth_deg + reach_deg; ++at) {
      const double off = at->azimuth_deg - edge.azimuth_deg;
      if (at->outward != edge.outward || std::fabs(at->near_m - edge.near_m) > same_m) continue;
      if (std::fabs(off) < std::fabs(best)) best = off, found = true;
    }
    if (!found) continue;
    sum += best;
    ++offset.edges;
  }
  if (offset.edges > 0) offset.mean_deg = sum / static_cast<double>(offset.edges);
  return offset;
}

struct Residual {
  double rms_deg = 0;
  std::size_t pairs = 0, edges = 0;
};

/// Over the pairs of lasers that look almost equally high: how far the edges of the same objects lie apart.
Residual residual_of(const velodyne::ModelRow& row, const std::vector<std::vector<Sample>>& lasers) {
  constexpr double neighbours_deg = 0.25;
  constexpr std::size_t enough_edges = 50;
  std::vector<std::vector<Edge>> edges;
  for (const auto& samples : lasers) edges.push_back(edges_of(samples));
  Residual residual;
  double squares = 0;
  for (std::size_t a = 0; a < row.lasers; ++a) {
    for (std::size_t b = 0; b < row.lasers; ++b) {
      const double up = row.laser[b].elevation_deg - row.laser[a].elevation_deg;
      if (up <= 0 || up > neighbours_deg) continue;
      const Offset offset = offset_of(edges[a], edges[b]);
      if (offset.edges < enough_edges) continue;
      squares += offset.mean_deg * offset.mean_deg;
      residual.edges += offset.edges;
      ++residual.pairs;
    }
  }
  residual.rms_deg = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(residual.pairs, 1)));
  return residual;
}

Residual measure(const std::string& path, bool interpolated) {
  const Model& model = *find_model("velodyne_vls128");
  const auto& row = *static_cast<const velodyne::ModelRow*>(model.row);
  DriverConfig config;
  config.clock = ClockMode::arrival;
  config.keep_partial = config.keep_origins = true;
  auto decoded = test::decode_capture(path, "velodyne_vls128", config);
  Samples samples(row, interpolated);
  for (Cloud& cloud : decoded.output.clouds) samples.cloud(cloud);
  return residual_of(row, samples.lasers);
}

TEST(VelodyneAlignment, NeighbouringLasersOfAVls128SeeTheSameEdgesAtTheSameAzimuth) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vls128_strongest_2193.pcap");
  const Residual without = measure(path, false);
  const Residual ours = measure(path, true);
  std::printf("edge alignment: %.4f deg RMS over %zu pairs, %zu edges; %.4f deg without interpolation\n",
              ours.rms_deg, ours.pairs, ours.edges, without.rms_deg);
  EXPECT_GT(ours.pairs, 150U);
  EXPECT_GT(ours.edges, 20'000U);
  EXPECT_GT(without.rms_deg, 0.06) << "the measure sees what interpolation is for";
  EXPECT_LE(ours.rms_deg, 0.025);
}

/// The timing shows in the times within a packet: with a random rest, sequences begin a third of the way to
/// the next packet's stamp apart, 54.6 to 56.1 us; 53.3 us and 57.8 us are those of the other firmwares.
TEST(VelodyneAlignment, TheTimingVariantOfAVls128IsRightFromAnyStartPacketOn) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vls128_strongest_2193.pcap");
  std::vector<std::pair<std::vector<std::uint8_t>, Stamp>> packets;
  PcapSource source(path);
  Packet packet;
  while (source.next(packet))
    packets.emplace_back(std::vector<std::uint8_t>(packet.payload.begin(), packet.payload.end()),
                         packet.arrival);
  ASSERT_EQ(packets.size(), 2193U);
  DriverConfig config;
  config.model = find_model("velodyne_vls128");
  config.clock = ClockMode::arrival;
  config.keep_partial = true;
  for (std::size_t start = 0; start + 60 < packets.size(); ++start) {
    const auto driver = config.model->make(config);
    test::Collector out;
    for (std::size_t i = start; i < start + 4; ++i) {
      const ByteView payload(packets[i].first.data(), packets[i].first.size());
      driver->receive({payload, packets[i].second, {{}, 2368}, {{}, 2368}}, out);
    }
    driver->finish(out);
    std::size_t checked = 0;
    for (const Cloud& cloud : out.clouds) {
      for (std::size_t c = 1; c < cloud.columns.size(); ++c) {
        if (cloud.columns[c].packet != cloud.columns[c - 1].packet) continue;
        const Span step = cloud.columns[c].stamp - cloud.columns[c - 1].stamp;
        ASSERT_GT(seconds(step) * 1e6, 54.5) << start;
        ASSERT_LT(seconds(step) * 1e6, 56.2) << start;
        ++checked;
      }
    }
    ASSERT_GE(checked, 7U) << start;  // one step may be that from frame to frame
    ASSERT_EQ(driver->counters().lost_packets, 0U) << start;
  }
}

}  // namespace
}  // namespace lidard
