// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/velodyne/velodyne_scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <std_msgs/Header.h>

#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/connection.h"
#include "daemon/ros/in/inputs.h"
#include "test/sim/servers/velodyne_stream.h"
#include "test/support/recording_sink.h"
#include "test/support/ros_master.h"
#include "test/support/ros_posted.h"

/// The message of velodyne_msgs as its own package defines it, written here a second time.
namespace lidard::test {

struct VelodynePacket {
  ros::Time stamp;
  boost::array<std::uint8_t, 1206> data;
};
struct VelodyneScan {
  std_msgs::Header header;
  std::vector<VelodynePacket> packets;
  std::size_t cut = 0;  ///< bytes left out at the end, to make a bad message
};

}  // namespace lidard::test

namespace ros::message_traits {
template <>
struct MD5Sum<lidard::test::VelodyneScan> {
  static const char* value() { return "50804fc9533a0e579e6322c04ae70566"; }
  static const char* value(const lidard::test::VelodyneScan&) { return value(); }
};
template <>
struct DataType<lidard::test::VelodyneScan> {
  static const char* value() { return "velodyne_msgs/VelodyneScan"; }
  static const char* value(const lidard::test::VelodyneScan&) { return value(); }
};
template <>
struct Definition<lidard::test::VelodyneScan> {
  static const char* value() { return "Header header\nVelodynePacket[] packets\n"; }
  static const char* value(const lidard::test::VelodyneScan&) { return value(); }
};
}  // namespace ros::message_traits

namespace ros::serialization {
template <>
struct Serializer<lidard::test::VelodyneScan> {
  template <typename Stream>
  static void write(Stream& stream, const lidard::test::VelodyneScan& m) {
    std::vector<std::uint8_t> whole(serializedLength(m) + m.cut);
    OStream all(whole.data(), static_cast<std::uint32_t>(whole.size()));
    all.next(m.header);
    all.next(static_cast<std::uint32_t>(m.packets.size()));
    for (const auto& packet : m.packets) {
      all.next(packet.stamp);
      std::memcpy(all.advance(1206), packet.data.data(), 1206);
    }
    std::memcpy(stream.advance(serializedLength(m)), whole.data(), serializedLength(m));
  }
  static std::uint32_t serializedLength(const lidard::test::VelodyneScan& m) {
    const std::uint32_t header = serializationLength(m.header);
    return header + 4 + static_cast<std::uint32_t>(m.packets.size() * 1214 - m.cut);
  }
};
}  // namespace ros::serialization

namespace lidard {
namespace {

using namespace std::chrono_literals;
using sim::SimulatedPacket;
using test::Child;
using test::in_own_process;
using test::RosMaster;

std::vector<SimulatedPacket> packets() {
  sim::VelodyneSetup setup;
  setup.duration = std::chrono::milliseconds(450);
  return simulate_velodyne(setup);
}

test::VelodyneScan scan_of(const std::vector<SimulatedPacket>& all, std::size_t from, std::size_t count) {
  test::VelodyneScan scan;
  scan.header.frame_id = "velodyne";
  for (std::size_t i = from; i < std::min(from + count, all.size()); ++i) {
    scan.packets.emplace_back();
    const auto ns = static_cast<std::uint64_t>(all[i].arrival.ns);
    scan.packets.back().stamp.fromNSec(ns);
    std::copy(all[i].payload.begin(), all[i].payload.end(), scan.packets.back().data.begin());
  }
  return scan;
}

std::vector<std::uint8_t> bytes_of(const test::VelodyneScan& scan) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(scan));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, scan);
  return bytes;
}

const char* read(const std::vector<std::uint8_t>& bytes, std::size_t& taken) {
  taken = 0;
  return read_velodyne_scan({bytes.data(), bytes.size()}, [&](ByteView, HostStamp) { ++taken; });
}

TEST(VelodyneScanMessage, HandsOnEveryPacketWithItsStamp) {
  const auto all = packets();
  const auto bytes = bytes_of(scan_of(all, 3, 20));
  std::size_t at = 3;
  EXPECT_EQ(
      read_velodyne_scan({bytes.data(), bytes.size()},
                         [&](ByteView payload, HostStamp arrival) {
                           EXPECT_EQ(arrival.ns, all[at].arrival.ns);
                           EXPECT_TRUE(std::equal(payload.begin(), payload.end(), all[at].payload.begin()));
                           ++at;
                         }),
      nullptr);
  EXPECT_EQ(at, 23U);
}

TEST(VelodyneScanMessage, DefinesItsPacketsAsTheirPackageDoes) {
  EXPECT_THAT(VelodyneScanMessage().message_type().definition,
              testing::EndsWith("=\nMSG: velodyne_msgs/VelodynePacket\ntime stamp\nuint8[1206] data\n"));
  EXPECT_TRUE(VelodyneScanMessage().message_type().begins_with_header) << "roscpp numbers it";
}

