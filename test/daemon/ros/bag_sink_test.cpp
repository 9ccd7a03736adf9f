// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/out/bag_sink.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <iterator>

#include "daemon/ros/messages/convert.h"
#include "daemon/ros/messages/device_messages.h"
#include "test/support/captures.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using test::sample_cloud;
using test::sample_scan;

class Bags : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("lidard-bag-" + std::string(info->name()) + "-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  static void write(const std::string& file, int frames = 3) {
    BagSink sink(file);
    sink.transforms({{"base_link", "front_laser", make_pose({1, 0, 0}, {0, 0, 0})}}, Stamp{1'000'000'000});
    for (int i = 0; i < frames; ++i) {
      const Stamp released{1'700'000'001'000'000'000 + i * 100'000'000L};
      sink.publish(test::front_scan, sample_scan(), released);
      sink.publish(test::front_echoes, sample_scan(), released);
      auto cloud = sample_cloud(1000);
      sink.publish(test::roof_points, cloud, released);
      sink.diagnostics({{"front", "SN1", Health::ok, "fine", {}}}, released);
    }
    sink.close();
    EXPECT_EQ(sink.messages(), static_cast<std::size_t>(1 + 4 * frames));
  }
  static std::string error_of_closing(BagSink& sink) {
    try {
      sink.close();
    } catch (const BagError& problem) {
      return problem.what();
    }
    return "";
  }
  template <typename Message>
  static std::vector<boost::shared_ptr<Message>> read(rosbag::Bag& bag, const std::string& topic) {
    std::vector<boost::shared_ptr<Message>> all;
    rosbag::View view(bag, rosbag::TopicQuery(topic));
    for (const auto& m : view) all.push_back(m.template instantiate<Message>());
    return all;
  }

  std::filesystem::path folder_;
};

TEST_F(Bags, HoldTheVeryMessagesAtTheTimeOfTheirRelease) {
  write(path("a.bag"));
  rosbag::Bag bag(path("a.bag"));
  rosbag::View view(bag, rosbag::TopicQuery("/front/scan"));
  ASSERT_EQ(view.size(), 3U);
  EXPECT_EQ(view.begin()->getTime(), ros::Time(1'700'000'001, 0));
  sensor_msgs::LaserScan expected;
  test::to_message(sample_scan(), expected);
  for (const auto& scan : read<sensor_msgs::LaserScan>(bag, "/front/scan")) {
    ASSERT_NE(scan, nullptr);
    EXPECT_EQ(scan->header.stamp, expected.header.stamp);
    EXPECT_EQ(scan->header.frame_id, expected.header.frame_id);
    EXPECT_EQ(scan->angle_max, expected.angle_max);
    EXPECT_EQ(scan->ranges[0], expected.ranges[0]);
    EXPECT_EQ(scan->intensities, expected.intensities);
  }
  const auto echoes = read<sensor_msgs::MultiEchoLaserScan>(bag, "/front/echoes");
  ASSERT_EQ(echoes.size(), 3U);
  EXPECT_EQ(echoes[0]->ranges.size(), 5U);
}

TEST_F(Bags, HoldCloudsByteForByte) {
  auto cloud = sample_cloud(1000);
  const std::vector<std::uint8_t> sent(cloud.points_bytes.begin(), cloud.points_bytes.end());
  {
    BagSink sink(path("a.bag"));
    sink.publish(test::roof_points, cloud, Stamp{1'700'000'001'000'000'000});
    sink.close();
  }
  rosbag::Bag bag(path("a.bag"));
  const auto clouds = read<sensor_msgs::PointCloud2>(bag, "/roof/points");
  ASSERT_EQ(clouds.size(), 1U);
  EXPECT_EQ(clouds[0]->data, sent);
  EXPECT_EQ(clouds[0]->header.frame_id, "velodyne");
}

TEST_F(Bags, HoldFixesTimeReferencesAndImuSamples) {
  {
    BagSink sink(path("a.bag"));
    const Stamp released{1'700'000'001'000'000'000};
    sink.publish(test::roof_fix, DeviceMessage(test::sample_fix()), released);
    sink.publish(test::roof_time, DeviceMessage(test::sample_time_reference()), released);
    sink.publish(test::roof_imu, DeviceMessage(test::sample_imu()), released);
    sink.close();
    EXPECT_EQ(sink.messages(), 3U);
  }
  rosbag::Bag bag(path("a.bag"));
  const auto fixes = read<sensor_msgs::NavSatFix>(bag, "/roof/fix");
  ASSERT_EQ(fixes.size(), 1U);
  ASSERT_NE(fixes[0], nullptr);
  EXPECT_EQ(fixes[0]->longitude, test::sample_fix().longitude_deg);
  const auto references = read<sensor_msgs::TimeReference>(bag, "/roof/time_reference");
  ASSERT_EQ(references.size(), 1U);
  EXPECT_EQ(references[0]->time_ref, ros::Time(1'700'000'000, 342'001'000));
  const auto samples = read<sensor_msgs::Imu>(bag, "/roof/imu");
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0]->angular_velocity.z, 0.3);
  rosbag::View view(bag, rosbag::TopicQuery("/roof/imu"));
  EXPECT_EQ(view.begin()->getTime(), ros::Time(1'700'000'001, 0));
}

TEST_F(Bags, AreTheSameByteForByteForTheSameInput) {
  write(path("a.bag"), 40);
  write(path("b.bag"), 40);
  EXPECT_GT(test::content(path("a.bag")).size(), 800'000U);  // more than one chunk
  EXPECT_TRUE(test::content(path("a.bag")) == test::content(path("b.bag")));
  write(path("b.bag"), 41);
  EXPECT_FALSE(test::content(path("a.bag")) == test::content(path("b.bag")));
}

TEST_F(Bags, MarkFixedTransformsAsLatched) {
  write(path("a.bag"));
  rosbag::Bag bag(path("a.bag"));
  rosbag::View view(bag, rosbag::TopicQuery("/tf_static"));
  const auto connections = view.getConnections();
  ASSERT_EQ(connections.size(), 1U);
  EXPECT_EQ(connections[0]->header->at("latching"), "1");
  EXPECT_EQ(connections[0]->datatype, "tf2_msgs/TFMessage");
  const auto transforms = read<tf2_msgs::TFMessage>(bag, "/tf_static");
  EXPECT_EQ(transforms.at(0)->transforms.at(0).child_frame_id, "front_laser");
}

TEST_F(Bags, PutRelativeTopicsBelowTheRoot) {
  {
    BagSink sink(path("a.bag"));
    sink.publish(test::front_scan, sample_scan(), Stamp{});
    sink.publish({"/absolute", TopicKind::scan}, sample_scan(), Stamp{});
    sink.close();
  }
  rosbag::Bag bag(path("a.bag"));
  EXPECT_EQ(read<sensor_msgs::LaserScan>(bag, "/front/scan").size(), 1U);
  EXPECT_EQ(read<sensor_msgs::LaserScan>(bag, "/absolute").size(), 1U);
}

TEST_F(Bags, SayWhyTheyCannotBeCreated) {
  try {
    BagSink sink(path("missing/a.bag"));
    FAIL() << "created in a folder that does not exist";
  } catch (const BagError& problem) {
    EXPECT_THAT(problem.what(),
                testing::HasSubstr("missing/a.bag': No such file or directory; choose a writable"));
  }
  EXPECT_THROW(BagSink(folder_.string()), BagError);
}

TEST_F(Bags, SayThatTheDiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  try {
    BagSink sink("/dev/full");
    FAIL() << "wrote a bag to a full disk";
  } catch (const BagError& problem) {
    EXPECT_THAT(problem.what(), testing::HasSubstr("No space left on device"));
  }
}

TEST_F(Bags, StopAtTheFirstErrorAndTellWhenClosed) {
  struct rlimit before {};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto ignored = signal(SIGXFSZ, SIG_IGN);
  const struct rlimit small = {1'000'000, before.rlim_max};
  {
    BagSink sink(path("a.bag"));
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    for (int i = 0; i < 100; ++i) {
      auto cloud = sample_cloud(1000);
      sink.publish(test::roof_points, cloud, Stamp{1'700'000'001'000'000'000});
    }
    EXPECT_LT(sink.messages(), 100U);
    EXPECT_THAT(sink.error(), testing::HasSubstr("File too large"));
    EXPECT_EQ(error_of_closing(sink), sink.error());
  }
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, ignored);
}

}  // namespace
}  // namespace lidard
