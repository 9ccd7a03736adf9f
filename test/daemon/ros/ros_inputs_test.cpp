// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <dynamic_reconfigure/Reconfigure.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <std_msgs/String.h>

#include <chrono>
#include <thread>

#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/connection.h"
#include "daemon/ros/in/inputs.h"
#include "daemon/ros/in/output_items.h"
#include "daemon/ros/in/tf_poses.h"
#include "daemon/ros/messages/convert.h"
#include "test/support/ros_master.h"
#include "test/support/ros_posted.h"
#include "test/support/ros_samples.h"
#include "test/support/says.h"
#include "test/support/starved.h"

namespace lidard {
namespace {

using namespace std::chrono_literals;
using test::Child;
using test::in_own_process;
using test::RosMaster;

/// A node in a process of its own that publishes one message again and again.
template <typename Message>
Child talker(const std::string& topic, const Message& message) {
  return Child([=] {
    ros::init(ros::M_string(), "talker", ros::init_options::AnonymousName | ros::init_options::NoRosout);
    ros::NodeHandle node;
    auto publisher = node.advertise<Message>(topic, 10);
    for (ros::WallRate rate(50); ros::ok(); rate.sleep()) publisher.publish(message);
  });
}

/// What the pipeline would get.
struct Seen final : MessageReceiver {
  void set_message_clock(Span) override {}
  std::vector<PlanarScan> scans;
  std::vector<Cloud> clouds;
  std::string sensor;

  void scan_message(const std::string& name, PlanarScan& scan, Stamp) override {
    sensor = name;
    scans.push_back(scan);
  }
  void cloud_message(const std::string& name, Cloud& cloud, Stamp) override {
    sensor = name;
    clouds.push_back(cloud);
  }
  void packet_message(const std::string&, const Packet&, Stamp) override {}
  void pose_message(Stamp, const Pose&, const std::string&, Stamp) override {}
  void turn_message(Stamp, const Eigen::Vector3d&, const std::string&, Stamp) override {}
  void speed_message(double, Stamp) override {}
  int changes = 0;
  std::string set_scan(const MakerId&, const OutputScanConfig&) override { return ++changes, ""; }
  std::string set_sensor(const SensorConfig&) override { return {}; }
};

struct Posted : test::Posted {
  bool run_until(const std::function<bool()>& done, std::chrono::milliseconds limit = 120s) {
    return test::Posted::run_until(seen, Stamp{}, done, limit);
  }
  Seen seen;
};

/// A master that has a share of a busy processor may take longer to answer than the connection waits for it.
void expect_to_stop(RosConnection& connection) {
  const test::Starved starved;
  const bool ended = connection.stop();
  EXPECT_TRUE(ended || starved.time() > 100ms);
}

/// A connection with inputs from the start to the end of a test.
struct Inputs : Posted {
  explicit Inputs(std::initializer_list<TopicSource> sources) : Inputs(sources, post()) {}
  Inputs(std::vector<TopicSource> sources, RosPost to)
      : part(std::make_shared<RosInputs>(sources, std::move(to))) {
    connection.add(part);
    connection.start();
  }
  ~Inputs() { expect_to_stop(connection); }

