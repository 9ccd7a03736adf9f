// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/check.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "daemon/config.h"

namespace lidard {
namespace {

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
