// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using sim::AzimuthSector;
using test::Columns;
using test::ModelMode;
using test::WirePacket;

constexpr double deg = M_PI / 180;
constexpr double start_deg = 211.4;

DriverConfig config_of(const ModelMode& which, double cut_deg) {
  DriverConfig config;
  config.model = find_model(which.model);
  config.clock = ClockMode::arrival;
  config.cut_angle = cut_deg * deg;
  config.keep_partial = true;
  return config;
}

std::vector<WirePacket> stream_of(const ModelMode& which, double turns,
                                  const std::optional<AzimuthSector>& view = std::nullopt) {
  sim::VelodyneOptions options;
  options.start_azimuth_deg = start_deg;
  options.fov = view;
  options.rest_spread_ns = 0;
  return test::spin(which, turns, options);
}

Columns play(const DriverConfig& config, const std::vector<WirePacket>& packets, double drop = 0) {
  std::mt19937 random(11);
  std::bernoulli_distribution dropped(drop);
  const auto driver = config.model->make(config);
  Columns out;
  for (const WirePacket& packet : packets) {
    if (!dropped(random)) give(*driver, packet, out);
  }
  driver->finish(out);
  EXPECT_EQ(driver->counters().rejected_total(), 0U);
  return out;
}

/// Packet, block and return of a column tell which firing it is, up to the two sequences of a VLP-16's block.
void expect_each_firing_once(const ModelMode& which, const Columns& out, std::size_t packets) {
  const std::size_t echoes = which.is_dual() ? 2 : 1;
  std::size_t columns = 0;
  std::uint32_t last_packet = 0;
  Stamp last_stamp{0};
  for (const Columns::Frame& frame : out.frames) {
    ASSERT_FALSE(frame.columns.empty());
    for (const CloudColumn& column : frame.columns) {
      ASSERT_GE(column.packet, last_packet);
      // Within a packet the firings follow each other; between packets the arrivals shift them a little.
      if (column.packet == last_packet && columns > 0) {
        ASSERT_GE(column.stamp, last_stamp);
        if (column.echo == 0) {
          ASSERT_GT(column.stamp, last_stamp);
        }
      }
      last_packet = column.packet;
      last_stamp = column.stamp;
      ++columns;
    }
  }
  EXPECT_EQ(columns, packets * which.sequences() * echoes);
  EXPECT_EQ(out.points, packets * which.sequences() * echoes * which.table().lasers_per_sequence());
}

/// No frame goes over the cut; whole ones begin and end at it.
void expect_cut_at(const ModelMode& which, const Columns& out, double cut_deg) {
  const double step = which.turn_deg();
  for (const Columns::Frame& frame : out.frames) {
    double last = -1;
    for (const CloudColumn& column : frame.columns) {
      const double since_cut = std::fmod(column.azimuth / deg - cut_deg + 720.0005, 360);
      ASSERT_GE(since_cut, last - 1e-3);
      last = since_cut;
    }
  }
  std::size_t whole = 0;
  for (const Columns::Frame& frame : out.frames) whole += frame.complete ? 1U : 0U;
  EXPECT_GT(whole, 0U);
  for (const Columns::Frame& frame : out.frames) {
    if (!frame.complete) continue;
    const double edge = step + 0.001;
    EXPECT_LT(std::fmod(frame.columns.front().azimuth / deg - cut_deg + 720.0005, 360), edge);
    EXPECT_GT(std::fmod(frame.columns.back().azimuth / deg - cut_deg + 720.0005, 360), 360 - edge);
  }
}

TEST(VelodyneFrames, EachFiringIsInExactlyOneFrameForEveryCutAngleModelAndMode) {
  for (const ModelMode& which : test::model_modes()) {
    const auto packets = stream_of(which, 2.3);
    // Each a few degrees, so that the cut also falls between the sequences of a packet, and the edges.
    std::set<double> cuts = {0, 0.1, 359, 359.99, start_deg, start_deg - 0.01};
    for (int cut = 7; cut < 360; cut += which.table().lasers.size() < 64 ? 7 : 29) cuts.insert(cut);
    for (const double cut : cuts) {
      SCOPED_TRACE(which.name() + " cut " + std::to_string(cut));
      const Columns out = play(config_of(which, cut), packets);
      expect_each_firing_once(which, out, packets.size());
      expect_cut_at(which, out, cut);
      if (testing::Test::HasFailure()) return;
    }
  }
}

TEST(VelodyneFrames, EachFiringThatCameIsInExactlyOneFrameWhateverWasLost) {
  for (const ModelMode& which : test::model_modes()) {
    const auto packets = stream_of(which, 3.3);
    for (const double drop : {0.01, 0.1, 0.5}) {
      SCOPED_TRACE(which.name() + " dropped " + std::to_string(drop));
      DriverConfig config = config_of(which, 123);
      const Columns out = play(config, packets, drop);
      std::size_t columns = 0;
      for (const Columns::Frame& frame : out.frames) columns += frame.columns.size();
      EXPECT_EQ(out.points, columns * which.table().lasers_per_sequence());
      EXPECT_EQ(columns % (which.sequences() * (which.is_dual() ? 2 : 1)), 0U);
      for (const Columns::Frame& frame : out.frames) {
        double last = -1;
        for (const CloudColumn& column : frame.columns) {
          const double since_cut = std::fmod(column.azimuth / deg - 123 + 720.0005, 360);
          ASSERT_GE(since_cut, last - 1e-3);
          last = since_cut;
        }
      }
    }
  }
}

/// A field of view hides the cut angle in some of these.
const std::vector<AzimuthSector> views = {{270, 90}, {10.05, 150.15}, {185, 174}, {40, 70}};

/// Of an HDL-64E S1 no field of view is known; last return is sent like the strongest.
bool knows_view(const ModelMode& which) {
  return which.model != "velodyne_hdl64e_s1" && which.mode != sim::ReturnMode::last;
}

TEST(VelodyneFrames, ACutInTheSectorThatTheSensorLeavesOutSplitsNoRevolution) {
  for (const ModelMode& which : test::model_modes()) {
    if (!knows_view(which)) continue;
    for (const AzimuthSector& view : views) {
      SCOPED_TRACE(which.name() + " from " + std::to_string(view.start_deg));
      const double visible_deg = std::fmod(view.end_deg - view.start_deg + 360, 360);
      const auto packets = stream_of(which, 5.4, view);
      const Columns out = play(config_of(which, view.start_deg - (360 - visible_deg) / 2), packets);
      expect_each_firing_once(which, out, packets.size());
      std::size_t whole = 0;
      for (const Columns::Frame& frame : out.frames) {
        if (!frame.complete) continue;
        ++whole;
        const auto since_begin = [&](const CloudColumn& column) {
          return std::fmod(column.azimuth / deg - view.start_deg + 360.001, 360);
        };
        EXPECT_LT(since_begin(frame.columns.front()), which.turn_deg() + 0.2);
        EXPECT_GT(since_begin(frame.columns.back()), visible_deg - which.turn_deg() - 0.2);
      }
      EXPECT_GE(whole, 3U);
    }
  }
}

}  // namespace
}  // namespace lidard
