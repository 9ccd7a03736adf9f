// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "daemon/commands/commands.h"
#include "daemon/config/config.h"

namespace lidard {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Check : public ::testing::Test {
 protected:
  Check() : path_(::testing::TempDir() + "lidard_check_" + std::to_string(getpid()) + ".yaml") {}
  ~Check() override { std::remove(path_.c_str()); }
  int check(const std::string& text) {
    std::ofstream(path_) << text;
    return run_check(path_, out_, err_);
  }

  std::string path_;
  std::ostringstream out_;
  std::ostringstream err_;
};

TEST_F(Check, PrintsTheCompleteConfiguration) {
  EXPECT_EQ(check("sensors: {roof: {model: velodyne_vlp16}}\n"), 0);
  EXPECT_EQ(err_.str(), "");
  EXPECT_EQ(out_.str(), to_yaml(parse_config(out_.str(), "f")));
  EXPECT_NE(out_.str().find("ip_port: 2368"), std::string::npos);
}

TEST_F(Check, ListsTheSocketsThatTheDaemonOpens) {
  std::ofstream(path_) << "sensors:\n"
                          "  front: {model: sick_microscan3, ip_address: 10.0.0.1, listen_only: true}\n"
                          "  rear: {model: sick_microscan3, ip_address: 10.0.0.2, listen_only: true}\n"
                          "  lms: {model: sick_lms1xx, ip_address: 10.0.0.3}\n"
                          "  roof: {model: velodyne_vlp16, ip_port: 2400}\n"
                          "  other: {topic: /scan}\n";
  ASSERT_EQ(run_check_ports(path_, out_, err_), 0) << err_.str();
  EXPECT_EQ(out_.str(),
            "DOES      SOCKET                      FOR\n"
            "connects  tcp 10.0.0.3:2112           lms\n"
            "listens   udp 2400                    roof\n"
            "listens   udp 6060                    front, rear\n"
            "listens   udp 8308                    roof\n"
            "listens   tcp, two free ports         ROS\n"
            "listens   udp, one free port          ROS\n"
            "connects  tcp, the ROS master's port  ROS\n");
  EXPECT_EQ(run_check_ports("/nowhere.yaml", out_, err_), 78);
}

TEST_F(Check, TellsWhichCloudsNeedTf) {
  EXPECT_EQ(check("sensors:\n"
                  "  roof: {model: velodyne_vlp16, points_frame: base_link, pose: {xyz: [0, 0, 2]}}\n"
                  "  mast: {model: velodyne_vlp16, ip_port: 2369, telemetry_port: 0, points_frame: odom}\n"),
            0);
  EXPECT_EQ(err_.str(), path_ +
                            ":3:3: sensors.mast: the pose of mast in points_frame odom comes from tf only; "
                            "without tf (replay --bag, snapshot) its cloud does not come out: take a frame "
                            "whose pose is configured, or name a bag with tf (--motion)\n");
}

TEST_F(Check, ListsOnlyConnectionsThatTheDaemonMakes) {
  std::ofstream(path_)
      << "sensors:\n"
         "  front: {model: sick_microscan3, ip_address: 10.0.0.1}\n"
         "  rear: {model: sick_microscan3, ip_address: 10.0.0.2, allow_write: true}\n"
         "  pico: {model: sick_picoscan150, ip_address: 10.0.0.5}\n"
         "  quad: {model: sick_multiscan136, ip_address: 10.0.0.6, ip_port: 2117, "
         "udp_receiver_ip: 10.0.0.9}\n"
         "  roof: {model: velodyne_vlp16, ip_address: 10.0.0.3}\n"
         "  mast: {model: velodyne_vlp16, ip_address: 10.0.0.4, control: {allow_write: true, rpm: 600}}\n"
         "  any: {model: sick_nanoscan3, ip_port: 6061, allow_write: true}\n";
  ASSERT_EQ(run_check_ports(path_, out_, err_), 0) << err_.str();
  std::istringstream lines(out_.str());
  std::string tcp;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("connects  tcp 10") == 0) tcp += line.substr(14, line.find(' ', 14) - 14) + " ";
  }
  EXPECT_EQ(tcp, "10.0.0.2:2122 10.0.0.4:80 10.0.0.6:2111 ");
  EXPECT_THAT(out_.str(), ::testing::HasSubstr("connects  tcp, port 2122 of the sender  any\n"));
}

