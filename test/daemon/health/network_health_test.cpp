// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What is said of ports, connections and this host's network.
#include "daemon/health/network_health.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/config/config.h"
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

TEST(HostFaults, NameAnInterfaceThatIsOffOrHasNoLink) {
  HostInterface in = lidar0();
  EXPECT_EQ(host_trouble(sensor(), network({loopback(), in}), true), "");
  in.has_link = false;
  EXPECT_EQ(host_trouble(sensor(), network({loopback(), in}), true),
            "lidar0 (192.168.1.100/24) has no link; check the cable, the switch and the sensor's power");
  in.up = false;
  EXPECT_EQ(host_trouble(sensor(), network({loopback(), in}), true),
            "lidar0 (192.168.1.100/24) is switched off; switch it on: `ip link set lidar0 up`");
  const auto scanner = sensor("model: sick_lms1xx, ip_address: 192.168.9.11");
  EXPECT_EQ(host_trouble(scanner, network({in}), true), "") << "a router leads to it: TCP says more";
  EXPECT_NE(host_trouble(scanner, network({in}), false), "");
  HostInterface second = lidar0();
  second.name = "lidar1";
  EXPECT_EQ(host_trouble(sensor(), network({in, second}), true), "") << "one way is enough";
}

TEST(HostFaults, NameTheAddressThatIsMissing) {
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

TEST(HostFaults, KnowTheInterfaceOfAGroupWhereTheSensorsNetworkIsNotThisHosts) {
  HostInterface in = lidar0();
  in.has_link = false;
  const auto by_group =
      sensor("model: velodyne_vlp16, ip_address: 10.9.9.9, multicast_group: 239.0.0.1, interface: lidar0");
  EXPECT_THAT(host_trouble(by_group, network({in}), true),
              StartsWith("lidar0 (192.168.1.100/24) has no link"));
}

TEST(HostFaults, TellByWhatWasCountedWhyNothingMayCome) {
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

const Endpoint scanner{IpAddress::v4(192, 168, 1, 11), 2112};

TEST(ConnectionFaults, NameTheDeviceWithCauseAndRemedy) {
  using Kind = TcpFault::Kind;
  EXPECT_EQ(fault_text(TcpFault(), scanner), "");
  EXPECT_EQ(
      fault_text({Kind::not_connected, ECONNREFUSED}, scanner),
      "192.168.1.11:2112 refuses the connection; is this the device's port, and does another program use "
      "the device already? it is tried again");
  for (const int error : {ETIMEDOUT, EHOSTUNREACH, EHOSTDOWN})
    EXPECT_EQ(
        fault_text({Kind::not_connected, error}, scanner),
        "192.168.1.11:2112 does not answer; check the device's power, cable and address, it is tried again");
  EXPECT_EQ(
      fault_text({Kind::not_connected, ENETUNREACH}, scanner),
      "192.168.1.11:2112 cannot be reached (Network is unreachable); check cable and this host's network "
      "address, it is tried again");
  EXPECT_THAT(fault_text({Kind::not_connected, EMFILE}, scanner), test::Says(says::no_socket));
  EXPECT_EQ(fault_text({Kind::not_connected, EINVAL}, scanner),
            "no connection to 192.168.1.11:2112: Invalid argument; it is tried again");
  EXPECT_THAT(fault_text({Kind::ended}, scanner), test::Says(says::connection_closed));
  EXPECT_THAT(fault_text({Kind::ended, EPIPE}, scanner), test::Says(says::connection_reset));
  EXPECT_THAT(fault_text({Kind::ended, ETIMEDOUT}, scanner), test::Says(says::no_answer_any_more));
  EXPECT_EQ(fault_text({Kind::ended, EHOSTUNREACH}, scanner),
            "the connection to 192.168.1.11:2112 broke: No route to host; it is opened again");
  EXPECT_EQ(
      fault_text({Kind::silent, 0, std::chrono::seconds(12)}, scanner),
      "192.168.1.11:2112 sent nothing for 12.0 s; is it still starting, or has it lost power or cable? the "
      "connection is opened again");
  EXPECT_THAT(fault_text({Kind::dialogue_failed}, scanner), test::Says(says::dialogue_failed));
}

TEST(ConnectionFaults, StayDuringTheNextAttempt) {
  EXPECT_EQ(state_text({TcpState::Phase::connecting}, scanner), "connecting");
  EXPECT_EQ(state_text({TcpState::Phase::connected}, scanner), "connected");
  EXPECT_EQ(state_text({TcpState::Phase::stopped}, scanner), "stopped");
  EXPECT_THAT(state_text({TcpState::Phase::connecting, {TcpFault::Kind::ended}}, scanner),
              test::Says(says::connection_closed));
}

TEST(PortFaults, NameThePortWithCauseAndRemedy) {
  EXPECT_EQ(fault_text(UdpFault(), 2368), "");
  UdpFault fault{EADDRINUSE, {}, {"1000", "velodyne_node", "4711"}};
  EXPECT_EQ(
      fault_text(fault, 2368),
      "port 2368 is in use by another program; find it with `ss -lunp 'sport = :2368'` (it is velodyne_node, "
      "process 4711)");
  fault.holder = {"1000", "", ""};
  EXPECT_THAT(fault_text(fault, 2368), EndsWith("'sport = :2368'` (it is a program of user 1000)"));
  fault.holder = {};
  EXPECT_THAT(fault_text(fault, 2368), EndsWith("'sport = :2368'`"));
  EXPECT_THAT(fault_text({EACCES}, 80), StartsWith("this user may not open port 80; ports below 1024 need"));
  EXPECT_THAT(fault_text({ENFILE}, 2368), test::Says(says::no_socket));
  EXPECT_EQ(fault_text({ENOMEM}, 2368),
            "cannot receive at UDP port 2368: Cannot allocate memory; it is tried again");
}

TEST(PortFaults, NameTheGroupThatIsNotJoined) {
  const auto text = [](const std::string& interface, int error) {
    return fault_text({error, {IpAddress::v4(239, 1, 2, 3), interface}}, 2368);
  };
  EXPECT_EQ(
      text("eth7", ENXIO),
      "cannot join the multicast group 239.1.2.3: there is no interface eth7; compare with `ip link`, it is "
      "joined as soon as there is one");
  EXPECT_THAT(text("10.0.0.7", ENODEV),
              HasSubstr("no interface has the address 10.0.0.7; compare with `ip -4"));
  EXPECT_THAT(text("", ENODEV), HasSubstr("no interface leads to it; name the sensor's interface"));
  EXPECT_THAT(text("", ENOBUFS), EndsWith("239.1.2.3: No buffer space available; it is tried again"));
}

TEST(PortFaults, ABufferThatIsTooSmallIsAWarningWithTheTimeItLasts) {
  UdpStats stats;
  stats.receive_buffer_asked = stats.receive_buffer_got = 1041638;
  EXPECT_EQ(buffer_text(stats, 2368), "");
  stats.receive_buffer_got = 212992, stats.receive_buffer_lasts = std::chrono::milliseconds(122);
  EXPECT_EQ(
      buffer_text(stats, 2368),
      "the receive buffer of port 2368 has 212992 bytes instead of 1041638, so packets are lost when the "
      "machine is busy for more than 122 ms; run `sysctl -w net.core.rmem_max=1041638`");
}

}  // namespace
}  // namespace lidard