  RosConnection connection{{}, {}};
  const std::shared_ptr<RosInputs> part;
};

TEST(RosInputs, FindTheTypeOfATopicAndConvertScans) {
  in_own_process([] {
    RosMaster master;
    const Child scans = talker("/rear/scan", test::sample_message());
    master.start();
    Inputs inputs({{"rear", "/rear/scan"}});
    EXPECT_TRUE(inputs.run_until([&] { return inputs.seen.scans.size() >= 3; }));
    ASSERT_FALSE(inputs.seen.scans.empty());
    EXPECT_EQ(inputs.seen.sensor, "rear");
    EXPECT_EQ(inputs.seen.scans[0].stamp, test::sample_scan().stamp);
    EXPECT_EQ(inputs.seen.scans[0].statuses, test::sample_scan().statuses);
    EXPECT_EQ(inputs.part->report().at(0).type, "sensor_msgs/LaserScan");
    EXPECT_EQ(inputs.part->report().at(0).rejected, 0U);
    EXPECT_THAT(inputs.part->diagnostics().at(0).message, test::Says(says::receiving));
  });
}

TEST(RosInputs, ConvertCloudsOfAPublisherThatComesLate) {
  in_own_process([] {
    RosMaster master;
    auto cloud = test::sample_cloud(500);
    const auto sent = cloud.points_bytes;
    const sensor_msgs::PointCloud2 message = test::message_of(cloud);
    const Child clouds = talker("/points", message);  // waits for the master, as we do
    Inputs inputs({{"roof", "points"}});
    EXPECT_FALSE(inputs.run_until([&] { return !inputs.seen.clouds.empty(); }, 200ms));
    EXPECT_THAT(inputs.part->diagnostics().at(0).message, test::Says(says::nobody_publishes));
    master.start();
    EXPECT_TRUE(inputs.run_until([&] { return !inputs.seen.clouds.empty(); }));
    ASSERT_FALSE(inputs.seen.clouds.empty());
    EXPECT_EQ(inputs.seen.clouds[0].points_bytes, sent);
  });
}

TEST(RosInputs, CountAndExplainMessagesTheyCannotUse) {
  in_own_process([] {
    RosMaster master;
    auto broken = test::sample_message();
    broken.ranges.resize(2);
    const Child scans = talker("/broken", broken);
    const Child strings = talker("/words", std_msgs::String());
    master.start();
    Inputs inputs({{"a", "/broken"}, {"b", "/words"}});
    EXPECT_TRUE(inputs.run_until([&] { return inputs.part->report()[0].rejected > 2; }));
    EXPECT_EQ(inputs.part->report()[0].last_reason,
              "number of ranges does not fit angle_min, angle_max and angle_increment");
    EXPECT_TRUE(inputs.run_until([&] { return inputs.part->report()[1].type == "std_msgs/String"; }));
    EXPECT_EQ(inputs.part->report()[1].messages, 0U);
    EXPECT_TRUE(inputs.seen.scans.empty());
    const auto items = inputs.part->diagnostics();
    EXPECT_THAT(items.at(0).message, test::Says(says::unusable_messages));
    EXPECT_THAT(items.at(1).message, test::Says(says::wrong_type));
  });
}

TEST(RosInputs, UseScansWithOddIntensitiesOrWithoutRangesAndCountWhatTheyLeaveOut) {
  in_own_process([] {
    RosMaster master;
    auto odd = test::sample_message();
    odd.intensities.resize(2);
    auto empty = test::sample_message();
    empty.ranges.clear();
    empty.intensities.clear();
    const Child odd_scans = talker("/odd", odd);
    const Child empty_scans = talker("/empty", empty);
    master.start();
    Inputs inputs({{"a", "/odd"}, {"b", "/empty"}});
    EXPECT_TRUE(inputs.run_until([&] {
      const auto report = inputs.part->report();
      return report[0].intensities_ignored > 2 && report[1].messages > 2 && inputs.seen.scans.size() > 6;
    }));
    for (const auto& report : inputs.part->report()) EXPECT_EQ(report.rejected, 0U) << report.last_reason;
    EXPECT_EQ(inputs.part->report()[1].intensities_ignored, 0U);
    for (const PlanarScan& scan : inputs.seen.scans) EXPECT_TRUE(scan.intensities.empty());
    using ::testing::Pair;
    EXPECT_THAT(inputs.part->diagnostics().at(0).values,
                ::testing::Contains(Pair("Intensities ignored", ::testing::Ne("0"))));
  });
}

TEST(RosInputs, DropAndCountWhatASlowSensorThreadDoesNotTake) {
  in_own_process([] {
    RosMaster master;
    const Child scans = talker("/scan", test::sample_message());
    master.start();
    std::vector<RosTask> never_run;
    std::mutex mutex;
    Inputs inputs({{"a", "/scan"}}, [&](const std::string&, RosTask task) {
      const std::lock_guard lock(mutex);
      never_run.push_back(std::move(task));
    });
    EXPECT_TRUE(inputs.run_until([&] { return inputs.part->report()[0].dropped > 3; }));
    EXPECT_TRUE(inputs.connection.stop());
    EXPECT_EQ(never_run.size(), 4U);
  });
}

TEST(RosInputs, HearPublishersAgainAfterTheMasterWasRestarted) {
  in_own_process([] {
    RosMaster master;
    auto before = talker("/scan", test::sample_message());
    master.start();
    Inputs inputs({{"a", "/scan"}});
    ASSERT_TRUE(inputs.run_until([&] { return !inputs.seen.scans.empty(); }));
    before.kill();
    master.kill();
    master.start();
    std::this_thread::sleep_for(600ms);
    const auto count = inputs.seen.scans.size();
    const Child after(std::vector<std::string>{
        "/usr/bin/python3", "/usr/bin/rostopic", "pub", "-r", "20", "/scan", "sensor_msgs/LaserScan",
        "{angle_min: 0.0, angle_max: 0.1, angle_increment: 0.1, range_max: "
        "10.0, ranges: [1.0, 2.0]}"});
    EXPECT_TRUE(inputs.run_until([&] { return inputs.seen.scans.size() > count + 10; }));
  });
}

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child, double x) {
  geometry_msgs::TransformStamped made;
  made.header.frame_id = parent;
  made.child_frame_id = child;
  made.header.stamp = ros::Time(100, 0);
  made.transform.translation.x = x;
  made.transform.rotation.w = 1;
  return made;
}

TEST(RosReconfigure, ChangesNothingAnyMoreOnceAReloadReplacesIt) {
  in_own_process([] {
    RosMaster master;
    master.start();
    Posted posted;
    const Config config =
        parse_config("sensors: {a: {topic: /a}}\nmerged_scans: {m: {laserscan_topics: a}}\n", "f");
    const auto part =
        make_ros_reconfigure(changeable_outputs(config, ReconfigureNames::entries), posted.post());
    RosConnection connection({}, {});
    connection.add(part);
    connection.start();
    dynamic_reconfigure::Reconfigure wanted;
    const std::string name = connection.node() + "/m/set_parameters";
    ASSERT_TRUE(posted.run_until([&] { return ros::isStarted() && ros::service::call(name, wanted); }));
    ASSERT_TRUE(posted.run_until([&] { return posted.seen.changes > 0; }));
    const int before = posted.seen.changes;
    ASSERT_TRUE(ros::service::call(name, wanted));
    part->retire();
    EXPECT_FALSE(posted.run_until([&] { return posted.seen.changes > before; }, 50ms))
        << "asked before the reload";
    EXPECT_FALSE(ros::service::call(name, wanted));
    expect_to_stop(connection);
  });
}

/// Poses of tf as a talker publishes it.
struct Tf {
  Tf() { connection.add(poses); }
  ~Tf() { expect_to_stop(connection); }
  bool knows(const std::string& parent, const std::string& child, Stamp stamp) {
    return poses->lookup(parent, child, stamp, pose, why);
  }
  bool will_know(const std::string& parent, const std::string& child, Stamp stamp) {
    return Posted().run_until([&] { return knows(parent, child, stamp); });
  }
  std::shared_ptr<TfPoses> poses = std::make_shared<TfPoses>();
  RosConnection connection{{}, {}};
  Pose pose;
  std::string why;
};

TEST(TfPoses, FollowAChainOfFramesAndSayWhyAPoseIsUnknown) {
  in_own_process([] {
    RosMaster master;
    tf2_msgs::TFMessage message;
    message.transforms = {transform("base_link", "mast", 1), transform("mast", "laser", 2)};
    const Child tf = talker("/tf_static", message);
    master.start();
    Tf poses;
    EXPECT_FALSE(poses.knows("base_link", "laser", Stamp{}));
    EXPECT_THAT(poses.why, test::Says(says::tf_absent));
    poses.connection.start();
    EXPECT_TRUE(poses.will_know("/base_link", "laser", Stamp{5})) << poses.why;
    EXPECT_EQ(poses.pose.translation().x(), 3);
    EXPECT_TRUE(is_rigid(poses.pose));
    EXPECT_FALSE(poses.knows("base_link", "nowhere", Stamp{}));
    EXPECT_THAT(poses.why, testing::AllOf(testing::HasSubstr("nowhere"), test::Says(says::tf_reason)));
    EXPECT_FALSE(poses.knows("", "laser", Stamp{}));
    EXPECT_THAT(poses.why, test::Says(says::tf_unnamed));
    EXPECT_TRUE(poses.knows("laser", "laser", Stamp{}));
  });
}

TEST(TfPoses, TakeAMovingFrameAtTheStampAskedFor) {
  in_own_process([] {
    RosMaster master;
    tf2_msgs::TFMessage message;
    message.transforms = {transform("odom", "base_link", 1), transform("odom", "base_link", 3)};
    message.transforms[1].header.stamp = ros::Time(102, 0);
    const Child tf = talker("/tf", message);
    master.start();
    Tf poses;
    poses.connection.start();
    EXPECT_TRUE(poses.will_know("odom", "base_link", Stamp{101'000'000'000})) << poses.why;
    EXPECT_EQ(poses.pose.translation().x(), 2);
    EXPECT_FALSE(poses.knows("odom", "base_link", Stamp{103'000'000'000}));
    EXPECT_THAT(poses.why, testing::HasSubstr("extrapolation"));
  });
}

TEST(NoTransforms, SaysThatRosIsNeeded) {
  NoTransforms poses;
  Pose pose;
  std::string why;
  EXPECT_FALSE(poses.lookup("base_link", "laser", Stamp{}, pose, why));
  EXPECT_EQ(why, "the pose of laser in base_link would come from tf, which needs ROS; configure it");
}

}  // namespace
}  // namespace lidard
