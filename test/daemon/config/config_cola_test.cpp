// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using test::error_of;

TEST(ColaConfig, AsksForNothingByDefault) {
  const Config config = parse_config("sensors: {a: {model: sick_lms1xx, ip_address: 192.168.0.1}}", "f");
  const DeviceRequests& requests = config.sensors.at(0).driver.requests;
  EXPECT_FALSE(requests.allow_write);
  EXPECT_FALSE(requests.device_states);
  EXPECT_FALSE(requests.skip.has_value());
  EXPECT_EQ(config.sensors[0].ip_port, 2112);
}

TEST(ColaConfig, TakesItsKeys) {
  for (const std::string model : {"sick_lms5xx", "sick_mrs1000"}) {
    const Config config = parse_config(
        "sensors: {a: {model: " + model + ", ip_address: 192.168.0.1, skip: 2, publish_states: true}}", "f");
    const DeviceRequests& requests = config.sensors.at(0).driver.requests;
    EXPECT_EQ(requests.skip, 2);
    EXPECT_TRUE(requests.device_states);
  }
}

TEST(ColaConfig, RefusesWhatItCannotDo) {
  EXPECT_NE(error_of("sensors: {a: {model: sick_lms1xx, ip_address: 10.0.0.1, skip: -1}}"), "no error");
  EXPECT_NE(error_of("sensors: {a: {model: velodyne_vlp16, publish_states: true}}"), "no error");
  EXPECT_NE(error_of("sensors: {a: {model: sick_microscan3, skip: 1}}"), "no error");
}

}  // namespace
}  // namespace lidard
