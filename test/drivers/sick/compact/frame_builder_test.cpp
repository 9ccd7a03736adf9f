// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <random>

#include "test/drivers/sick/compact/segment_bench.h"
#include "test/support/allocations.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;

/// Every beam but those of one segment holds the bench's distance.
void expect_beams(const PlanarScan& scan, int lost_segment = -1) {
  for (std::size_t b = 0; b < scan.beams; ++b) {
    if (static_cast<int>(b / 60) == lost_segment) {
      EXPECT_EQ(scan.statuses[b], BeamStatus::invalid) << b;
    } else {
      ASSERT_EQ(scan.statuses[b], BeamStatus::hit) << b;
      EXPECT_NEAR(scan.ranges[b], 2 + 0.001 * static_cast<double>(b), 1e-6) << b;
    }
  }
}

TEST(FrameBuilder, AWholeFrameIsReleasedByItsLastSegment) {
  for (const std::uint32_t version : {3U, 4U, 0U}) {
    SegmentBench bench;
    bench.version = version;
    bench.send_frame(0);
    bench.send_frame(1);
    EXPECT_EQ(bench.scans.size(), 0U);  // how many segments a frame has is not known yet
    bench.send(2, 0);
    ASSERT_EQ(bench.scans.size(), 1U);
    for (int i = 1; i < 9; ++i) bench.send(2, i);
    EXPECT_EQ(bench.scans.size(), 1U);
    bench.send(2, 9);
    ASSERT_EQ(bench.scans.size(), 2U);
    for (const PlanarScan& scan : bench.scans) {
      expect_geometry(scan);
      expect_beams(scan);
    }
    EXPECT_EQ(bench.driver->counters().frames, 2U);
    EXPECT_EQ(bench.driver->counters().partial_frames, 1U);
    EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
    EXPECT_EQ(bench.driver->info().serial, "23370016");
  }
}

// Each segment announces its angles as rounded floats: a program that was started in the middle of a frame
// gives the scans of one that heard all.
TEST(FrameBuilder, TheSegmentThatCameFirstChangesNothingInAScan) {
  for (const std::uint32_t version : {4U, 0U}) {
    std::vector<PlanarScan> whole;
    for (int first = 0; first < SegmentBench::segments; ++first) {
      SegmentBench bench;
      bench.version = version;
      for (int i = first; i < SegmentBench::segments; ++i) bench.send(0, i);
      for (std::uint64_t f = 1; f < 5; ++f) bench.send_frame(f);
      if (first == 0) whole = bench.scans;
      ASSERT_EQ(bench.scans.size(), whole.size()) << first;
      for (std::size_t i = 0; i < whole.size(); ++i) {
        EXPECT_EQ(bench.scans[i].angle_min, whole[i].angle_min) << first;
        EXPECT_EQ(bench.scans[i].angle_max, whole[i].angle_max) << first;
        EXPECT_EQ(bench.scans[i].angle_increment, whole[i].angle_increment) << first;
        EXPECT_EQ(bench.scans[i].time_increment, whole[i].time_increment) << first;
        EXPECT_EQ(bench.scans[i].ranges, whole[i].ranges) << first;
      }
    }
  }
}

TEST(FrameBuilder, StampIsThatOfTheFirstBeam) {
  SegmentBench bench;
  for (std::uint64_t f = 0; f < 20; ++f) bench.send_frame(f);
  ASSERT_EQ(bench.scans.size(), 19U);
  for (std::size_t i = 0; i < bench.scans.size(); ++i) {
    const PlanarScan& scan = bench.scans[i];
    // All telegrams take 2 ms, which cannot be told from a slow clock.
    const Stamp first = bench.host_of(bench.time_us(i + 1, 0)) + std::chrono::milliseconds(2);
    EXPECT_NEAR(seconds(scan.stamp - first), 0, 2e-6);
    EXPECT_NEAR(static_cast<double>(scan.time_increment), bench.beam_us() * 1e-6, 1e-8);
    EXPECT_NEAR(static_cast<double>(scan.scan_time), 0.05, 1e-5);
  }
}

