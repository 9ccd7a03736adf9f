// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "daemon/commands/commands.h"
#include "daemon/offline/remarks.h"
#include "drivers/velodyne/calibration.h"
#include "test/daemon/config/config_support.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

using test::error_of;
using ::testing::HasSubstr;

/// A folder with a configuration and calibrations beside it.
class ConfigCalibration : public ::testing::Test {
 protected:
  ConfigCalibration() {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ + good_) << calibration(16, 0.002);
    std::ofstream(folder_ + other_) << calibration(32, 0.004);
  }
  ~ConfigCalibration() override { std::filesystem::remove_all(folder_); }

  static std::string calibration(int lasers, double step) {
    std::string text = "distance_resolution: " + std::to_string(step) + "\nlasers:\n";
    for (int i = 0; i < lasers; ++i)
      text += "- {laser_id: " + std::to_string(i) +
              ", rot_correction: 0, vert_correction: " + std::to_string((2 * i - 15) * M_PI / 180) +
              "}\n";  // those of a VLP-16
    return text;
  }
  /// The configuration of a VLP-16 named a with these keys, which begin in column 39.
  Config parse(const std::string& keys) const {
    return parse_config("sensors: {a: {model: velodyne_vlp16, " + keys + "}}", folder_ + config_);
  }
  std::string error(const std::string& keys) const {
    try {
      parse(keys);
      return "no error";
    } catch (const ConfigError& mistake) {
      const std::string what = mistake.what();
      return what.compare(0, folder_.size(), folder_) == 0 ? what.substr(folder_.size()) : what;
    }
  }

  // Tests run beside each other.
  const std::string folder_ = ::testing::TempDir() + "lidard_calibration_" + std::to_string(getpid()) + "/";
  const std::string good_ = "config_calibration_16.yaml";
  const std::string other_ = "config_calibration_32.yaml";
  const std::string config_ = "config_calibration.yaml";
};

TEST_F(ConfigCalibration, IsReadFromTheFolderOfTheConfiguration) {
  const Config config = parse("calibration: " + good_);
  const Calibration* const calibration = own_calibration(config.sensors.at(0).driver);
  ASSERT_NE(calibration, nullptr);
  EXPECT_EQ(calibration->lasers.size(), 16U);
  EXPECT_EQ(calibration->model, CalibrationModel::ros_drivers);
  EXPECT_TRUE(config.warnings.empty());
}

TEST_F(ConfigCalibration, MayHaveAnAbsolutePath) {
  const Config config = parse_config(
      "sensors: {a: {model: velodyne_vlp16, calibration: " + folder_ + good_ + "}}", "/elsewhere/f");
  EXPECT_NE(config.sensors.at(0).driver.calibration, nullptr);
}

TEST_F(ConfigCalibration, TakesEitherModel) {
  for (const auto& [word, model] :
       {std::pair("exact", CalibrationModel::exact), std::pair("ros_drivers", CalibrationModel::ros_drivers)})
    EXPECT_EQ(
        own_calibration(parse("calibration: " + good_ + ", calibration_model: " + word).sensors.at(0).driver)
            ->model,
        model);
}

TEST_F(ConfigCalibration, WithoutAFileTheModelsOwnTableHasEitherEquations) {
  EXPECT_EQ(parse("calibration_model: exact").sensors.at(0).driver.calibration, nullptr);
  const Config config = parse("calibration_model: ros_drivers");
  const Calibration* const table = own_calibration(config.sensors.at(0).driver);
  ASSERT_NE(table, nullptr);
  EXPECT_EQ(table->model, CalibrationModel::ros_drivers);
  ASSERT_EQ(table->lasers.size(), 16U);
  EXPECT_NEAR(table->lasers[2].vert_correction, -13 * M_PI / 180, 1e-12);
  EXPECT_EQ(table->lasers[2].vert_offset, 0) << "velodyne_pointcloud's own files have none";
  const std::string yaml = to_yaml(config);
  EXPECT_THAT(yaml, HasSubstr("    # calibration: what the model or the device itself says\n"
                              "    calibration_model: ros_drivers\n"));
  EXPECT_EQ(to_yaml(parse_config(yaml, folder_ + config_)), yaml);
  EXPECT_THROW(parse_config("sensors: {a: {model: velodyne_hdl64e_s3, calibration_model: ros_drivers}}", "f"),
               ConfigError);
}

