// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/frame_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <tuple>

#include "test/support/allocations.h"

namespace lidard {
namespace {

using ::testing::ElementsAre;

/// Columns of three returns each, but for every seventh, in which nothing came back.
Cloud random_cloud(std::size_t columns, double size_m) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(static_cast<float>(-size_m), static_cast<float>(size_m));
  std::vector<CloudPoint> points;
  Cloud cloud;
  for (std::size_t c = 0; c < columns; ++c) {
    CloudColumn column{};
    column.first_point = static_cast<std::uint32_t>(points.size());
    column.packet = static_cast<std::uint32_t>(c);
    cloud.columns.push_back(column);
    for (std::uint16_t ring = 0; ring < 3 && c % 7 != 6; ++ring) {
      points.push_back({place(random), place(random), place(random), static_cast<float>(points.size() % 256),
                        ring, static_cast<float>(c)});
      ReturnOrigin origin{};
      origin.laser = static_cast<std::uint16_t>(points.size());
      cloud.origins.push_back(origin);
    }
  }
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(points.data());
  cloud.points_bytes.assign(bytes, bytes + points.size() * sizeof(CloudPoint));
  return cloud;
}

/// The points of `cloud` for which `stays` holds, each with its column and its origin.
using Row = std::tuple<std::uint32_t, float, float, float, std::uint16_t>;
template <class Stays>
std::vector<Row> rows_of(const Cloud& cloud, Stays stays) {
  std::vector<Row> rows;
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    for (std::size_t i = cloud.columns[c].first_point; i < cloud.points_end(c); ++i) {
      const CloudPoint p = cloud.points()[i];
      if (stays(p))
        rows.emplace_back(cloud.columns[c].packet, p.x, p.intensity, p.time, cloud.origins[i].laser);
    }
  }
  return rows;
}
std::vector<Row> rows_of(const Cloud& cloud) {
  return rows_of(cloud, [](const CloudPoint&) { return true; });
}

TEST(FrameFilter, RemovesByIntensityAndKeepsEveryOtherReturnInItsColumn) {
  Cloud cloud = random_cloud(100, 10);
  const auto expected = rows_of(cloud, [](const CloudPoint& p) { return p.intensity >= 20; });
  FrameFilterSettings settings;
  settings.intensity_min = 20;
  FrameFilter filter(settings);
  const std::size_t before = cloud.size();
  filter.apply(cloud);
  EXPECT_EQ(rows_of(cloud), expected);
  EXPECT_EQ(cloud.columns.size(), 100U) << "a column that lost its returns is still one that was fired";
  EXPECT_EQ(filter.counters().returns, before);
  EXPECT_EQ(filter.counters().by_intensity, before - expected.size());
}

TEST(FrameFilter, KeepsABoxAndCutsOneOut) {
  Cloud cloud = random_cloud(200, 10);
  FrameFilterSettings settings;
  settings.box.emplace(Eigen::Vector3d(-20, -20, -3), Eigen::Vector3d(5, 20, 20));
  settings.cut_out.emplace(Eigen::Vector3d(-2, -1, -20), Eigen::Vector3d(2, 20, 20));
  const auto expected = rows_of(cloud, [](const CloudPoint& p) {
    return p.x <= 5 && p.z >= -3 && !(p.x >= -2 && p.x <= 2 && p.y >= -1);
  });
  FrameFilter filter(settings);
  const std::size_t before = cloud.size();
  filter.apply(cloud);
  EXPECT_EQ(rows_of(cloud), expected);
  EXPECT_EQ(filter.counters().by_box, before - expected.size());
}

