// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/cloud_layout.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "test/support/allocations.h"

namespace lidard {
namespace {

constexpr std::int64_t ms = 1'000'000;

/// Three firing sequences of four lasers, the third a second return of the second one's firing:
/// rings 2 and 0; ring 3; rings 1 and 3.
Cloud sample_cloud() {
  Cloud cloud;
  cloud.frame_id = "velodyne";
  cloud.stamp = Stamp{1000 * ms};
  cloud.end = Stamp{1010 * ms};
  cloud.rings = 4;
  const CloudPoint points[] = {{1, 2, 3, 10, 2, 0.0F},
                               {4, 5, 6, 20, 0, 0.001F},
                               {7, 8, 9, 30, 3, 0.012F},
                               {1, 1, 1, 40, 1, 0.011F},
                               {2, 2, 2, 50, 3, 0.012F}};
  cloud.points_bytes.resize(sizeof points);
  std::memcpy(cloud.points_bytes.data(), points, sizeof points);
  cloud.columns = {{0, 0, 0, 0, 0.1F, Stamp{1000 * ms}},
                   {2, 0, 1, 0, 0.2F, Stamp{1010 * ms}},
                   {3, 0, 2, 1, 0.2F, Stamp{1010 * ms}}};
  return cloud;
}

CloudPoint point_at(const Cloud& cloud, std::size_t slot) {
  CloudPoint point;
  std::memcpy(&point, cloud.points_bytes.data() + slot * sizeof point, sizeof point);
  return point;
}

CloudLayout with_order(CloudOrder order) {
  CloudLayout layout;
  layout.order = order;
  return layout;
}

TEST(CloudArranger, HasNothingToDoForTheDefault) {
  EXPECT_TRUE(CloudArranger({}).is_plain());
  EXPECT_FALSE(CloudArranger(with_order(CloudOrder::ring_rows)).is_plain());
  CloudLayout last;
  last.stamp = FrameStamp::last;
  EXPECT_FALSE(CloudArranger(last).is_plain());
}

TEST(CloudArranger, GivesARowToEachRingAndAColumnToEachReturnOfAFiring) {
  CloudArranger arranger(with_order(CloudOrder::ring_rows));
  const Cloud source = sample_cloud();
  const Cloud& made = arranger.arrange(source);
  EXPECT_EQ(made.height, 4U);
  ASSERT_EQ(made.size(), 12U);
  const int expected[4][3] = {{20, -1, -1}, {-1, -1, 40}, {10, -1, -1}, {-1, 30, 50}};
  const float begins[] = {0, 0.010F, 0.010F};
  for (std::size_t ring = 0; ring < 4; ++ring) {
    for (std::size_t column = 0; column < 3; ++column) {
      const CloudPoint point = point_at(made, ring * 3 + column);
      SCOPED_TRACE(std::to_string(ring) + " " + std::to_string(column));
      EXPECT_EQ(point.ring, ring);
      if (expected[ring][column] >= 0) {
        EXPECT_EQ(point.intensity, static_cast<float>(expected[ring][column]));
        EXPECT_TRUE(std::isfinite(point.x));
        continue;
      }
      EXPECT_TRUE(std::isnan(point.x) && std::isnan(point.y) && std::isnan(point.z) &&
                  std::isnan(point.intensity));
      EXPECT_FLOAT_EQ(point.time, begins[column]);
    }
  }
  EXPECT_EQ(source.size(), 5U) << "the source stays as it is";
}

TEST(CloudArranger, GivesARowToEachFiringWhereThatIsAskedFor) {
  CloudArranger arranger(with_order(CloudOrder::firing_rows));
  const Cloud& made = arranger.arrange(sample_cloud());
  EXPECT_EQ(made.height, 3U);
  ASSERT_EQ(made.size(), 12U);
  EXPECT_EQ(point_at(made, 0).intensity, 20);
  EXPECT_EQ(point_at(made, 2).intensity, 10);
  EXPECT_EQ(point_at(made, 4 + 3).intensity, 30);
  EXPECT_EQ(point_at(made, 8 + 1).intensity, 40);
  for (std::size_t slot = 0; slot < 12; ++slot) EXPECT_EQ(point_at(made, slot).ring, slot % 4);
}

TEST(CloudArranger, StampsTheLastFiringAndCountsTimesBackFromIt) {
  CloudLayout layout;
  layout.stamp = FrameStamp::last;
  CloudArranger arranger(layout);
  const Cloud& made = arranger.arrange(sample_cloud());
  EXPECT_NEAR(static_cast<double>(made.stamp.ns), 1012e6, 2);
  ASSERT_EQ(made.size(), 5U);
  float last = -1;
  for (std::size_t i = 0; i < made.size(); ++i) {
    EXPECT_LE(point_at(made, i).time, 0);
    last = std::max<float>(last, point_at(made, i).time);
  }
  EXPECT_EQ(last, 0);
  EXPECT_NEAR(point_at(made, 1).time, -0.011, 1e-7);
}

TEST(CloudArranger, LeavesACloudWithoutColumnsAList) {
  CloudArranger arranger(with_order(CloudOrder::ring_rows));
  Cloud source = sample_cloud();
  source.columns.clear();
  const Cloud& made = arranger.arrange(source);
  EXPECT_EQ(made.height, 0U);
  ASSERT_EQ(made.size(), 5U);
  EXPECT_EQ(point_at(made, 1).intensity, 20);
}

TEST(CloudArranger, AllocatesNothingOnceTheLargestCloudWasSeen) {
  CloudLayout layout = with_order(CloudOrder::ring_rows);
  layout.stamp = FrameStamp::last;
  CloudArranger arranger(layout);
  const Cloud source = sample_cloud();
  arranger.arrange(source);
  const auto before = test::allocations();
  for (int i = 0; i < 10; ++i) arranger.arrange(source);
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace lidard
