// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/registry/registry.h"
#include "test/daemon/config/calibration_support.h"
#include "test/drivers/velodyne/calibrated_point.h"
#include "test/support/calibration_equations.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

using test::calibration_of;
using test::calibration_warnings;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct SharedFile {
  const char* name;
  std::size_t lasers;
  double step_m;
  const char* model;
  std::size_t warnings;
};

class SharedCalibration : public ::testing::TestWithParam<SharedFile> {};

/// What the file says of one laser, read by a search for the text and not by a parser.
double number_after(const std::string& laser, const std::string& key, double otherwise) {
  const auto at = laser.find(key + ":");
  return at == std::string::npos ? otherwise : std::stod(laser.substr(at + key.size() + 1));
}

/// The lasers of the flow mappings that all these files consist of.
std::vector<LaserCalibration> read_independently(const std::string& text) {
  std::vector<LaserCalibration> lasers(128);
  std::size_t count = 0;
  for (std::size_t at = text.find('{'); at != std::string::npos; at = text.find('{', at + 1), ++count) {
    const std::string one = text.substr(at, text.find('}', at) - at);
    LaserCalibration& laser = lasers.at(static_cast<std::size_t>(number_after(one, "laser_id", 999)));
    laser.rot_correction = number_after(one, "rot_correction", NAN);
    laser.vert_correction = number_after(one, "vert_correction", NAN);
    laser.dist_correction = number_after(one, "dist_correction", NAN);
    laser.dist_correction_x = number_after(one, "dist_correction_x", NAN);
    laser.dist_correction_y = number_after(one, "dist_correction_y", NAN);
    laser.vert_offset = number_after(one, "vert_offset_correction", NAN);
    laser.horiz_offset = number_after(one, "horiz_offset_correction", 0);
    laser.focal_distance = number_after(one, "focal_distance", NAN);
    laser.focal_slope = number_after(one, "focal_slope", NAN);
    laser.min_intensity = static_cast<int>(number_after(one, "min_intensity", 0));
    laser.max_intensity = static_cast<int>(number_after(one, "max_intensity", 255));
  }
  lasers.resize(count);
  return lasers;
}

template <class Reference>
void compare(const Calibration& calibration, const std::vector<LaserCalibration>& expected, bool two_point,
             Reference reference) {
  const velodyne::CalibratedGeometry geometry(calibration);
  std::mt19937 random(29);
  for (int i = 0; i < 20000; ++i) {
    const std::size_t id = random() % expected.size();
    const auto count = static_cast<std::uint16_t>(random() % (i % 2 == 0 ? 65536 : 12000));
    const auto raw = static_cast<std::uint8_t>(random());
    const double azimuth = static_cast<double>(random() % 36000) / 18000 * M_PI;
    const bool near = two_point && expected[id].dist_correction_x != 0 && expected[id].dist_correction_y != 0;
    const auto point = place(geometry, id, count, raw, std::cos(azimuth), std::sin(azimuth));
    const auto wanted = reference(expected[id], near, calibration.distance_step_m, count, raw, azimuth);
    ASSERT_NEAR(point.x, wanted.x, 1e-4);
    ASSERT_NEAR(point.y, wanted.y, 1e-4);
    ASSERT_NEAR(point.z, wanted.z, 1e-4);
    ASSERT_NEAR(point.intensity, wanted.intensity, 1e-3);
  }
}

TEST_P(SharedCalibration, PlacesReturnsLikeTheEquationsOfEachModel) {
  const SharedFile& shared = GetParam();
  LIDARD_NEED_CAPTURE(path, std::string("calibration/") + shared.name);
  std::vector<std::string> warnings;
  Calibration calibration = load_calibration(path, warnings);
  EXPECT_EQ(warnings.size(), shared.warnings) << ::testing::PrintToString(warnings);
  EXPECT_EQ(calibration.distance_step_m, shared.step_m);
  EXPECT_EQ(calibration.model, CalibrationModel::ros_drivers);
  const auto expected = read_independently(test::content(path));
  ASSERT_EQ(expected.size(), shared.lasers);
  ASSERT_EQ(calibration.lasers.size(), shared.lasers);
  compare(calibration, expected, false, test::place_like_ros_drivers);
  for (LaserCalibration& laser : calibration.lasers) {
    if (laser.two_point == TwoPoint::unstated) laser.two_point = TwoPoint::on;
  }
  compare(calibration, expected, true, test::place_like_ros_drivers);
  calibration.model = CalibrationModel::exact;
  compare(calibration, expected, true, test::place_like_manual);
}