TEST_F(Check, QuestionsAnAddressThatThisHostDoesNotHave) {
  EXPECT_EQ(
      check("sensors: {a: {model: sick_picoscan150, ip_address: 10.0.0.1, udp_receiver_ip: 203.0.113.5}}\n"),
      0);
  EXPECT_NE(err_.str().find("which is no address of this host"), std::string::npos) << err_.str();
}

TEST_F(Check, QuestionsAReachBeyondEverySource) {
  const std::string sensors =
      "vehicle: {footprint: [[-1, -1], [1, -1], [1, 1]]}\n"
      "sensors: {a: {model: sick_microscan3, ip_address: 10.0.0.1, pose: {xyz: [0, 0, 0]}}}\n";
  const auto merged = [&](const std::string& keys) {
    err_.str("");
    EXPECT_EQ(check(sensors + "merged_scans: {s: {laserscan_topics: [a], " + keys + "}}\n"), 0);
    return err_.str();
  };
  EXPECT_EQ(merged("profile: strict"), "");
  EXPECT_EQ(merged("range_max: 200"), "") << "flatten proves nothing";
  EXPECT_EQ(merged("profile: strict, range_max: 200, free_required: 10"), "");
  EXPECT_NE(
      merged("profile: strict, range_max: 200")
          .find("merged_scans.s.range_max: is 200 m, and without return its sources prove no more than"),
      std::string::npos)
      << err_.str();
  EXPECT_NE(merged("also: {s2: safety}, range_max: 200").find("is free (+inf)"), std::string::npos)
      << err_.str();
}

TEST_F(Check, QuestionsAReachThatSourcesDoNotProveWithoutReturn) {
  const auto merged = [&](const std::string& model, const std::string& keys) {
    err_.str(""), out_.str("");
    EXPECT_EQ(check("vehicle: {footprint: [[-1, -1], [1, -1], [1, 1]]}\nsensors: {a: {model: " + model +
                    ", ip_address: 10.0.0.1, pose: {xyz: [0, 0, 0]}}}\n"
                    "merged_scans: {s: {laserscan_topics: [a], profile: strict, " +
                    keys + "}}\n"),
              0);
    return err_.str();
  };
  EXPECT_NE(merged("hokuyo_ust_10lx", "range_max: 10")
                .find("without return its sources prove no more than 4.0 m free"),
            std::string::npos)
      << err_.str();
  EXPECT_NE(out_.str().find("no_return_free_range: 4\n"), std::string::npos) << out_.str();
  EXPECT_EQ(merged("hokuyo_ust_10lx", "range_max: 4"), "");
  EXPECT_EQ(merged("hokuyo_ust_10lx", "range_max: 10, free_required: 4"), "");
  EXPECT_EQ(merged("hokuyo_ust_10lx", "range_max: 10, source_settings: {a: {no_return_free_range: 10}}"), "");
  EXPECT_EQ(merged("hokuyo_utm_30lx_ew", "range_max: 30"), "") << "not known";
  EXPECT_EQ(out_.str().find("no_return_free_range"), std::string::npos) << out_.str();
}

