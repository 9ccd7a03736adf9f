// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Virtual scans of devices that do not fire all planes at once, from their packets on: against the walls of
// a room.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/core/virtual/cut_bench.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"
#include "test/support/collector.h"

namespace lidard {
namespace {

using namespace test::cut;

/// 6 m to the wall ahead, 4 m to those beside, 5 m to that behind, and a box 0.9 m high; nothing overhead.
/// Coordinates are the sensor's, which stands `height` above the ground.
std::string room(double height) {
  const std::string z = std::to_string(-height);
  const std::string box_z = std::to_string(0.45 - height);
  return "ground: {z: " + z + "}\nobjects:\n  - wall: {from: [6, -4], to: [6, 4], z: [" + z +
         ", 2]}\n  - wall: {from: [6, 4], to: [-5, 4], z: [" + z +
         ", 2]}\n  - wall: {from: [-5, 4], to: [-5, -4], z: [" + z +
         ", 2]}\n  - wall: {from: [-5, -4], to: [6, -4], z: [" + z + ", 2]}\n  - box: {center: [3, 1.5, " +
         box_z + "], size: [0.6, 0.8, 0.9]}\n";
}

/// Walls on the ground at 10 m on all sides and one at 5.5 m behind, up to `top` m above it.
std::string walls(double height, double top) {
  const std::string z = ", z: [" + std::to_string(-height) + ", " + std::to_string(top - height) + "]}\n";
  return "ground: {z: " + std::to_string(-height) + "}\nobjects:\n  - wall: {from: [10, -10], to: [10, 10]" +
         z + "  - wall: {from: [-5.5, -3], to: [-5.5, 3]" + z + "  - wall: {from: [10, 10], to: [-10, 10]" +
         z + "  - wall: {from: [-10, 10], to: [-10, -10]" + z + "  - wall: {from: [-10, -10], to: [10, -10]" +
         z;
}

/// The newest cloud of a device among some objects.
Cloud cloud_of(const std::string& model, const std::string& objects, double max_range = 0) {
  const sim::Scene scene =
      sim::parse_scene("start: 2026-01-01T00:17:23.5Z\nduration: 0.6\nsensors:\n  it: {model: " + model +
                           ", from: '10.0.0.1:2115', to: '10.0.0.2:2115'}\n" + objects,
                       "scene");
  DriverConfig config;
  config.model = find_model(model);
  config.max_range = max_range;
  config.keep_too_near = true;
  const auto driver = config.model->make(config);
  test::Collector out;
  sim::simulate(scene, [&](const sim::SimPacket& sent) {
    if (sent.to_device) return true;
    Packet packet;
    packet.payload = sent.payload;
    packet.arrival = sent.time;
    packet.from = sent.from;
    packet.to = sent.to;
    packet.transport = config.model->transport;
    driver->receive(packet, out);
    return true;
  });
  EXPECT_GE(out.clouds.size(), 3U);
  return std::move(out.clouds.back());
}

/// Distance of the room's first surface from (x, y) at a height above ground where the box counts, or not.
double truth(double x, double y, double angle, bool with_box) {
  sim::Yard yard;
  yard.ground = false;
  yard.objects = {wall(6, -4, 6, 4), wall(6, 4, -5, 4), wall(-5, 4, -5, -4), wall(-5, -4, 6, -4)};
  if (with_box) yard.objects.push_back(box({3, 1.5, 0.45}, {0.6, 0.8, 0.9}));
  return yard.cast({{x, y, 0.4}, {std::cos(angle), std::sin(angle), 0}}, false);
}

struct Tally {
  std::size_t beams = 0, right = 0, silent = 0, free = 0, near = 0, far = 0;
};

/// `tolerance` m; a beam at an edge is right on either side of it.
Tally tally(const Cut& cut, const PlanarScan& scan, const Eigen::Vector2d& at, bool with_box, double from,
            double to, double tolerance) {
  Tally all;
  for (std::size_t beam = 0; beam < scan.beams; ++beam) {
    const double angle = cut.grid.angle(beam);
    if (angle < from || angle > to) continue;
    ++all.beams;
    double error = INFINITY;
    const double range = static_cast<double>(scan.ranges[beam]);
    for (const double side : {0.0, -0.5, 0.5}) {
      const double off = range - truth(at.x(), at.y(), angle + side * cut.grid.increment, with_box);
      if (std::abs(off) < std::abs(error)) error = off;
    }
    if (scan.statuses[beam] == BeamStatus::none) {
      ++all.free;
    } else if (scan.statuses[beam] != BeamStatus::hit) {
      ++all.silent;
    } else if (std::abs(error) <= tolerance) {
      ++all.right;
    } else {
      ++(error < 0 ? all.near : all.far);
    }
  }
  return all;
}

void look(Cut& cut, const Cloud& cloud, double lidar_z) {
  cut.settings.how.noise = 0.005;
  cut.make(cloud, make_pose({0, 0, lidar_z}, {0, 0, 0}));
}

struct Bar {
  const char* name;
  const char* model;
  double height;                   // m of the virtual frame
  double at_x;                     // m of the virtual frame before the lidar
  std::size_t most_silent, wrong;  // beams
};

class VirtualDevices : public ::testing::TestWithParam<Bar> {};

/// The corners of box and room, between two beams of a device, are cut by up to 30 mm.
TEST_P(VirtualDevices, TheRoomIsWhereItIs) {
  const Bar& bar = GetParam();
  const bool mrs = std::string(bar.model) == "sick_mrs1000";
  const double lidar_z = mrs ? 0.4 : 1.2;  // the planes of an MRS1000 look up to 5 deg upwards
  const Cloud seen = cloud_of(bar.model, room(lidar_z));
  Cut cut;
  cut.settings.beams.no_return_free_range = 20;
  cut.frame = make_pose({bar.at_x, 0, bar.height}, {0, 0, 0});
  look(cut, seen, lidar_z);
  const double side = mrs ? 130 * degree : pi_d;
  for (const PlanarScan* scan : {&cut.strict, &cut.safety}) {
    const Tally of = tally(cut, *scan, {bar.at_x, 0}, bar.height < 0.9, -side, side, 0.03);
    SCOPED_TRACE(scan == &cut.strict ? "strict" : "safety");
    EXPECT_LE(of.near + of.far, bar.wrong)
        << of.near << " too near, " << of.far << " too far of " << of.beams;
    EXPECT_LE(of.silent, bar.most_silent) << "of " << of.beams;
    EXPECT_EQ(of.free, 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(Bars, VirtualDevices,
                         ::testing::Values(Bar{"mrs1000_low", "sick_mrs1000", 0.4, 0, 0, 0},
                                           Bar{"mrs1000_high", "sick_mrs1000", 0.6, 0, 0, 0},
                                           Bar{"mrs1000_middle", "sick_mrs1000", 0.5, 0, 0, 0},
                                           Bar{"mrs1000_before_it", "sick_mrs1000", 0.6, 0.5, 40, 4},
                                           Bar{"multiscan136_low", "sick_multiscan136", 0.3, 0, 8, 4},
                                           Bar{"multiscan136_middle", "sick_multiscan136", 0.5, 0, 8, 4},
                                           Bar{"multiscan136_before_it", "sick_multiscan136", 0.8, 0.5, 40,
                                               8},
                                           Bar{"multiscan136_level", "sick_multiscan136", 1.2, 0, 8, 8}),
                         [](const auto& each) { return std::string(each.param.name); });

class VirtualVelodynes : public ::testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Models, VirtualVelodynes,
                         ::testing::Values("velodyne_vlp16", "velodyne_hdl32e", "velodyne_vlp32c",
                                           "velodyne_hdl64e_s1", "velodyne_hdl64e_s3", "velodyne_vls128"),
                         [](const auto& each) { return std::string(each.param); });

/// A wall that the plane meets at 10 m on all sides: its beams that are free, and those that hit it.
std::pair<std::size_t, std::size_t> free_and_hit(const char* model, double top, double plane,
                                                 double max_range) {
  constexpr double lidar_z = 2;
  const Cloud seen = cloud_of(model, walls(lidar_z, top), max_range);
  Cut cut;
  if (find_model(model)->has(Trait::silent_beams_are_free)) cut.settings.beams.no_return_free_range = 100;
  cut.frame = make_pose({0, 0, plane}, {0, 0, 0});
  // Otherwise no beam would be free, since the lidar does not see the plane near it.
  cut.footprint = Footprint({{-5, -5}, {5, -5}, {5, 5}, {-5, 5}});
  look(cut, seen, lidar_z);
  std::size_t free = 0, hit = 0;
  for (const PlanarScan* scan : {&cut.strict, &cut.safety}) {
    for (std::size_t beam = 0; beam < scan->beams; ++beam) {
      free += scan->statuses[beam] == BeamStatus::none ? 1U : 0U;
      hit += scan->statuses[beam] == BeamStatus::hit ? 1U : 0U;
    }
  }
  return {free, hit};
}

// Between the rings of other models such a wall is overlooked (limits.md).
TEST(VirtualHdl64e, SaysNowhereThatALowWallIsNotThereWhetherAColumnHoldsOneBankOrBoth) {
  for (const char* model : {"velodyne_hdl64e_s1", "velodyne_hdl64e_s3"}) {
    for (const double top : {0.35, 0.6, 1.2})
      EXPECT_EQ(free_and_hit(model, top, 0.3, 0).first, 0U) << model << top;
  }
}

TEST_P(VirtualVelodynes, SayNothingOfWhatLiesBeyondTheirMaxRange) {
  EXPECT_GE(free_and_hit(GetParam(), 3, 1.9, 0).second, 700U);
  EXPECT_EQ(free_and_hit(GetParam(), 3, 1.9, 0).first, 0U);
  EXPECT_EQ(free_and_hit(GetParam(), 3, 1.9, 6).first, 0U);
}

TEST(VirtualMrs1000, NothingIsSaidOfWhereItDoesNotLook) {
  const Cloud seen = cloud_of("sick_mrs1000", room(0.4));
  EXPECT_EQ(seen.rings, 4U);
  Cut cut;
  cut.settings.beams.no_return_free_range = 20;
  cut.frame = make_pose({0, 0, 0.6}, {0, 0, 0});
  look(cut, seen, 0.4);
  for (int angle = 139; angle <= 221; ++angle) {
    EXPECT_EQ(cut.strict.statuses[cut.grid.nearest(angle * degree)], BeamStatus::invalid) << angle;
    EXPECT_EQ(cut.safety.statuses[cut.grid.nearest(angle * degree)], BeamStatus::invalid) << angle;
  }
}

}  // namespace
}  // namespace lidard
