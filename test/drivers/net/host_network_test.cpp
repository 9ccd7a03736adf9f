// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/net/host_network.h"

#include <gtest/gtest.h>

namespace lidard {
namespace {

TEST(HostNetwork, AddressesBelongToTheNetworkOfTheirFirstBits) {
  const IpAddress host = IpAddress::v4(192, 168, 1, 100);
  HostInterface in{"lidar0", host, 24, true, true, false, 1000};
  EXPECT_TRUE(in.reaches(IpAddress::v4(192, 168, 1, 255)));
  EXPECT_FALSE(in.reaches(IpAddress::v4(192, 168, 2, 1)));
  in.prefix = 25;
  EXPECT_FALSE(in.reaches(IpAddress::v4(192, 168, 1, 128)));
  in.prefix = 32;
  EXPECT_TRUE(in.reaches(host));
  in.prefix = 0;
  EXPECT_FALSE(in.reaches(host));
}

TEST(HostNetwork, IsThatOfThisHostWithoutAPrivilege) {
  const HostNetwork here = read_network();
  bool found = false;
  for (const HostInterface& each : here.interfaces) {
    if (each.address != IpAddress::v4(127, 0, 0, 1)) continue;
    found = true;
    EXPECT_EQ(each.to_string(), "lo (127.0.0.1/8)");
    EXPECT_TRUE(each.up && each.has_link && each.loopback);
  }
  EXPECT_TRUE(found);
  EXPECT_TRUE(has_route_to(IpAddress::v4(127, 0, 0, 1)));
}

}  // namespace
}  // namespace lidard