TEST_F(Check, QuestionsAVirtualScanThatBeginsWhereItsLidarIsBlind) {
  const std::string vehicle =
      "vehicle: {footprint: [[-4, -1], [0.1, -1], [0.1, 1], [-4, 1]]}\n"
      "sensors:\n"
      "  roof: {model: velodyne_vlp16, pose: {xyz: [0, 0, 2]}}\n"
      "  front: {model: sick_microscan3, ip_address: 10.0.0.1, pose: {xyz: [0, 0, 0.3]}}\n";
  const auto bumper = [&](const std::string& keys, const std::string& more = "") {
    err_.str("");
    EXPECT_EQ(check(vehicle + "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [bumper], " + keys +
                    "}}\n" + more),
              0);
    return err_.str();
  };
  // The lowest ring of a VLP-16 looks down by 15 degrees: it meets a plane 1.7 m below it 6.3 m away.
  EXPECT_EQ(bumper("profile: strict, poses: {bumper: {xyz: [0.1, 0, 0.3]}}"),
            path_ +
                ":5:17: virtual_scans.v: bumper lies where roof is blind: 100 % of its beams begin unseen "
                "and are never "
                "free (+inf); merge it with scanners at its height\n");
  EXPECT_EQ(bumper("poses: {bumper: {xyz: [0.1, 0, 0.3]}}"), "") << "flatten calls everything free";
  EXPECT_EQ(bumper("profile: safety, poses: {bumper: {xyz: [0, 0, 1.95]}}"), "");
  EXPECT_EQ(
      bumper("profile: safety, angle_min_deg: -30, angle_max_deg: 30, poses: {bumper: {xyz: [7, 0, 0.3]}}"),
      "")
      << "ahead of the blind zone";
  EXPECT_EQ(
      bumper("profile: safety, poses: {bumper: {xyz: [0.1, 0, 0.3]}}",
             "merged_scans: {all: {laserscan_topics: [front, bumper], profile: safety, range_max: 20}}\n"),
      "");
}

TEST_F(Check, SaysAtItsEndWhichBeamsCanBeFreeAndWhatIsInTheWay) {
  const std::string vehicle =
      "sensors:\n"
      "  left: {model: sick_microscan3, ip_address: 10.0.0.1, pose: {xyz: [0, 1, 0.3], rpy_deg: [0, 0, "
      "45]}}\n"
      "  right: {model: sick_microscan3, ip_address: 10.0.0.2, pose: {xyz: [0, -1, 0.3], rpy_deg: [0, 0, "
      "-45]}}\n"
      "merged_scans: {scan: {laserscan_topics: [left, right], profile: strict, range_max: 30}}\n"
      "vehicle: {footprint: [[-4, -1], ";
  ASSERT_EQ(check(vehicle + "[0.6, -1], [0.6, 1], [-4, 1]]}\n"), 0);
  EXPECT_THAT(out_.str(),
              HasSubstr("the vehicle's outline (footprint) ends 0.60 m beyond left, right; move its edge"));
  EXPECT_EQ(out_.str().find(to_yaml(parse_config(out_.str(), "f"))), 0U) << "what it adds is a comment";
  out_.str("");
  ASSERT_EQ(check(vehicle + "[0, -1], [0, 1], [-4, 1]]}\n"), 0);
  EXPECT_THAT(out_.str(), AllOf(HasSubstr("# merged_scans.scan: 9"), HasSubstr("(ahead 100 %)")));
}

TEST_F(Check, RemarksAreNoErrors) {
  EXPECT_EQ(check("sensors: {rear: {topic: scan}}\n"), 0);
  EXPECT_EQ(err_.str(), path_ + ":1:11: sensors.rear is used by no merged and no virtual scan\n");
  EXPECT_NE(out_.str(), "");
}

TEST_F(Check, WhatOnlyTfOrAnotherNodeCanTellIsSaidAtOnce) {
  EXPECT_EQ(check("sensors:\n"
                  "  front: {model: sick_microscan3, ip_address: 192.168.0.21, pose: {xyz: [1, 0, 0]}}\n"
                  "  back: {model: sick_microscan3, ip_address: 192.168.0.22}\n"
                  "  rear: {topic: /rear/scan}\n"
                  "merged_scans:\n"
                  "  all: {laserscan_topics: [front, back, rear]}\n"
                  "  known: {laserscan_topics: [front]}\n"
                  "  same_frame: {laserscan_topics: [back], destination_frame: back}\n"
                  "  nowhere: {laserscan_topics: [front], destination_frame: gripper}\n"),
            0);
  EXPECT_EQ(err_.str(),
            path_ +
                ":6:3: merged_scans.all: the poses of back, rear come from tf only; without tf (replay "
                "--bag, snapshot) what needs it is left out: configure it\n" +
                path_ +
                ":6:3: merged_scans.all: rear comes from /rear/scan, which another node must publish; a "
                "replay has it if a bag does\n" +
                path_ +
                ":9:3: merged_scans.nowhere: the pose of destination_frame gripper comes from tf only; "
                "without tf (replay --bag, snapshot) nothing comes out: configure it\n");
}