TEST(FrameBuilder, ALostSegmentIsUnobservedInItsPlace) {
  for (int lost = 0; lost < SegmentBench::segments; ++lost) {
    SegmentBench bench;
    for (std::uint64_t f = 0; f < 3; ++f) bench.send_frame(f);
    bench.send_frame(3, lost);
    bench.send_frame(4);
    ASSERT_EQ(bench.scans.size(), 4U) << lost;
    expect_geometry(bench.scans[2]);
    expect_beams(bench.scans[2], lost);
    const Stamp first = bench.host_of(bench.time_us(3, 0)) + std::chrono::milliseconds(2);
    EXPECT_NEAR(seconds(bench.scans[2].stamp - first), 0, 5e-6) << lost;
    expect_beams(bench.scans[3]);
    EXPECT_EQ(bench.driver->counters().lost_packets, 1U);
  }
}

TEST(FrameBuilder, AFrameWhoseEndIsLostIsReleasedByTheClock) {
  SegmentBench bench;
  for (std::uint64_t f = 0; f < 3; ++f) bench.send_frame(f);
  bench.send_frame(3, 9);
  ASSERT_EQ(bench.scans.size(), 2U);
  bench.driver->tick(bench.arrival(3, 8) + std::chrono::milliseconds(5), bench);
  EXPECT_EQ(bench.scans.size(), 2U);
  bench.driver->tick(bench.arrival(3, 8) + std::chrono::milliseconds(100), bench);
  ASSERT_EQ(bench.scans.size(), 3U);
  expect_beams(bench.scans[2], 9);
}

TEST(FrameBuilder, TelegramsMayOvertakeEachOther) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    SegmentBench bench;
    std::mt19937 random(seed);
    std::vector<std::pair<std::uint64_t, int>> order;
    for (std::uint64_t f = 0; f < 6; ++f) {
      for (int i = 0; i < SegmentBench::segments; ++i) order.emplace_back(f, i);
    }
    // From the fourth frame on, neighbours swap places.
    std::size_t swaps = 0;
    for (std::size_t i = 31; i + 1 < order.size(); i += 2) {
      if (random() % 2 == 0) continue;
      std::swap(order[i], order[i + 1]);
      ++swaps;
    }
    for (const auto& [frame, index] : order) bench.send(frame, index);
    bench.driver->finish(bench);
    EXPECT_EQ(bench.driver->counters().reordered, swaps) << seed;
    EXPECT_EQ(bench.driver->counters().lost_packets, 0U) << seed;
    EXPECT_EQ(bench.driver->counters().rejected_total(), 0U) << seed;
    ASSERT_EQ(bench.scans.size(), 5U) << seed;
    for (const PlanarScan& scan : bench.scans) expect_beams(scan);
  }
}

TEST(FrameBuilder, DoubledTelegramsAreCountedAndChangeNothing) {
  SegmentBench bench;
  for (std::uint64_t f = 0; f < 4; ++f) {
    for (int i = 0; i < SegmentBench::segments; ++i) {
      bench.send(f, i);
      EXPECT_EQ(bench.send(f, i), Reject::duplicate);
    }
  }
  ASSERT_EQ(bench.scans.size(), 3U);
  for (const PlanarScan& scan : bench.scans) expect_beams(scan);
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
}

TEST(FrameBuilder, AnyLossLeavesGeometryAndTimesAsTheyAre) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SegmentBench bench;
    std::mt19937 random(seed);
    std::uint64_t lost = 0;
    for (std::uint64_t f = 0; f < 40; ++f) {
      for (int i = 0; i < SegmentBench::segments; ++i) {
        const bool keep = f < 3 || f == 39 || random() % 5 != 0;
        if (keep) bench.send(f, i);
        if (!keep) ++lost;
      }
    }
    bench.driver->finish(bench);
    EXPECT_EQ(bench.driver->counters().lost_packets, lost);
    std::size_t missing = 0;
    Stamp before;
    for (const PlanarScan& scan : bench.scans) {
      expect_geometry(scan);
      EXPECT_GT(scan.stamp, before);
      before = scan.stamp;
      for (std::size_t b = 0; b < scan.beams; ++b) {
        if (scan.statuses[b] == BeamStatus::invalid)
          ++missing;
        else
          ASSERT_NEAR(scan.ranges[b], 2 + 0.001 * static_cast<double>(b), 1e-6);
      }
    }
    EXPECT_EQ(bench.scans.size(), 39U) << seed;
    EXPECT_GT(missing, 0U);
    EXPECT_FALSE(bench.has_warning("changed"));
  }
}