TEST(VelodyneScanMessage, CutOffAnywhereGivesNoPacket) {
  const auto bytes = bytes_of(scan_of(packets(), 0, 2));
  std::size_t taken = 0;
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const std::vector<std::uint8_t> part(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    ASSERT_NE(read(part, taken), nullptr) << length;
    ASSERT_EQ(taken, 0U);
  }
  auto longer = bytes;
  longer.push_back(0);
  EXPECT_NE(read(longer, taken), nullptr);
  auto lying = bytes;
  for (int i = 0; i < 4; ++i) lying[24 + static_cast<std::size_t>(i)] = 0xff;  // number of packets
  EXPECT_NE(read(lying, taken), nullptr);
  for (int i = 0; i < 4; ++i) lying[12 + static_cast<std::size_t>(i)] = 0xff;  // length of the name
  EXPECT_NE(read(lying, taken), nullptr);
  EXPECT_EQ(read(bytes, taken), nullptr);
  EXPECT_EQ(taken, 2U);
}

/// A pipeline whose one sensor takes its packets from a topic, fed by RosInputs.
struct Listening {
  Config config =
      parse_config("sensors: {roof: {model: velodyne_vlp16, packet_topic: /velodyne_packets}}", "f");
  NoTransforms poses;
  test::RecordingSink sink;
  Pipeline pipeline{config, poses, sink};
  test::Posted posted;
  Stamp now = packets().back().arrival;  // messages come as soon as they are sent
  RosConnection connection{{}, {}};
  std::shared_ptr<RosInputs> inputs = std::make_shared<RosInputs>(
      std::vector<TopicSource>{{"roof", "/velodyne_packets", true}}, posted.post());

  Listening() {
    connection.add(inputs);
    connection.start();
  }
  bool run_until(const std::function<bool()>& done) { return posted.run_until(pipeline, now, done, 20s); }
};

TEST(VelodyneScanTopic, GivesTheCloudsThatThePacketsGiveByUdp) {
  in_own_process([] {
    RosMaster master;
    const auto all = packets();
    const Child driver([all] {
      ros::init(ros::M_string(), "driver", ros::init_options::AnonymousName | ros::init_options::NoRosout);
      ros::NodeHandle node;
      auto publisher = node.advertise<test::VelodyneScan>("velodyne_packets", 100);
      while (ros::ok() && publisher.getNumSubscribers() == 0) ros::WallDuration(0.01).sleep();
      for (std::size_t i = 0; i < all.size(); i += 76) {
        publisher.publish(scan_of(all, i, 76));
        ros::WallDuration(0.05).sleep();
      }
      ros::spin();
    });
    master.start();
    Listening here;
    EXPECT_TRUE(here.run_until(
        [&] { return here.pipeline.status(here.pipeline.now()).sensors[0].counters.packets == all.size(); }));
    here.pipeline.finish(all.back().arrival);

    const Config config = parse_config("sensors: {roof: {model: velodyne_vlp16}}", "f");
    NoTransforms poses;
    test::RecordingSink by_port;
    Pipeline by_udp(config, poses, by_port);
    for (const auto& packet : all) by_udp.packet({packet.view(), packet.arrival, {}, {{}, 2368}});
    by_udp.finish(all.back().arrival);
    const auto& expected = by_port.clouds["roof/points"];
    const auto& clouds = here.sink.clouds["roof/points"];
    ASSERT_GE(expected.size(), 3U);
    ASSERT_EQ(clouds.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(clouds[i].stamp, expected[i].stamp);
      EXPECT_EQ(clouds[i].points_bytes, expected[i].points_bytes);
    }
    EXPECT_EQ(here.inputs->report().at(0).type, "velodyne_msgs/VelodyneScan");
    EXPECT_EQ(here.inputs->report().at(0).rejected, 0U);
    EXPECT_TRUE(here.connection.stop());
  });
}

TEST(VelodyneScanTopic, CountsMessagesThatAreCutOffAndGoesOn) {
  in_own_process([] {
    RosMaster master;
    const Child driver([] {
      ros::init(ros::M_string(), "driver", ros::init_options::AnonymousName | ros::init_options::NoRosout);
      ros::NodeHandle node;
      auto publisher = node.advertise<test::VelodyneScan>("velodyne_packets", 100);
      auto scan = scan_of(packets(), 0, 5);
      for (ros::WallRate rate(50); ros::ok(); rate.sleep()) {
        scan.cut = scan.cut == 0 ? 7 : 0;
        publisher.publish(scan);
      }
    });
    master.start();
    Listening here;
    EXPECT_TRUE(here.run_until([&] {
      return here.inputs->report().at(0).rejected >= 3 &&
             here.pipeline.status(here.pipeline.now()).sensors[0].counters.packets >= 15;
    }));
    EXPECT_EQ(here.inputs->report().at(0).last_reason, "the message is shorter than its own counts say");
    EXPECT_EQ(here.inputs->diagnostics().at(0).health, Health::warn);
    EXPECT_TRUE(here.connection.stop());
  });
}

}  // namespace
}  // namespace lidard
