// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using test::error_of;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A VLP-16 named roof with this `control:`, whose first key stands at line 1, column 78.
std::string roof(const std::string& control) {
  return "sensors: {roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, control: {" + control + "}}}\n";
}
const std::string line_1 = "f:1:";

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

TEST(ControlConfig, RefusesAWishWithoutPermissionToWrite) {
  const std::string why =
      "asks to change the sensor, but control.allow_write is not true; expected allow_write: true beside it, "
      "or "
      "no such key";
  EXPECT_EQ(error_of(roof("rpm: 600")), "f:1:78: sensors.roof.control.rpm " + why);
  EXPECT_EQ(error_of(roof("allow_write: false, returns: last")),
            "f:1:98: sensors.roof.control.returns " + why);
  for (const char* wish : {"fov_start_deg: 0, fov_end_deg: 90", "host_port: 2368"})
    EXPECT_THAT(error_of(roof(wish)), HasSubstr(why)) << wish;
}

TEST(ControlConfig, RefusesValuesThatTheSensorWouldNotTake) {
  const std::string prefix = "allow_write: true, ";
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"rpm: 299", "rpm is 299; expected a whole number from 300 to 1200"},
      {"rpm: 1260", "rpm is 1260; expected"},
      {"rpm: 601", "rpm is 601; expected a multiple of 60 from 300 to 1200"},
      {"returns: all", "returns is \"all\"; expected strongest, last or dual"},
      {"fov_start_deg: 360, fov_end_deg: 9", "fov_start_deg is 360; expected a whole number from 0 to 359"},
      {"fov_start_deg: 0.5, fov_end_deg: 9", "fov_start_deg is \"0.5\"; expected"},
      {"fov_start_deg: 0, fov_end_deg: 361", "fov_end_deg is 361; expected a whole number from 0 to 360"},
      {"fov_start_deg: 9, fov_end_deg: 9", "fov_end_deg is fov_start_deg too"},
      {"fov_start_deg: 9", "fov_start_deg is given alone; expected both"},
      {"host_address: roof.local", "host_address is \"roof.local\"; expected the IPv4 address"},
      {"host_address: 'fe80::1'", "host_address is \"fe80::1\""},
      {"host_address: 0.0.0.0", "host_address is \"0.0.0.0\""},
      {"host_port: 0", "host_port is 0; expected a whole number from 1 to 65535"},
      {"port: 65536", "control.port is 65536"},
      {"rpms: 600", "unknown key sensors.roof.control.rpms; expected rpm"},
      {"fov: {start_deg: 0}",
       "control.fov is a key of former versions; expected fov_start_deg and fov_end_deg"},
      {"read: true", "control.read is a key of former versions; expected no such key: the settings given"},
  };
  for (const auto& [text, message] : wrong) {
    const std::string error = error_of(roof(prefix + text));
    EXPECT_THAT(error, HasSubstr(message)) << text;
    EXPECT_THAT(error, StartsWith(line_1)) << text;
  }
}

TEST(ControlConfig, NeedsTheSensorsAddress) {
  EXPECT_EQ(error_of("sensors: {roof: {model: velodyne_vlp16, control: {allow_write: true, rpm: 600}}}"),
            "f:1:41: sensors.roof.control needs the sensor's address; expected ip_address: of the sensor");
}

TEST(ControlConfig, IsRefusedForOtherSensors) {
  EXPECT_EQ(
      error_of("sensors: {a: {model: sick_microscan3, control: {port: 80}}}"),
      "f:1:39: sensors.a.control is not available for sick_microscan3, only for Velodynes but the HDL-64E; "
      "expected no such key");
  EXPECT_THAT(error_of("sensors: {a: {model: velodyne_hdl64e_s3, control: {port: 80}}}"),
              HasSubstr("sensors.a.control is not available for velodyne_hdl64e_s3"));
  EXPECT_THAT(error_of("sensors: {a: {topic: /scan, control: {port: 80}}}"),
              HasSubstr("sensors.a.control does not apply to a source with topic:"));
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