TEST_P(SharedCalibration, FitsItsModelOnly) {
  const SharedFile& shared = GetParam();
  LIDARD_NEED_CAPTURE(path, std::string("calibration/") + shared.name);
  std::vector<std::string> warnings;
  const Calibration calibration = load_calibration(path, warnings);
  const Model* vlp16 = find_model("velodyne_vlp16");
  EXPECT_EQ(calibration_rejection(calibration, *vlp16).empty(), shared.lasers == 16);
  if (const Model* model = find_model(shared.model)) {
    EXPECT_EQ(calibration_rejection(calibration, *model), "");
    EXPECT_EQ(calibration_warning(calibration, *model), "");
  }
}

INSTANTIATE_TEST_SUITE_P(
    Files, SharedCalibration,
    ::testing::Values(SharedFile{"VLP16.yaml", 16, 0.002, "velodyne_vlp16", 0},
                      SharedFile{"VLP16_hires.yaml", 16, 0.002, "velodyne_puck_hires", 0},
                      SharedFile{"VLP32.yaml", 32, 0.004, "velodyne_vlp32c", 0},
                      SharedFile{"VLP32MR.yaml", 32, 0.004, "velodyne_vlp32c", 0},
                      SharedFile{"HDL32.yaml", 32, 0.002, "velodyne_hdl32e", 0},
                      SharedFile{"HDL64e_utexas.yaml", 64, 0.002, "velodyne_hdl64e_s2", 0},
                      SharedFile{"HDL64e_s2.yaml", 64, 0.002, "velodyne_hdl64e_s2", 1},
                      SharedFile{"HDL64e_s3.yaml", 64, 0.002, "velodyne_hdl64e_s3", 1},
                      SharedFile{"VLS128.yaml", 128, 0.004, "velodyne_vls128", 1}),
    [](const auto& file) {
      const std::string name = file.param.name;
      return name.substr(0, name.find('.'));
    });

TEST(CalibrationFile, TellsOfTheWrongStepOfVls128Files) {
  LIDARD_NEED_CAPTURE(path, "calibration/VLS128.yaml");
  std::vector<std::string> warnings;
  load_calibration(path, warnings);
  EXPECT_THAT(warnings, ElementsAre(path + ":1411:22: a distance step of 7 mm is a known mistake of VLS-128 "
                                           "files; 4 mm is used"));
}

TEST(CalibrationFile, TellsOfNearCorrectionsThatNothingEnables) {
  LIDARD_NEED_CAPTURE(path, "calibration/HDL64e_s2.yaml");
  std::vector<std::string> warnings;
  load_calibration(path, warnings);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr(":1:1: 64 lasers have near corrections but no "
                                              "two_pt_correction_available")));
}

TEST(CalibrationFile, TakesEveryKeyInAnyOrderAndEitherStyle) {
  const Calibration calibration = calibration_of(
      "distance_resolution: 0.004\n"
      "lasers:\n"
      "- {laser_id: 1, rot_correction: -0.25, vert_correction: 0}\n"
      "- vert_correction: 1\n"
      "  min_intensity: 10.9\n"
      "  max_intensity: 235\n"
      "  focal_slope: 1.5\n"
      "  focal_distance: 12\n"
      "  two_pt_correction_available: true\n"
      "  horiz_offset_correction: -0.026\n"
      "  vert_offset_correction: .2\n"
      "  dist_correction_y: 1.3e+0\n"
      "  dist_correction_x: 1.2\n"
      "  dist_correction: 1\n"
      "  rot_correction: +0.5\n"
      "  laser_id: 0\n"
      "num_lasers: 2\n");
  EXPECT_EQ(calibration.distance_step_m, 0.004);
  ASSERT_EQ(calibration.lasers.size(), 2U);
  const LaserCalibration& full = calibration.lasers[0];
  EXPECT_EQ(full.vert_correction, 1);
  EXPECT_EQ(full.rot_correction, 0.5);
  EXPECT_EQ(full.dist_correction, 1);
  EXPECT_EQ(full.dist_correction_x, 1.2);
  EXPECT_EQ(full.dist_correction_y, 1.3);
  EXPECT_EQ(full.vert_offset, 0.2);
  EXPECT_EQ(full.horiz_offset, -0.026);
  EXPECT_EQ(full.focal_distance, 12);
  EXPECT_EQ(full.focal_slope, 1.5);
  EXPECT_EQ(full.min_intensity, 10);
  EXPECT_EQ(full.max_intensity, 235);
  EXPECT_EQ(full.two_point, TwoPoint::on);
  LaserCalibration angles_only;
  angles_only.rot_correction = -0.25;
  EXPECT_TRUE(calibration.lasers[1] == angles_only);
}

