// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <diagnostic_msgs/DiagnosticArray.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ros/publication.h>
#include <ros/topic_manager.h>
#include <ros/xmlrpc_manager.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <thread>

#include "daemon/ros/connection.h"
#include "daemon/ros/master/environment.h"
#include "daemon/ros/master/master_client.h"
#include "daemon/ros/messages/convert.h"
#include "daemon/ros/messages/device_messages.h"
#include "test/support/ros_listener.h"
#include "test/support/ros_samples.h"
#include "test/support/says.h"
#include "test/support/starved.h"

namespace lidard {
namespace {

using namespace std::chrono_literals;
using test::in_own_process;
using test::Listener;
using test::RosMaster;
using test::sample_cloud;
using test::sample_scan;
using test::sample_topics;
using SteadyClock = std::chrono::steady_clock;

/// A replay, which waits instead of dropping.
RosOptions blocking() {
  RosOptions options;
  options.backpressure = Backpressure::block;
  return options;
}

/// Far above what a call takes on a crowded machine, far below what roscpp takes when the master hangs (15 s
/// and more).
constexpr auto surely_not_hanging = 3s;

/// At least five scans.
void publish_for(RosConnection& connection, std::chrono::milliseconds time) {
  const auto end = SteadyClock::now() + time;
  for (int n = 0; n < 5 || SteadyClock::now() < end; ++n) {
    connection.sink().publish(test::front_scan, sample_scan(), Stamp{1});
    std::this_thread::sleep_for(10ms);
  }
}

template <typename Condition>
bool soon(Condition condition, std::chrono::milliseconds limit = 20s) {
  const auto end = SteadyClock::now() + limit;
  while (!condition() && SteadyClock::now() < end) std::this_thread::sleep_for(5ms);
  return condition();
}

bool have_subscribers(RosConnection& connection, std::size_t count) {
  return soon([&] { return connection.publisher().subscribers() >= count; }, 30s);
}

/// A connection that has found its master, which it starts, and so many subscribers; ends well with the test.
class Connected : public RosConnection {
 public:
  explicit Connected(RosMaster& master, std::size_t subscribers = 0, const RosOptions& options = {})
      : RosConnection(options, sample_topics()) {
    master.start();
    start();
    EXPECT_TRUE(wait_for_master(30s) && have_subscribers(*this, subscribers));
  }
  ~Connected() { EXPECT_TRUE(stop()); }
};

TEST(RosConnection, PublishesEveryKindOfMessageAndLatchedTransforms) {
  in_own_process([] {
    RosMaster master;
    Listener<sensor_msgs::LaserScan> scans("/front/scan");
    Listener<sensor_msgs::MultiEchoLaserScan> echoes("/front/echoes");
    Listener<sensor_msgs::PointCloud2> clouds("/roof/points");
    Listener<sensor_msgs::NavSatFix> fixes("/roof/fix");
    Listener<sensor_msgs::TimeReference> references("/roof/time_reference");
    Listener<sensor_msgs::Imu> samples("/roof/imu");
    Listener<tf2_msgs::TFMessage> transforms("/tf_static");
    master.start();
    RosConnection connection({}, sample_topics());
    connection.sink().transforms({{"base_link", "front_laser", make_pose({1, 0, 0}, {0, 0, 0})}},
                                 Stamp{1'000'000'000});
    connection.start();
    ASSERT_TRUE(have_subscribers(connection, 6));
    const auto kept_for_a_slow_subscriber = [](const char* topic) {
      return ros::TopicManager::instance()->lookupPublication(topic)->getMaxQueue();
    };
    EXPECT_EQ(kept_for_a_slow_subscriber("/front/scan"), 100U);
    EXPECT_EQ(kept_for_a_slow_subscriber("/roof/points"), 10U);
    connection.sink().publish(test::front_scan, sample_scan(), Stamp{1});
    connection.sink().publish(test::front_echoes, sample_scan(), Stamp{1});
    auto cloud = sample_cloud(30000);
    const std::vector<std::uint8_t> sent(cloud.points_bytes.begin(), cloud.points_bytes.end());
    connection.sink().publish(test::roof_points, cloud, Stamp{1});
    connection.sink().publish(test::roof_fix, DeviceMessage(test::sample_fix()), Stamp{1});
    connection.sink().publish(test::roof_time, DeviceMessage(test::sample_time_reference()), Stamp{1});
    for (int i = 0; i < 20; ++i)
      connection.sink().publish(test::roof_imu, DeviceMessage(test::sample_imu()), Stamp{1});

    const auto scan = scans.take(1);
    ASSERT_EQ(scan.size(), 1U);
    const sensor_msgs::LaserScan expected = test::sample_message();
    EXPECT_EQ(scan[0].header.stamp, expected.header.stamp);
    EXPECT_EQ(scan[0].header.frame_id, "front_laser");
    EXPECT_EQ(scan[0].intensities, expected.intensities);
    EXPECT_EQ(echoes.take(1).size(), 1U);
    const auto got = clouds.take(1);
    ASSERT_EQ(got.size(), 1U);
    EXPECT_EQ(got[0].data, sent);
    const auto fix = fixes.take(1);
    ASSERT_EQ(fix.size(), 1U);
    EXPECT_EQ(fix[0].latitude, test::sample_fix().latitude_deg);
    const auto reference = references.take(1);
    ASSERT_EQ(reference.size(), 1U);
    EXPECT_EQ(reference[0].source, "gps_pps");
    const auto imu = samples.take(20);
    ASSERT_EQ(imu.size(), 20U) << "a burst is not dropped";
    EXPECT_EQ(imu[19].linear_acceleration.z, 9.8);
    const auto tf = transforms.take(1);
    ASSERT_EQ(tf.size(), 1U);
    EXPECT_EQ(tf[0].transforms.at(0).child_frame_id, "front_laser");
    EXPECT_TRUE(connection.stop());
  });
}

TEST(RosConnection, ReceivesWithoutAMasterAndPublishesSoonAfterItCame) {
  in_own_process([] {
    RosMaster master;
    RosConnection connection({}, sample_topics());
    connection.start();
    publish_for(connection, 300ms);
    EXPECT_FALSE(connection.publisher().ready());
    EXPECT_TRUE(soon([&] { return connection.publisher().without_ros() > 1; }));
    master.start();
    const test::Starved starved;
    const auto begin = SteadyClock::now();
    EXPECT_TRUE(connection.wait_for_master(30s));
    const std::chrono::duration<double> took = SteadyClock::now() - begin;
    EXPECT_LT(took, surely_not_hanging + starved.time());
    std::cout << "publishing " << took.count() << " s after the master answered\n";
    EXPECT_TRUE(connection.stop());
  });
}

TEST(RosConnection, RegistersAgainAtAMasterThatWasRestarted) {
  in_own_process([] {
    RosMaster master;
    Listener<sensor_msgs::LaserScan> early("/front/scan");
    Connected connection(master, 1);
    master.kill();
    publish_for(connection, 200ms);
    ASSERT_TRUE(connection.flush(30s));
    const std::size_t sent = connection.publisher().published();
    EXPECT_GT(sent, 1U);
    EXPECT_EQ(early.take(sent).size(), sent) << "a connection that exists must not suffer";
    master.start();
    MasterClient client({"127.0.0.1", master.port()}, "/test");
    EXPECT_TRUE(soon([&] { return client.topic_types()["/roof/points"] == "sensor_msgs/PointCloud2"; }));
    EXPECT_TRUE(soon([&] { return client.topic_types().count("/front/scan") == 1; }));
  });
}

TEST(RosConnection, IsNotDisturbedByAMasterThatHangs) {
  in_own_process([] {
    RosMaster master;
    Listener<sensor_msgs::LaserScan> listener("/front/scan");
    master.start();
    RosConnection connection({}, sample_topics());
    connection.start();
    ASSERT_TRUE(have_subscribers(connection, 1));
    master.pause();
    const test::Starved starved;
    auto longest = SteadyClock::duration(0);
    for (int i = 0; i < 100; ++i) {
      const auto begin = SteadyClock::now();
      connection.sink().publish(test::front_scan, sample_scan(), Stamp{1});
      longest = std::max(longest, SteadyClock::now() - begin);
      std::this_thread::sleep_for(10ms);
    }
    EXPECT_LT(longest, surely_not_hanging + starved.time());
    ASSERT_TRUE(connection.flush(30s));
    const std::size_t sent = connection.publisher().published();
    EXPECT_GT(sent, 50U);
    EXPECT_EQ(listener.take(sent).size(), sent);
    EXPECT_TRUE(soon([&] { return !connection.has_master(); }));
    const auto begin = SteadyClock::now();
    EXPECT_FALSE(connection.stop());
    EXPECT_LT(SteadyClock::now() - begin, surely_not_hanging + starved.time());
    master.resume();
  });
}

TEST(RosConnection, WantsACloudWhileSomebodySubscribesAndCountsThoseThatNobodyGets) {
  in_own_process([] {
    RosMaster master;
    auto listener = std::make_unique<Listener<sensor_msgs::PointCloud2>>("/roof/points");
    RosConnection connection({}, sample_topics());
    FrameSink& sink = connection.sink();
    EXPECT_FALSE(sink.wants(test::roof_points));
    sink.skip(test::roof_points, Stamp{1});
    EXPECT_EQ(connection.publisher().without_ros(), 1U);
    master.start();
    connection.start();
    EXPECT_TRUE(soon([&] { return sink.wants(test::roof_points); }));
    EXPECT_FALSE(sink.wants(test::front_scan));
    listener.reset();
    EXPECT_TRUE(soon([&] { return !sink.wants(test::roof_points); }));
    sink.skip(test::roof_points, Stamp{2});
    EXPECT_EQ(connection.publisher().published(), 1U);
    EXPECT_EQ(connection.publisher().figures("roof/points", Stamp{2}).frames, 2U);
    EXPECT_TRUE(connection.stop());
  });
}

TEST(RosConnection, LosesNothingInAReplayAsFastAsItGoes) {
  in_own_process([] {
    RosMaster master;
    Listener<sensor_msgs::PointCloud2> listener("/roof/points");
    Connected connection(master, 1, blocking());
    EXPECT_TRUE(connection.sink().wants(test::roof_points));
    constexpr std::size_t count = 200;
    for (std::size_t i = 0; i < count; ++i) {
      auto cloud = sample_cloud(20000);
      cloud.stamp.ns = static_cast<std::int64_t>(i) + 1;
      connection.sink().publish(test::roof_points, cloud, Stamp{1});
    }
    EXPECT_TRUE(connection.flush(20s));
    const auto got = listener.take(count, 20s);
    ASSERT_EQ(got.size(), count);
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(got[i].header.stamp.toNSec(), i + 1);
  });
}

TEST(RosConnection, ShowsDiagnosticsToRostopic) {
  in_own_process([] {
    RosMaster master;
    Connected connection(master);
    connection.sink().diagnostics(
        {{"front", "SN42", Health::warn, "no data for 2 s; check the cable", {{"IP Port", "6060"}}}},
        Stamp{1});
    std::string text;
    // The first messages only say that the node starts.
    for (int i = 0; i < 10 && text.find("SN42") == std::string::npos; ++i)
      text = test::output_of("/usr/bin/python3 /usr/bin/rostopic echo -n 1 /diagnostics", 20);
    EXPECT_THAT(text, testing::HasSubstr("name: \"lidard: front\""));
    EXPECT_THAT(text, testing::HasSubstr("hardware_id: \"SN42\""));
    EXPECT_THAT(text, testing::HasSubstr("no data for 2 s; check the cable"));
    EXPECT_THAT(text, testing::HasSubstr("name: \"lidard: ROS\""));
  });
}

TEST(RosConnection, SaysThatTheMasterIsAskedUntilItAnswers) {
  in_own_process([] {
    RosConnection connection({}, {});
    EXPECT_THAT(connection.diagnostics(Stamp{1}).at(0).message, test::Says(says::master_asked));
  });
}

TEST(RosConnection, CallsItemsOfAThreadThatHangsErrors) {
  in_own_process([] {
    RosMaster master;
    Listener<diagnostic_msgs::DiagnosticArray> listener("/diagnostics");
    RosOptions aging;
    aging.longest_report_age = 1s;
    Connected connection(master, 0, aging);
    for (int i = 0; i < 40; ++i) {
      connection.sink().diagnostics({{"front", "SN42", Health::ok, "fine", {}}}, Stamp{1});
      std::this_thread::sleep_for(100ms);
    }
    std::vector<std::string> texts;
    for (int i = 0; i < 100 && (texts.empty() || texts.back() == "fine"); ++i)
      for (const auto& message : listener.take(1, 200ms))
        if (message.status.front().hardware_id == "SN42") texts.push_back(message.status.front().message);
    EXPECT_GE(std::count(texts.begin(), texts.end(), "fine"), 3) << "once a second while it reports";
    EXPECT_THAT(texts.back(), test::Says(says::no_report));
  });
}

TEST(RosConnection, PublishesTheClockOfAReplay) {
  in_own_process([] {
    RosMaster master;
    Listener<rosgraph_msgs::Clock> listener("/clock");
    auto with_clock = blocking();
    with_clock.clock = true;
    Connected connection(master, 0, with_clock);
    std::vector<rosgraph_msgs::Clock> got;
    for (int i = 0; got.empty() && i < 100; ++i) {
      connection.publisher().publish_clock(Stamp{5'000'000'007});
      got = listener.take(1, 50ms);
    }
    ASSERT_FALSE(got.empty());
    EXPECT_EQ(got[0].clock, ros::Time(5, 7));
  });
}

TEST(RosConnection, FollowsNamespaceNodeNameAndRemappings) {
  in_own_process([] {
    RosMaster master;
    RosOptions remapped;
    remapped.remappings = {"__ns:=truck", "__name:=eyes", "front/scan:=bumper/scan"};
    Connected connection(master, 0, remapped);
    MasterClient client({"127.0.0.1", master.port()}, "/test");
    const auto types = client.topic_types();
    EXPECT_EQ(types.count("/truck/bumper/scan"), 1U);
    EXPECT_EQ(types.count("/truck/roof/points"), 1U);
    EXPECT_EQ(types.count("/truck/front/scan"), 0U);
    EXPECT_EQ(types.count("/tf_static"), 1U);
    EXPECT_EQ(ros::this_node::getName(), "/truck/eyes");
  });
}

TEST(RosConnection, ComesBackWhenSomebodyShutsItsNodeDown) {
  in_own_process([] {
    RosMaster master;
    Connected connection(master);
    for (int i = 1; i <= 2; ++i) {
      XmlRpc::XmlRpcValue arguments;
      arguments[0] = "/intruder";
      arguments[1] = "go away";
      const auto us = parse_server_uri(ros::XMLRPCManager::instance()->getServerURI());
      ASSERT_TRUE(us);
      std::string error;
      ASSERT_TRUE(xmlrpc_call(*us, "shutdown", arguments, 500ms, error)) << error;
      EXPECT_TRUE(soon([&] { return connection.foreign_stops() == static_cast<unsigned>(i); }));
      EXPECT_TRUE(soon([&] { return connection.publisher().ready() && ros::ok(); }));
      const auto before = connection.publisher().published();
      EXPECT_TRUE(soon([&] {
        connection.sink().publish(test::front_scan, sample_scan(), Stamp{1});
        return connection.publisher().published() > before;
      }));
    }
    MasterClient client({"127.0.0.1", master.port()}, "/test");
    EXPECT_EQ(client.topic_types().count("/front/scan"), 1U);
  });
}

TEST(RosConnection, SaysWhatIsWrongWithNamesAndAddresses) {
  const auto error_of = [](const RosOptions& given) {
    try {
      RosConnection connection(given, sample_topics());
    } catch (const RosError& problem) {
      return std::string(problem.what());
    }
    return std::string();
  };
  in_own_process([&] {
    RosOptions wrong;
    wrong.remappings = {"__master:=ftp://nowhere"};
    EXPECT_THAT(error_of(wrong), testing::HasSubstr("expected http://host:port"));
    wrong.remappings = {"no remapping"};
    EXPECT_THAT(error_of(wrong), testing::HasSubstr("expected from:=to"));
    wrong.remappings = {"__name:=a/b"};
    EXPECT_THAT(error_of(wrong), testing::HasSubstr("a/b"));
  });
}

}  // namespace
}  // namespace lidard
