// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What is said of this host's network while a sensor is silent.
#include "daemon/live/host_causes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/support/says.h"

namespace lidard {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

const IpAddress host = IpAddress::v4(192, 168, 1, 100);

SensorConfig sensor(const std::string& keys = "model: velodyne_vlp16, ip_address: 192.168.1.201") {
  return parse_config("sensors: {roof: {" + keys + "}}", "c").sensors.at(0);
}

HostInterface loopback() { return {"lo", IpAddress::v4(127, 0, 0, 1), 8, true, true, true, 0}; }
HostInterface lidar0() { return {"lidar0", host, 24, true, true, false, 1000}; }

HostNetwork network(std::vector<HostInterface> interfaces) {
  HostNetwork all;
  all.interfaces = std::move(interfaces);
  return all;
}

TEST(HostCauses, NameAnInterfaceThatIsOffOrHasNoLink) {
  HostInterface in = lidar0();
  EXPECT_EQ(host_trouble(sensor(), network({loopback(), in}), true), "");
  in.has_link = false;
  EXPECT_EQ(host_trouble(sensor(), network({loopback(), in}), true),
            "lidar0 (192.168.1.100/24) has no link; check the cable, the switch and the sensor's power");
  in.up = false;
  EXPECT_EQ(host_trouble(sensor(), network({loopback(), in}), true),
            "lidar0 (192.168.1.100/24) is switched off; switch it on: `ip link set lidar0 up`");
  HostInterface second = lidar0();
  second.name = "lidar1";
  EXPECT_EQ(host_trouble(sensor(), network({in, second}), true), "") << "one way is enough";
}

TEST(Alternation, TakesTwoHardwareAddressesThatTakeTurnsForTwoDevices) {
  using namespace std::chrono_literals;
  const auto begin = Stamp{1'000'000'000};
  Alternation watch;
  watch.observe("60:76:88:00:00:01", begin);
  watch.observe("60:76:88:00:00:01", begin + 1s);
  EXPECT_EQ(watch.both(begin + 1s), "");
  watch.observe("60:76:88:00:00:02", begin + 2s);
  EXPECT_EQ(watch.both(begin + 2s), "") << "the device may have been exchanged";
  watch.observe("60:76:88:00:00:01", begin + 30s);
  EXPECT_EQ(watch.both(begin + 31s), "60:76:88:00:00:01 and 60:76:88:00:00:02");
  EXPECT_EQ(watch.both(begin + 11min), "");
  watch.observe("60:76:88:00:00:02", begin + 12min);
  EXPECT_EQ(watch.both(begin + 12min), "") << "a spare, and days later the first device again";
  watch.observe("60:76:88:00:00:01", begin + 13min);
  EXPECT_EQ(watch.both(begin + 13min), "60:76:88:00:00:01 and 60:76:88:00:00:02");
}

TEST(Alternation, CountsReturnsOfPacketsWhichFollowEachOtherSoon) {
  using namespace std::chrono_literals;
  Stamp now{1'000'000'000};
  Alternation watch(8, 10s);
  const auto take_turns = [&](int times, Span after) {
    for (int i = 0; i < times; ++i) {
      now = now + after;
      watch.observe(i % 2 == 0 ? "scanner 9" : "scanner 17", now);
    }
    return watch.both(now);
  };
  EXPECT_EQ(take_turns(20, 11s), "") << "exchanged again and again";
  EXPECT_EQ(take_turns(6, 30ms), "");
  EXPECT_EQ(take_turns(4, 30ms), "scanner 17 and scanner 9");
  now = now + 11s;
  EXPECT_EQ(watch.both(now), "") << "one of them was switched off";
}

TEST(HostCauses, NameTheAddressThatIsMissing) {
  const HostInterface bare{"lidar0", {}, 0, true, true, false, 0};
  const HostInterface office{"eth0", IpAddress::v4(10, 0, 0, 5), 8, true, true, false, 0};
  const std::string missing = host_trouble(sensor(), network({loopback(), office, bare}), false);
  EXPECT_EQ(missing,
            "no interface of this host has an address in the network of 192.168.1.201 (there is eth0 "
            "(10.0.0.5/8)); add one: `ip address add 192.168.1.100/24 dev lidar0`");
  EXPECT_THAT(
      host_trouble(sensor("model: velodyne_vlp16, ip_address: 192.168.1.100"), network({office}), true),
      EndsWith("(10.0.0.5/8)); unless a router leads there, add one: `ip address add 192.168.1.101/24 "
               "dev eth0`"));
  EXPECT_THAT(host_trouble(sensor(), network({loopback()}), false),
              AllOf(HasSubstr("(there is none)"), HasSubstr("dev INTERFACE")));
  EXPECT_EQ(host_trouble(sensor("model: velodyne_vlp16"), network({loopback()}), false), "")
      << "from anybody";
  EXPECT_EQ(host_trouble(sensor("topic: /scan"), network({loopback()}), false), "");
}

TEST(HostCauses, KnowTheInterfaceOfAGroupWhereTheSensorsNetworkIsNotThisHosts) {
  HostInterface in = lidar0();
  in.has_link = false;
  const auto by_group =
      sensor("model: velodyne_vlp16, ip_address: 10.9.9.9, multicast_group: 239.0.0.1, interface: lidar0");
  EXPECT_THAT(host_trouble(by_group, network({in}), true),
              StartsWith("lidar0 (192.168.1.100/24) has no link"));
}

TEST(HostCauses, AddressesBelongToTheNetworkOfTheirFirstBits) {
  HostInterface in = lidar0();
  EXPECT_TRUE(in.reaches(IpAddress::v4(192, 168, 1, 255)));
  EXPECT_FALSE(in.reaches(IpAddress::v4(192, 168, 2, 1)));
  in.prefix = 25;
  EXPECT_FALSE(in.reaches(IpAddress::v4(192, 168, 1, 128)));
  in.prefix = 32;
  EXPECT_TRUE(in.reaches(host));
  in.prefix = 0;
  EXPECT_FALSE(in.reaches(host));
}

TEST(HostCauses, TellByWhatWasCountedWhyNothingMayCome) {
  const HostNetwork before = network({lidar0()});
  bool others_talk = false;
  const auto hint = [&](std::uint32_t packets, std::uint64_t dropped, std::uint64_t without_port) {
    HostNetwork now = before;
    now.interfaces[0].packets += packets;
    now.dropped_by_path = dropped;
    now.without_port = without_port;
    return host_hint(sensor(), {before, now, 2, others_talk});
  };
  EXPECT_THAT(hint(0, 0, 0), StartsWith("next to nothing comes in at lidar0 (192.168.1.100/24); check"));
  EXPECT_EQ(hint(100, 0, 0), "");
  EXPECT_THAT(hint(1508, 0, 0),
              StartsWith("754 packets/s come in at lidar0 (192.168.1.100/24), but none from "
                         "192.168.1.201 to port 2368; does it send elsewhere, or does a "
                         "firewall drop them?"));
  EXPECT_EQ(hint(1490, 0, 0), hint(1507, 0, 0).replace(0, 3, "745")) << "a single return is no limit";
  others_talk = true;
  EXPECT_EQ(hint(1508, 0, 0), "") << "they may be theirs";
  HostNetwork filtered = before;
  filtered.interfaces[0].packets += 1900, filtered.undelivered = 1508;
  EXPECT_THAT(host_hint(sensor(), {before, filtered, 2, true}),
              StartsWith("754 packets/s come in at lidar0 (192.168.1.100/24), but none from 192.168.1.201 to "
                         "port 2368; does it send elsewhere, or does a firewall drop them?"))
      << "also beside a scanner that sends over TCP";
  EXPECT_THAT(hint(1508, 0, 1508),
              StartsWith("754 datagrams/s come to ports of this host where nobody listens"));
  EXPECT_THAT(hint(1508, 1508, 0),
              testing::AllOf(HasSubstr("drops 754 packets/s"), test::Says(says::path_filter)));
  EXPECT_EQ(host_hint(sensor("model: sick_lms1xx, ip_address: 192.168.1.201"), {before, before, 2}), "");
  HostNetwork elsewhere = before;
  elsewhere.for_others = 1508;
  EXPECT_THAT(host_hint(sensor(), {before, elsewhere, 2, true}),
              StartsWith("754 packets/s come in for an address that this host does not have"));
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