TEST_F(Check, AVirtualScanWhoseFrameOrCloudHasNoPoseIsSaidAtOnce) {
  EXPECT_EQ(
      check("sensors:\n"
            "  roof: {model: velodyne_vlp16, pose: {xyz: [0, 0, 2]}}\n"
            "  mast: {model: velodyne_vlp16, ip_port: 2369}\n"
            "virtual_scans:\n"
            "  some: {cloud_topic: roof, virtual_laser_scan: [low, high], poses: {low: {xyz: [0, 0, 1]}}}\n"
            "  own: {cloud_topic: mast, virtual_laser_scan: [mast]}\n"
            "  proof: {cloud_topic: mast, virtual_laser_scan: [chest], profile: strict,\n"
            "    poses: {chest: {xyz: [0, 0, 1]}}}\n"),
      0)
      << err_.str();
  EXPECT_EQ(err_.str(),
            path_ +
                ":5:3: virtual_scans.some: the pose of high comes from tf only; without tf (replay --bag, "
                "snapshot) what needs it is left out: configure it\n" +
                path_ +
                ":7:3: virtual_scans.proof: the pose of mast comes from tf only; without tf (replay "
                "--bag, snapshot) nothing comes out: configure it\n");
}

TEST_F(Check, AMergedCloudIsSaidToNeedPosesAndTopicsOfOthers) {
  EXPECT_EQ(check("sensors:\n"
                  "  roof: {model: velodyne_vlp16, pose: {xyz: [0, 0, 2]}}\n"
                  "  mast: {model: velodyne_vlp16, ip_port: 2369}\n"
                  "  rear: {topic: /rear/points, pose: {xyz: [0, 0, 1]}}\n"
                  "merged_clouds:\n"
                  "  all: {sources: [roof, mast, rear]}\n"
                  "  nowhere: {sources: [roof], destination_frame: gripper}\n"
                  "virtual_scans:\n"
                  "  some: {cloud_topic: all, virtual_laser_scan: [low], poses: {low: {xyz: [0, 0, 1]}}, "
                  "profile: strict}\n"),
            0)
      << err_.str();
  const std::string tf = " from tf only; without tf (replay --bag, snapshot) ";
  const std::string topic =
      ": rear comes from /rear/points, which another node must publish; a replay has it if a bag does\n";
  EXPECT_EQ(err_.str(),
            path_ + ":6:3: merged_clouds.all: the pose of mast comes" + tf +
                "what needs it is left out: configure it\n" + path_ + ":6:3: merged_clouds.all" + topic +
                path_ + ":7:3: merged_clouds.nowhere: the pose of destination_frame gripper comes" + tf +
                "nothing comes out: configure it\n" + path_ +
                ":9:3: virtual_scans.some: the pose of mast comes" + tf +
                "what needs it is left out: configure it\n" + path_ + ":9:3: virtual_scans.some" + topic);
}

TEST_F(Check, MistakesGiveExitCode78AndOneLine) {
  EXPECT_EQ(check("sensors: {rear: {topc: scan}}\n"), 78);
  EXPECT_EQ(out_.str(), "");
  EXPECT_EQ(err_.str(), path_ + ":1:18: unknown key sensors.rear.topc; expected topic\n");
}

TEST_F(Check, AMissingFileGivesExitCode78) {
  EXPECT_EQ(run_check("/nowhere.yaml", out_, err_), 78);
  EXPECT_EQ(err_.str(),
            "/nowhere.yaml: cannot be read: No such file or directory; expected a readable YAML file\n");
}

}  // namespace
}  // namespace lidard
