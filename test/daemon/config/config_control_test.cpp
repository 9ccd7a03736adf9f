// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;

/// A VLP-16 named roof with this `control:`.
std::string roof(const std::string& control) {
  return "sensors: {roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, control: {" + control + "}}}\n";
}

VelodyneControl control_of(const std::string& control) {
  return parse_config(roof(control), "f").sensors.at(0).control;
}

TEST(ControlConfig, AsksAndWritesNothingByDefault) {
  const Config config = parse_config("sensors: {roof: {model: velodyne_vlp16}}", "f");
  for (const VelodyneControl& control : {config.sensors.at(0).control, control_of("")}) {
    EXPECT_FALSE(control.allow_write);
    EXPECT_FALSE(control.wanted.any());
    EXPECT_EQ(control.port, 80);
  }
  EXPECT_EQ(config.sensors.at(0).driver.control, nullptr);
  EXPECT_EQ(parse_config(roof("allow_write: true"), "f").sensors.at(0).driver.control, nullptr);
  EXPECT_NE(parse_config(roof("allow_write: true, rpm: 600"), "f").sensors.at(0).driver.control, nullptr);
}

TEST(ControlConfig, TakesEveryKey) {
  const VelodyneControl control = control_of(
      "allow_write: true, port: 8080, rpm: 900, returns: dual, fov_start_deg: 270, fov_end_deg: 90, "
      "host_address: 192.168.1.77, host_port: 2368, host_telemetry_port: 8309");
  EXPECT_TRUE(control.allow_write);
  EXPECT_EQ(control.port, 8080);
  const VelodyneSettings& wanted = control.wanted;
  EXPECT_EQ(wanted.rpm, 900);
  EXPECT_EQ(wanted.returns, VelodyneReturns::dual);
  EXPECT_EQ(wanted.fov_start_deg, 270);
  EXPECT_EQ(wanted.fov_end_deg, 90);
  EXPECT_EQ(wanted.host_address, IpAddress::v4(192, 168, 1, 77));
  EXPECT_EQ(wanted.host_port, 2368);
  EXPECT_EQ(wanted.host_telemetry_port, 8309);
}

TEST(ControlConfig, WarnsWhereTheSensorWouldSendElsewhere) {
  const Config config = parse_config(roof("allow_write: true, host_port: 2400"), "f");
  ASSERT_EQ(config.warnings.size(), 1U);
  EXPECT_THAT(config.warnings[0],
              HasSubstr("control.host_port makes the sensor send to a port that is not its ip_port, 2368"));
}

TEST(ControlConfig, IsPrintedWithWhatIsWanted) {
  EXPECT_THAT(to_yaml(parse_config("sensors: {roof: {model: velodyne_vlp16}}", "f")),
              HasSubstr("    control: {allow_write: false, port: 80}\n"));
  EXPECT_THAT(
      to_yaml(parse_config(
          roof("allow_write: true, rpm: 900, returns: last, fov_start_deg: 270, fov_end_deg: 360, "
               "host_address: 239.0.0.1, host_port: 2368, host_telemetry_port: 1"),
          "f")),
      HasSubstr("control: {allow_write: true, port: 80, rpm: 900, returns: last, fov_start_deg: 270, "
                "fov_end_deg: 360, host_address: 239.0.0.1, host_port: 2368, host_telemetry_port: 1}\n"));
}

}  // namespace
}  // namespace lidard