TEST(FrameFilter, KeepsOfEachVoxelTheReturnNearestToItsCentre) {
  // 0.5 m divides 10 m and, as a number, has no rounding: both sides agree on the voxels.
  Cloud cloud = random_cloud(3000, 10);
  std::map<std::tuple<double, double, double>, std::pair<double, Row>> nearest;
  const auto all = rows_of(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint p = cloud.points()[i];
    const double x = std::floor(p.x / 0.5F), y = std::floor(p.y / 0.5F), z = std::floor(p.z / 0.5F);
    const double off = std::hypot(p.x / 0.5F - x - 0.5, p.y / 0.5F - y - 0.5, p.z / 0.5F - z - 0.5);
    const auto [at, is_new] = nearest.try_emplace({x, y, z}, off, all[i]);
    if (!is_new && off < at->second.first) at->second = {off, all[i]};
  }
  std::vector<Row> expected;
  for (const auto& [voxel, one] : nearest) expected.push_back(one.second);
  FrameFilterSettings settings;
  settings.voxel_size = 0.5;
  FrameFilter filter(settings);
  filter.apply(cloud);
  EXPECT_LT(expected.size(), all.size()) << "some voxels hold several returns";
  EXPECT_THAT(rows_of(cloud), ::testing::UnorderedElementsAreArray(expected));
  EXPECT_EQ(filter.counters().by_voxel, all.size() - expected.size());
}

TEST(FrameFilter, MixesNoVoxelsThatAreFarApart) {
  // As many cubes of 1 cm as a 32 bit number cannot count.
  Cloud cloud = random_cloud(2, 1);
  ASSERT_EQ(cloud.size(), 6U);
  const float far[] = {-999, -500, -0.001F, 0, 500, 999};
  for (std::size_t i = 0; i < 6; ++i)
    cloud.points()[i].x = cloud.points()[i].y = cloud.points()[i].z = far[i];
  FrameFilterSettings settings;
  settings.voxel_size = 0.01;
  FrameFilter filter(settings);
  filter.apply(cloud);
  EXPECT_EQ(cloud.size(), 6U);
}

/// Says that the points at even places have neighbours.
void even_ones(const CloudPoint* /*points*/, std::size_t count, double radius, int neighbours,
               std::uint8_t* inliers) {
  EXPECT_EQ(radius, 0.3);
  EXPECT_EQ(neighbours, 4);
  for (std::size_t i = 0; i < count; ++i) inliers[i] = i % 2 == 0;
}

TEST(FrameFilter, AsksForOutliersAmongWhatTheOthersLeft) {
  Cloud cloud = random_cloud(2, 10);
  FrameFilterSettings settings;
  settings.intensity_min = 1;  // the first of six returns has 0
  settings.outlier_radius = 0.3;
  settings.outlier_neighbours = 4;
  settings.find_inliers = even_ones;
  FrameFilter filter(settings);
  filter.apply(cloud);
  ASSERT_EQ(cloud.size(), 3U);
  EXPECT_EQ(cloud.points()[0].intensity, 1);
  EXPECT_EQ(cloud.points()[1].intensity, 3);
  EXPECT_EQ(cloud.points()[2].intensity, 5);
  EXPECT_EQ(filter.counters().by_intensity, 1U);
  EXPECT_EQ(filter.counters().outliers, 2U);
}

/// Three beams with two echoes: strong and weak, weak and strong, nothing.
PlanarScan two_echoes() {
  PlanarScan scan;
  scan.range_max = 30;
  scan.reset(3, 2, true);
  scan.set_angles(-0.5F, 0.5F);
  const float strong = 100, weak = 3;
  const auto put = [&](std::size_t beam, std::size_t echo, float range, float intensity) {
    scan.set_hit(scan.index(beam, echo), range);
    scan.intensities[scan.index(beam, echo)] = intensity;
  };
  put(0, 0, 5, strong);
  put(0, 1, 6, weak);
  put(1, 0, 2, weak);
  put(1, 1, 7, strong);
  scan.set_without_hit(scan.index(2), BeamStatus::none);
  scan.set_without_hit(scan.index(2, 1), BeamStatus::none);
  return scan;
}

TEST(FrameFilter, LeavesABeamItsOtherEchoes) {
  PlanarScan scan = two_echoes();
  FrameFilterSettings settings;
  settings.intensity_min = 10;
  FrameFilter filter(settings);
  filter.apply(scan);
  EXPECT_EQ(violation(scan), nullptr);
  using S = BeamStatus;
  EXPECT_THAT(scan.statuses, ElementsAre(S::hit, S::hit, S::none, S::invalid, S::invalid, S::none));
  EXPECT_EQ(scan.ranges[0], 5);
  EXPECT_EQ(scan.ranges[1], 7);
  EXPECT_EQ(scan.intensities[1], 100);
  EXPECT_EQ(filter.counters().returns, 4U);
  EXPECT_EQ(filter.counters().by_intensity, 2U);
  EXPECT_FALSE(filter.counters().has_no_intensities);
}

