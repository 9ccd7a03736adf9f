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