/// A file of one laser with these keys beside the required ones; they begin in column 63 of line 2.
std::string one_laser(const std::string& keys) {
  return "distance_resolution: 0.002\nlasers: [{laser_id: 0, rot_correction: 0, vert_correction: 0, " + keys +
         "}]\n";
}

TEST(CalibrationFile, TwoPointIsStatedByTheKeyAlone) {
  const auto two_point = [](const std::string& keys) {
    return calibration_of(one_laser(keys)).lasers.at(0).two_point;
  };
  EXPECT_EQ(two_point("dist_correction: 1"), TwoPoint::off);
  EXPECT_EQ(two_point("dist_correction_x: 1"), TwoPoint::unstated);
  EXPECT_EQ(two_point("dist_correction_x: 1, two_pt_correction_available: False"), TwoPoint::off);
  EXPECT_EQ(two_point("two_pt_correction_available: true"), TwoPoint::on);
}

TEST(CalibrationFile, UnknownKeysAreToldOnce) {
  EXPECT_THAT(calibration_warnings("status: {Model: S3}\n"
                                   "distance_resolution: 0.002\n"
                                   "lasers:\n"
                                   "- {laser_id: 0, rot_correction: 0, vert_correction: 0, focal_slop: 1}\n"
                                   "- {laser_id: 1, rot_correction: 0, vert_correction: 0, focal_slop: 1}\n"),
              ElementsAre("f:1:1: unknown key status is ignored",
                          "f:4:56: unknown key lasers[0].focal_slop is ignored; perhaps focal_slope"));
}

TEST(CalibrationFile, IntensityLimitsInTheWrongOrderAreTold) {
  EXPECT_THAT(calibration_warnings(one_laser("min_intensity: 40, max_intensity: 2")),
              ElementsAre("f:2:97: min_intensity is above max_intensity, so all intensities become 2"));
}

TEST(CalibrationFile, RefusesFilesThatCannotBeRead) {
  std::vector<std::string> warnings;
  try {
    load_calibration("/nowhere.yaml", warnings);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "/nowhere.yaml: cannot be read: No such file or directory; expected a calibration of "
                 "velodyne_pointcloud (YAML) or a db.xml");
  }
}

TEST(CalibrationFile, OtherSensorsTakeNone) {
  const Calibration calibration = calibration_of(one_laser(""));
  const Model& scanner = *find_model("sick_microscan3");
  EXPECT_THAT(calibration_rejection(calibration, scanner), HasSubstr("has none"));
  EXPECT_EQ(calibration_warning(calibration, scanner), "");
}

TEST(CalibrationFile, AnotherStepThanTheModelsIsDoubted) {
  Calibration calibration;
  calibration.lasers.resize(16);
  calibration.distance_step_m = 0.004;
  EXPECT_EQ(calibration_warning(calibration, *find_model("velodyne_vlp16")),
            "has a distance step of 4 mm, but VLP-16 counts in 2 mm: is it the right file?");
}

TEST(CalibrationFile, MutatedFilesAreReadOrGiveAPlacedError) {
  const std::string original =
      "num_lasers: 2\ndistance_resolution: 0.002\nlasers:\n"
      "- {laser_id: 0, rot_correction: 0, vert_correction: 0.1, dist_correction_x: 1, min_intensity: 3}\n"
      "- {laser_id: 1, rot_correction: 0, vert_correction: 0.2, two_pt_correction_available: true}\n";
  test::expect_placed_errors(original, " \n:-[]{},#&*!|>'\"0123456789.eainfx_<", 31,
                             "^f:[1-9][0-9]*:[1-9][0-9]*: [^\\n]+; expected [^\\n]+$");
}

}  // namespace
}  // namespace lidard
