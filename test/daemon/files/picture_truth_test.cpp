// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What is drawn stands where it was measured: a vehicle with a scanner on each front corner between walls, a
// box 2 m ahead.
#include "test/daemon/files/pictures_support.h"
#include "test/sim/servers/capture.h"
#include "test/sim/servers/scene_file.h"

namespace lidard::test {
namespace {

const char* const scene = R"(
start: 2026-01-01T00:00:00Z
duration: 0.6
sensors:
  left: {model: sick_microscan3, pose: {xyz: [0, 1, 0.35], rpy_deg: [0, 0, 45]}, from: "192.168.0.21:6060", to: "192.168.0.100:6060"}
  right: {model: sick_microscan3, pose: {xyz: [0, -1, 0.35], rpy_deg: [0, 0, -45]}, from: "192.168.0.22:6060", to: "192.168.0.100:6060", phase_ms: 15}
vehicle:
  start: {xy: [0, 0]}
  body: [box: {center: [-2.05, 0, 0.9], size: [3.9, 1.8, 1.4]}]
objects:
  - box: {center: [0, 0, 1], size: [40, 24, 4]}
  - box: {center: [2.5, 0, 0.5], size: [1, 1, 1]}
)";
const char* const config = R"(
vehicle: {footprint: [[-4.0, -1.0], [0.0, -1.0], [0.0, 1.0], [-4.0, 1.0]]}
sensors:
  left: {model: sick_microscan3, ip_address: 192.168.0.21, pose: {xyz: [0, 1, 0.35], rpy_deg: [0, 0, 45]}}
  right: {model: sick_microscan3, ip_address: 192.168.0.22, pose: {xyz: [0, -1, 0.35], rpy_deg: [0, 0, -45]}}
merged_scans:
  around: {laserscan_topics: [left, right], profile: strict, range_max: 30, beams: 1440}
)";

constexpr Rgb of_left{0, 115, 179}, of_right{214, 94, 0}, black{0, 0, 0}, free_area{219, 242, 227},
    unknown{232, 227, 222};
constexpr double half = 13;  // m from base_link to the edge

/// True if the color is within `reach` pixels of a place in base_link.
bool shows(const Pixels& picture, const Rgb& color, double ahead, double left, int reach = 2) {
  constexpr double side = 872;  // pixels of the field
  const int x = 20 + static_cast<int>(std::lround(side / 2 - left * side / (2 * half)));
  const int y = 76 + static_cast<int>(std::lround(side / 2 - ahead * side / (2 * half)));
  for (int v = y - reach; v <= y + reach; ++v) {
    for (int u = x - reach; u <= x + reach; ++u) {
      if (is_like(picture.rgb.at(static_cast<std::size_t>(v * picture.width + u)), color, 13)) return true;
    }
  }
  return false;
}

class PictureTruth : public Pictures {
 protected:
  PictureTruth() {
    std::ofstream(path("v.yaml")) << config;
    options_.config = path("v.yaml");
    options_.range = half;
  }
  Pixels drawn() {
    options_.output = path("v.png");
    EXPECT_EQ(draw(options_), exit_ok) << said;
    const Pixels picture = read_png(options_.output);
    EXPECT_EQ(picture.width, 1192);
    EXPECT_EQ(picture.height, 968);
    return picture;
  }
  SnapshotOptions options_;
};

TEST_F(PictureTruth, ReturnsAndAreasStandWhereTheyWereMeasured) {
  sim::make_capture(sim::parse_scene(scene, "scene"), path("v"), false);
  options_.captures = {path("v.pcap")};
  const Pixels picture = drawn();
  EXPECT_TRUE(shows(picture, of_left, 2.5, 0.5)) << "the left scanner's returns on its side of the box";
  EXPECT_TRUE(shows(picture, of_right, 2.5, -0.5)) << "the right scanner's";
  EXPECT_TRUE(shows(picture, black, 2.0, 0.2)) << "the merged scan on the box";
  EXPECT_TRUE(shows(picture, of_left, -6.0, 11.99) && shows(picture, of_right, -6.0, -11.99)) << "the walls";
  EXPECT_TRUE(shows(picture, free_area, 1.0, 0.15, 0)) << "before the box";
  EXPECT_TRUE(shows(picture, free_area, 5.3, 6.1, 0)) << "beside it";
  EXPECT_FALSE(shows(picture, free_area, 4.0, 0.0, 1)) << "behind it";
  EXPECT_TRUE(shows(picture, unknown, -9.0, 0.0, 4)) << "nobody sees behind the vehicle";
  EXPECT_FALSE(shows(picture, free_area, -9.0, 0.0, 4));
  const std::string first = content("v.png");
  drawn();
  EXPECT_TRUE(content("v.png") == first) << "two pictures of one moment differ";
}

TEST_F(PictureTruth, AnEmptyFieldHasTheFieldsOfViewAndWhatTheMergedScanCanSee) {
  const Pixels picture = drawn();
  EXPECT_TRUE(shows(picture, free_area, 5.3, 6.1, 0) && shows(picture, free_area, 5.3, -6.1, 0)) << "ahead";
  EXPECT_TRUE(shows(picture, unknown, -9.0, 0.0, 4)) << "nobody sees behind the vehicle";
  EXPECT_FALSE(shows(picture, free_area, -9.0, 0.0, 4));
  // The left scanner looks 45 degrees to the left, and 137.5 degrees to either side of that.
  EXPECT_TRUE(shows(picture, of_left, -9.0, 0.61, 3) && shows(picture, of_right, -9.0, -0.61, 3))
      << "their ends";
  options_.output = path("v.svg");
  ASSERT_EQ(draw(options_), exit_ok) << said;
  for (const char* name :
       {"around", "+inf in an empty field", "fields of view", "the vehicle itself stands in the way"})
    EXPECT_THAT(content("v.svg"), HasSubstr(name));
}

}  // namespace
}  // namespace lidard::test