/// Hides the beams outside [first, last] as a device's angle filter does.
sim::SickSegment filtered(const SegmentBench& bench, std::uint64_t frame, int index, std::size_t first,
                          std::size_t last) {
  sim::SickSegment segment = bench.segment(frame, index);
  auto& beams = segment.modules[0][0].beams;
  for (std::size_t b = 0; b < beams.size(); ++b) {
    const std::size_t beam = static_cast<std::size_t>(index) * 60 + b;
    if (beam < first || beam > last) beams[b].echoes[0] = {0, 0};
  }
  // Every fifth beam meets nothing.
  for (std::size_t b = 0; b < beams.size(); b += 5) beams[b].echoes[0] = {0, 0};
  return segment;
}

TEST(FrameBuilder, BeamsThatTheDevicesFilterHidesAreNotFree) {
  SegmentBench bench;
  std::uint64_t counter = 1;
  for (std::uint64_t f = 0; f < 4; ++f) {
    for (int i = 2; i < 7; ++i) {  // the others are hidden altogether and are not sent
      sim::SickSegment segment = filtered(bench, f, i, 131, 401);
      segment.counter = counter++;
      bench.send(bench.encode(segment), bench.arrival(f, i));
    }
  }
  ASSERT_EQ(bench.scans.size(), 3U);
  for (const PlanarScan& scan : bench.scans) {
    ASSERT_EQ(scan.beams, 300U);
    EXPECT_NEAR(static_cast<double>(scan.angle_min) / bench_rad, -78, 1e-3);
    EXPECT_EQ(scan.statuses[0], BeamStatus::invalid);
    EXPECT_EQ(scan.statuses[10], BeamStatus::invalid);
    EXPECT_EQ(scan.statuses[11], BeamStatus::hit);
    EXPECT_EQ(scan.statuses[15], BeamStatus::none);
    EXPECT_EQ(scan.statuses[281], BeamStatus::hit);
    EXPECT_EQ(scan.statuses[282], BeamStatus::invalid);
    EXPECT_EQ(scan.statuses[299], BeamStatus::invalid);
    EXPECT_EQ(unobserved(scan), 11U + 18U);
  }
}

TEST(FrameBuilder, BeamsThatTheFilterHidesLaterAreNotFreeForLong) {
  SegmentBench bench;
  for (std::uint64_t f = 0; f < 80; ++f) {
    for (int i = 0; i < 10; ++i)  // from the fifth frame on the filter hides 40 beams
      bench.send(bench.encode(filtered(bench, f, i, f < 5 ? 0 : 40, 552)), bench.arrival(f, i));
  }
  EXPECT_EQ(bench.scans.at(3).statuses[1], BeamStatus::hit);
  for (std::size_t beam = 0; beam < 40; ++beam)
    EXPECT_EQ(bench.scans.back().statuses[beam], BeamStatus::invalid) << beam;
  EXPECT_EQ(bench.scans.back().statuses[45], BeamStatus::none);
}

TEST(FrameBuilder, WithoutEchoOnlyTheOutermostSegmentsMayBeHidden) {
  SegmentBench bench;
  for (std::uint64_t f = 0; f < 4; ++f) {
    for (int i = 0; i < 10; ++i)  // the first and the last segment and ten beams beside them see nothing
      bench.send(bench.encode(filtered(bench, f, i, 70, 529)), bench.arrival(f, i));
  }
  ASSERT_FALSE(bench.scans.empty());
  const auto& statuses = bench.scans.back().statuses;
  EXPECT_EQ(statuses[59], BeamStatus::invalid);
  EXPECT_EQ(statuses[60], BeamStatus::none);
  EXPECT_EQ(statuses[539], BeamStatus::none);
  EXPECT_EQ(statuses[540], BeamStatus::invalid);
}

TEST(FrameBuilder, FramesThatGrowBecomeTheNewGeometryAndAWarning) {
  SegmentBench bench;
  std::uint64_t counter = 1;
  const auto send = [&](std::uint64_t frame, int from, int to) {
    for (int i = from; i < to; ++i) {
      sim::SickSegment segment = bench.segment(frame, i);
      segment.counter = counter++;
      bench.send(bench.encode(segment), bench.arrival(frame, i));
    }
  };
  for (std::uint64_t f = 0; f < 3; ++f) send(f, 2, 5);
  EXPECT_EQ(bench.scans.back().beams, 180U);
  for (std::uint64_t f = 3; f < 7; ++f) send(f, 0, 10);
  expect_geometry(bench.scans.back());
  expect_beams(bench.scans.back());
  EXPECT_TRUE(bench.has_warning("the device changed from"));
  for (std::uint64_t f = 7; f < 10; ++f) send(f, 2, 5);
  EXPECT_EQ(bench.scans.back().beams, 180U);
}

