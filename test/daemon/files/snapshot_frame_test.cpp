// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A picture shows a cloud where it is, whatever frame the cloud is published in.
#include <gtest/gtest.h>

#include "daemon/files/snapshot_view.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/capture/pcap_source.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

SnapshotView view_with(const std::string& keys) {
  const Config config = parse_config(
      "sensors: {roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, frame_id: velodyne, "
      "pose: {xyz: [0.5, 0, 2], rpy_deg: [0, 5, 90]}" +
          keys + "}}",
      "f");
  NoTransforms poses;
  FrameTree frames(config.vehicle.base_frame, fixed_poses(config), poses);
  FrameKeeper keeper;
  Pipeline pipeline(config, poses, keeper);
  PcapSource source(test::project_file("pcaps/demo.pcap"));
  Packet packet;
  for (int i = 0; i < 1000 && source.next(packet); ++i) pipeline.packet(packet);
  return make_view(config, frames, keeper, {});
}

TEST(SnapshotFrame, ACloudInTheFrameOfTheVehicleLooksLikeOneInTheLidars) {
  const SnapshotView own = view_with(""), moved = view_with(", points_frame: base_link");
  ASSERT_EQ(own.layers.size(), 1U);
  ASSERT_EQ(moved.layers.size(), 1U);
  const auto& a = own.layers[0];
  const auto& b = moved.layers[0];
  ASSERT_GT(a.points.size(), 10000U);
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    ASSERT_LT((a.points[i] - b.points[i]).norm(), 1e-4F);
    ASSERT_NEAR(a.values[i], b.values[i], 1e-4F);
  }
  ASSERT_EQ(moved.sensors.size(), 1U);
  EXPECT_EQ(moved.sensors[0].at, Eigen::Vector2d(0.5, 0)) << "the lidar stands where it is mounted";
}

}  // namespace
}  // namespace lidard