TEST(FrameFilter, MakesABeamInvalidThatLosesAllOfThem) {
  PlanarScan scan = two_echoes();
  FrameFilterSettings settings;
  settings.box.emplace(Eigen::Vector3d(-20, -20, -1),
                       Eigen::Vector3d(20, -1, 1));  // only the first beam looks to the right
  FrameFilter filter(settings);
  filter.apply(scan);
  using S = BeamStatus;
  EXPECT_EQ(violation(scan), nullptr);
  EXPECT_THAT(scan.statuses, ElementsAre(S::hit, S::invalid, S::none, S::hit, S::invalid, S::none));
  EXPECT_EQ(filter.counters().by_box, 2U);
}

TEST(FrameFilter, ABeamThatLosesItsOnlyEchoIsNotFree) {
  PlanarScan scan = two_echoes();
  scan.set_without_hit(scan.index(0, 1), BeamStatus::none);
  FrameFilterSettings settings;
  settings.intensity_min = 1000;
  FrameFilter(settings).apply(scan);
  using S = BeamStatus;
  EXPECT_THAT(scan.statuses, ElementsAre(S::invalid, S::invalid, S::none, S::invalid, S::invalid, S::none));
}

TEST(FrameFilter, SaysThatItHasNoIntensitiesToGoBy) {
  PlanarScan scan = two_echoes();
  scan.intensities.clear();
  FrameFilterSettings settings;
  settings.intensity_min = 10;
  FrameFilter filter(settings);
  filter.apply(scan);
  EXPECT_TRUE(filter.counters().has_no_intensities);
  EXPECT_EQ(filter.counters().by_intensity, 0U);
  EXPECT_EQ(scan.statuses[0], BeamStatus::hit);
  PlanarScan with = two_echoes();
  filter.apply(with);
  EXPECT_FALSE(filter.counters().has_no_intensities) << "the device was told to send them";
}

TEST(FrameFilter, CountsFramesThatLoseEverythingUntilOneDoesNot) {
  FrameFilterSettings settings;
  settings.intensity_min = 200;
  FrameFilter filter(settings);
  for (std::uint64_t frames = 1; frames < 4; ++frames) {
    PlanarScan scan = two_echoes();
    filter.apply(scan);
    EXPECT_EQ(filter.counters().emptied_in_a_row, frames);
  }
  PlanarScan empty = two_echoes();
  empty.reset(3, 2, true);
  filter.apply(empty);
  EXPECT_EQ(filter.counters().emptied_in_a_row, 3U) << "a frame without returns says nothing";
  PlanarScan strong = two_echoes();
  strong.intensities[0] = 255;
  filter.apply(strong);
  EXPECT_EQ(filter.counters().emptied_in_a_row, 0U);
}

TEST(FrameFilter, AllocatesNothingAfterTheFirstFrame) {
  FrameFilterSettings settings;
  settings.intensity_min = 20;
  settings.voxel_size = 0.2;
  settings.outlier_radius = 0.3;
  settings.outlier_neighbours = 4;
  settings.find_inliers = even_ones;
  FrameFilter filter(settings);
  const Cloud cloud = random_cloud(500, 5);
  const PlanarScan scan = two_echoes();
  Cloud used = cloud;
  PlanarScan used_scan = scan;
  std::uint64_t before = 0;
  for (int i = 0; i < 5; ++i) {
    used.points_bytes.assign(cloud.points_bytes.begin(), cloud.points_bytes.end());
    used.columns = cloud.columns;
    used.origins = cloud.origins;
    used_scan = scan;
    filter.apply(used);
    filter.apply(used_scan);
    if (i == 0) before = test::allocations();
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace lidard
