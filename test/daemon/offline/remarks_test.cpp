// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Which remarks are made of which configuration: test/daemon/config/answers/remarks.txt.
#include "daemon/offline/remarks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/support/captures.h"

namespace lidard {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Remarks, AreMadeOfACalibrationOfAnotherModel) {
  LIDARD_NEED_CAPTURE(file, std::string("calibration/VLP16_hires.yaml"));
  const auto remarks = [&](const std::string& model) {
    return remarks_on(parse_config("sensors: {a: {model: " + model + ", calibration: " + file + "}}\n", "f"));
  };
  EXPECT_THAT(
      remarks("velodyne_vlp16"),
      ElementsAre(HasSubstr("a.calibration has elevations up to 5.0 deg off those of VLP-16, and fits "
                            "Puck Hi-Res: is it the right file?")));
  EXPECT_THAT(remarks("velodyne_puck_hires"), IsEmpty());
}

TEST(Remarks, OnTheNetworkOfThisHostAreForTheCommandsThatUseIt) {
  for (const char* keys : {"model: sick_microscan3, ip_address: 10.0.0.1, udp_receiver_ip: 203.0.113.5",
                           "model: velodyne_vlp16, ip_port: 368"}) {
    const Config config = parse_config(std::string("sensors: {a: {") + keys + "}}\n", "f");
    EXPECT_THAT(remarks_on(config), IsEmpty()) << "replay, snapshot and calibrate show these";
    EXPECT_EQ(host_remarks_on(config).size(), 1U) << keys;
  }
}

}  // namespace
}  // namespace lidard
