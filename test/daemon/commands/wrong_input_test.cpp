// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What commands say of captures and files that are not those that were meant.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "daemon/commands/commands.h"
#include "daemon/config/config.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class WrongInput : public ::testing::Test {
 protected:
  WrongInput() { std::filesystem::create_directories(folder_); }
  ~WrongInput() override { std::filesystem::remove_all(folder_); }
  std::string config(const std::string& text) const {
    std::ofstream(folder_ + "c.yaml") << text;
    return folder_ + "c.yaml";
  }

  const std::string folder_ = ::testing::TempDir() + "lidard_wrong_" + std::to_string(getpid()) + "/";
  const std::string capture_ = project_file("pcaps/vlp16_last.pcap");
  std::ostringstream out_, err_;
};

TEST_F(WrongInput, SnapshotNamesTheLidarOfTheCapture) {
  SnapshotOptions options;
  options.config = config("sensors: {a: {model: velodyne_vlp32c, ip_port: 7000, telemetry_port: 0}}\n");
  options.captures = {capture_};
  options.output = folder_ + "x.svg";
  EXPECT_EQ(run_snapshot(options, err_), exit_failed);
  EXPECT_THAT(err_.str(), AllOf(HasSubstr("the packets are of velodyne_vlp16 "),
                                HasSubstr("which is no sensor of the configuration; correct its model")));
}

TEST_F(WrongInput, ReplayFromBeyondTheEndSaysWhereTheEndIs) {
  ReplayOptions options;
  options.config = config("sensors: {a: {model: velodyne_vlp16}}\n");
  options.captures = {capture_};
  options.rate = 0;
  options.start = 1000;
  options.bag = folder_ + "x.bag";
  EXPECT_EQ(run_replay(options, out_, err_), exit_failed);
  EXPECT_THAT(err_.str(), HasSubstr("--start 1000: the capture ends before, after 0."));
  EXPECT_EQ(out_.str().find("firewall"), std::string::npos) << out_.str();
  options.start = 0;
  options.bag = folder_ + "y.bag";
  options.motion = "/nowhere.csv";
  EXPECT_EQ(run_replay(options, out_, err_), exit_failed);
  EXPECT_THAT(err_.str(), HasSubstr("/nowhere.csv: cannot be opened: No such file or directory"));
}

TEST_F(WrongInput, ReplayWarnsOnceOfASensorWithoutItsCalibration) {
  LIDARD_NEED_CAPTURE(capture, "velodyne/hdl64e_s1_atwall_306.pcap");
  ReplayOptions options;
  options.captures = {capture};
  options.rate = 0;
  options.bag = folder_ + "x.bag";
  EXPECT_EQ(run_replay(options, out_, err_), exit_ok) << err_.str();
  const std::string said = err_.str(), warning = "does not send its calibration";
  EXPECT_NE(said.find(warning), std::string::npos) << said;
  EXPECT_EQ(said.find(warning), said.rfind(warning)) << said;
}

TEST_F(WrongInput, TheOutputsThatInspectProposesAreValid) {
  ASSERT_EQ(run_inspect({project_file("pcaps/demo.pcap")}, false, out_, err_), 0);
  const std::string text =
      std::regex_replace(out_.str(), std::regex("\n# ((vehicle|merged_scans|merged_clouds):|  )"), "\n$1");
  const Config config = parse_config(text.substr(text.find("\nsensors:")), "f");
  EXPECT_EQ(config.vehicle.footprint.size(), 4U);
  EXPECT_EQ(config.merged_scans.at(0).laserscan_topics.size(), 2U);
  EXPECT_EQ(config.merged_clouds.at(0).sources.size(), 1U);
}

}  // namespace
}  // namespace lidard::test