TEST_F(ConfigCalibration, CheckPrintsWhatReadsBackToTheSame) {
  std::ofstream(folder_ + config_) << "sensors: {a: {model: velodyne_vlp16, calibration: " + good_ +
                                          ", calibration_model: exact}, b: {model: velodyne_vlp16, ip_port: "
                                          "2369}}\n";
  std::ostringstream out;
  std::ostringstream err;
  ASSERT_EQ(run_check(folder_ + config_, out, err), 0) << err.str();
  EXPECT_THAT(out.str(), HasSubstr("    calibration: " + good_ + "\n    calibration_model: exact\n"));
  EXPECT_THAT(out.str(), HasSubstr("# calibration: what the model or the device itself says\n"));
  const Config again = parse_config(out.str(), folder_ + config_);
  EXPECT_EQ(to_yaml(again), out.str());
  EXPECT_EQ(own_calibration(again.sensors.at(0).driver)->model, CalibrationModel::exact);
  EXPECT_EQ(again.sensors.at(1).driver.calibration, nullptr);
}

TEST_F(ConfigCalibration, MistakesHaveTheirPlace) {
  EXPECT_EQ(error("calibration: none.yaml"),
            config_ +
                ":1:51: sensors.a.calibration is \"none.yaml\", which cannot be read: No such file or "
                "directory; expected a calibration file, relative to the configuration's folder");
  EXPECT_EQ(error("calibration: " + other_),
            config_ +
                ":1:51: sensors.a.calibration has 32 lasers, VLP-16 has 16; expected the calibration of "
                "this sensor");
  EXPECT_THAT(error("calibration: " + good_ + ", calibration_model: manual"),
              HasSubstr("sensors.a.calibration_model is \"manual\"; expected ros_drivers"));
  std::ofstream(folder_ + good_) << "distance_resolution: x\nlasers: 3\n";
  EXPECT_EQ(error("calibration: " + good_),
            good_ + ":2:9: lasers is \"3\"; expected a list with one entry per laser");
}

TEST_F(ConfigCalibration, AStepThatIsNotTheModelsIsAWarning) {
  std::ofstream(folder_ + good_) << calibration(16, 0.004);
  const Config config = parse("calibration: " + good_);
  ASSERT_EQ(remarks_on(config).size(), 1U);
  EXPECT_THAT(remarks_on(config)[0],
              HasSubstr("config_calibration.yaml:1:38: sensors.a.calibration has a distance "
                        "step of 4 mm, but VLP-16 counts in 2 mm"));
}

TEST_F(ConfigCalibration, OtherSensorsHaveNone) {
  EXPECT_EQ(error_of("sensors: {a: {model: sick_microscan3, calibration: x}}"),
            "f:1:39: sensors.a.calibration is not available for sick_microscan3, only for "
            "Velodynes; expected no such key");
  EXPECT_THAT(error_of("sensors: {a: {topic: x, calibration: x}}"), HasSubstr("does not apply to a source"));
}

TEST_F(ConfigCalibration, DecodeRefusesABadOrUnfitFileWithExitCode78) {
  DecodeOptions options;
  options.capture = test::project_file("pcaps/demo.pcap");
  options.model = "velodyne_vlp16";
  options.output = "/dev/null";
  std::ostringstream err;
  options.calibration = folder_ + "none.yaml";
  EXPECT_EQ(run_decode(options, err), 78);
  EXPECT_THAT(err.str(), HasSubstr("none.yaml: cannot be read"));
  options.calibration = folder_ + other_;
  EXPECT_EQ(run_decode(options, err), 78);
  EXPECT_THAT(err.str(), HasSubstr("has 32 lasers, VLP-16 has 16; expected"));
  options.calibration = folder_ + good_;
  EXPECT_EQ(run_decode(options, err), 0) << err.str();
}

}  // namespace
}  // namespace lidard