TEST(FrameBuilder, OneEchoIsTheNearestAndAllComeWhenAskedFor) {
  for (const bool multi : {false, true}) {
    DriverConfig config;
    config.publish_multiecho = multi;
    SegmentBench bench("sick_picoscan150", config);
    bench.echoes = 3;
    for (std::uint64_t f = 0; f < 3; ++f) bench.send_frame(f);
    ASSERT_EQ(bench.scans.size(), 2U);
    const PlanarScan& scan = bench.scans[0];
    ASSERT_EQ(scan.echoes, multi ? 3U : 1U);
    EXPECT_NEAR(scan.ranges[scan.index(7)], 2.007, 1e-6);
    EXPECT_EQ(scan.intensities[scan.index(7)], 5000);
    if (!multi) continue;
    EXPECT_NEAR(scan.ranges[scan.index(8, 2)], 4.008, 1e-6);
    EXPECT_EQ(scan.intensities[scan.index(8, 2)], 300);
    EXPECT_EQ(scan.statuses[scan.index(7, 1)], BeamStatus::none);
  }
}

TEST(FrameBuilder, ReflectorsMakeAScanOfTheirOwn) {
  SegmentBench bench;
  bench.echoes = 3;
  for (std::uint64_t f = 0; f < 3; ++f) {
    for (int i = 0; i < SegmentBench::segments; ++i) {
      sim::SickSegment segment = bench.segment(f, i);
      if (i == 3) segment.modules[0][0].beams[5].reflector = segment.modules[0][0].beams[4].reflector = true;
      bench.send(bench.encode(segment), bench.arrival(f, i));
    }
  }
  ASSERT_EQ(bench.extra_scans["reflectors"].size(), 2U);
  const PlanarScan& marked = bench.extra_scans["reflectors"][1];
  EXPECT_EQ(marked.stamp, bench.scans[1].stamp);
  EXPECT_EQ(marked.beams, SegmentBench::all_beams);
  EXPECT_EQ(unobserved(marked), SegmentBench::all_beams - 2);
  EXPECT_NEAR(marked.ranges[184], 4.184, 1e-6) << "of its three echoes the last one";
  EXPECT_EQ(marked.intensities[184], 300);
  EXPECT_NEAR(marked.ranges[185], 2.185, 1e-6) << "its only echo";
  EXPECT_EQ(marked.intensities[185], 5000);
}

TEST(FrameBuilder, RangesOutsideTheModelsLimitsAreNoHits) {
  SegmentBench bench;
  for (std::uint64_t f = 0; f < 3; ++f) {
    for (int i = 0; i < SegmentBench::segments; ++i) {
      sim::SickSegment segment = bench.segment(f, i);
      segment.scale = 4;
      segment.modules[0][0].beams[0].echoes[0].mm = 4;
      segment.modules[0][0].beams[1].echoes[0].mm = 200'000;
      segment.modules[0][0].beams[2].echoes[0].mm = 100'000;
      bench.send(bench.encode(segment), bench.arrival(f, i));
    }
  }
  const PlanarScan& scan = bench.scans.at(1);
  EXPECT_EQ(scan.statuses[60], BeamStatus::near);
  EXPECT_EQ(scan.statuses[61], BeamStatus::none);
  EXPECT_NEAR(scan.ranges[62], 100, 1e-4);
}

TEST(FrameBuilder, NothingIsAllocatedPerScanAfterWarmUp) {
  for (const std::uint32_t version : {4U, 0U}) {
    DriverConfig config;
    config.publish_multiecho = true;
    SegmentBench bench("sick_picoscan150", config);
    bench.version = version;
    bench.echoes = 3;
    std::vector<std::vector<std::uint8_t>> telegrams;
    for (std::uint64_t f = 0; f < 40; ++f) {
      for (int i = 0; i < SegmentBench::segments; ++i) telegrams.push_back(bench.encode(bench.segment(f, i)));
    }
    bench.keep = false;
    std::uint64_t before = 0;
    for (std::size_t n = 0; n < telegrams.size(); ++n) {
      if (n == 100) before = allocations();
      bench.send(telegrams[n], bench.arrival(n / 10, static_cast<int>(n % 10)));
    }
    EXPECT_EQ(allocations() - before, 0U);
    EXPECT_EQ(bench.released, 39U);
  }
}

}  // namespace
}  // namespace lidard::sick
