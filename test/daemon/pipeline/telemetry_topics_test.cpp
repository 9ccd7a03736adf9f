// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/config/config.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/messages/device_messages.h"
#include "drivers/registry/registry.h"
#include "test/support/recording_sink.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using testing::ElementsAre;

/// Tells a fix, a time reference and two samples with every packet.
class TellingDriver final : public Driver {
 public:
  explicit TellingDriver(DriverConfig config) : config_(std::move(config)) {}
  Verdict receive(const Packet& /*packet*/, FrameReceiver& out) override {
    out.message(test::sample_fix());
    out.message(test::sample_time_reference());
    out.message(test::sample_imu());
    out.message(test::sample_imu());
    if (!config_.model->sends<DeviceState>()) return {};
    out.message(DeviceState{"outputs", "laser", Stamp{5}, {{"output_1", 1}}});
    PlanarScan scan = test::sample_scan();
    out.extra_scan("intrusion", scan);
    out.scan(scan);
    return {};
  }
  void restart() override {}
  const Counters& counters() const override { return counters_; }
  const DeviceInfo& info() const override { return info_; }

 private:
  DriverConfig config_;
  Counters counters_;
  DeviceInfo info_;
};

Model telling_model(std::uint16_t telemetry_port, bool has_imu) {
  Model model = *find_model("velodyne_vlp16");
  model.telemetry_port = telemetry_port;
  model.messages.clear();
  if (telemetry_port != 0) model.messages = {message_topic<GnssFix>(), message_topic<TimeReference>()};
  if (has_imu) model.messages.push_back(message_topic<ImuSample>());
  model.make = [](const DriverConfig& config) -> std::unique_ptr<Driver> {
    return std::make_unique<TellingDriver>(config);
  };
  return model;
}

Config config_with(const Model& model) {
  Config config;
  SensorConfig sensor;
  sensor.name = "roof";
  sensor.model = sensor.driver.model = &model;
  sensor.ip_port = 2368;
  sensor.telemetry_port = model.telemetry_port;
  config.sensors.push_back(sensor);
  return config;
}

std::vector<std::string> names(const Config& config) {
  std::vector<std::string> all;
  for (const auto& topic : output_topics(config)) all.push_back(topic.name);
  return all;
}

TEST(TelemetryTopics, AreThoseTheModelCanHave) {
  const Model plain = telling_model(0, false);
  EXPECT_THAT(names(config_with(plain)), ElementsAre("roof/points"));
  const Model gnss = telling_model(8308, false);
  EXPECT_THAT(names(config_with(gnss)), ElementsAre("roof/points", "roof/fix", "roof/time_reference"));
  const Model both = telling_model(8308, true);
  EXPECT_THAT(names(config_with(both)),
              ElementsAre("roof/points", "roof/fix", "roof/time_reference", "roof/imu"));
}

TEST(TelemetryTopics, AreTakenForOtherOutputs) {
  const auto merged_into = [](const std::string& topic) {
    return parse_config(
        "sensors: {roof: {model: velodyne_vlp16}, front: {model: sick_microscan3}}\n"
        "merged_scans: {m: {laserscan_topics: front, scan_destination_topic: " +
            topic + "}}",
        "f");
  };
  EXPECT_NO_THROW(merged_into("roof/other"));
  EXPECT_NO_THROW(merged_into("front/fix")) << "a scanner without telemetry";
  for (const char* topic : {"roof/fix", "/roof/time_reference"})
    EXPECT_THROW(merged_into(topic), ConfigError) << topic;
}

TEST(TelemetryTopics, CarryWhatTheDriverTellsAtTheTimeOfItsPacket) {
  const Model model = telling_model(8308, true);
  const Config config = config_with(model);
  NoTransforms poses;
  test::RecordingSink sink;
  Pipeline pipeline(config, poses, sink);
  Packet packet;
  packet.arrival = Stamp{1'700'000'002'000'000'000};
  packet.to.port = 8308;
  pipeline.packet(packet);
  EXPECT_THAT(sink.topics, ElementsAre("roof/fix", "roof/time_reference", "roof/imu", "roof/imu"));
  EXPECT_EQ(sink.released["roof/fix"].at(0), packet.arrival);
  EXPECT_EQ(sink.of<GnssFix>("roof/fix").at(0).latitude_deg, test::sample_fix().latitude_deg);
}

TEST(TelemetryTopics, CarryStatesEchoesAndFurtherScans) {
  Model model = telling_model(0, false);
  model.kind = FrameKind::scan;
  model.traits.add(Trait::echoes);
  model.messages = {message_topic<DeviceState>("outputs")};
  model.extra_scans = {"intrusion"};
  Config config = config_with(model);
  EXPECT_THAT(names(config), ElementsAre("roof/scan", "roof/outputs", "roof/intrusion"));
  config.sensors.front().driver.publish_multiecho = true;
  EXPECT_THAT(names(config), ElementsAre("roof/scan", "roof/echoes", "roof/outputs", "roof/intrusion"));
  NoTransforms poses;
  test::RecordingSink sink;
  Pipeline pipeline(config, poses, sink);
  Packet packet;
  packet.to.port = 2368;
  pipeline.packet(packet);
  EXPECT_THAT(sink.topics,
              testing::IsSupersetOf({"roof/outputs", "roof/intrusion", "roof/scan", "roof/echoes"}));
}

TEST(TelemetryTopics, CarryNoStatesThatNobodyAskedFor) {
  Model model = telling_model(0, false);
  model.kind = FrameKind::scan;
  model.traits.add(Trait::states_on_request);
  model.messages = {message_topic<DeviceState>("outputs")};
  model.extra_scans = {"intrusion"};
  for (const bool wanted : {false, true}) {
    Config config = config_with(model);
    config.sensors.front().driver.requests.device_states = wanted;
    NoTransforms poses;
    test::RecordingSink sink;
    Pipeline pipeline(config, poses, sink);
    Packet packet;
    packet.to.port = 2368;
    pipeline.packet(packet);
    EXPECT_THAT(sink.topics, testing::Contains("roof/scan"));
    EXPECT_THAT(sink.topics, testing::Contains("roof/outputs").Times(wanted ? 1 : 0));
    EXPECT_THAT(names(config), testing::Contains("roof/outputs").Times(wanted ? 1 : 0));
    EXPECT_THAT(sink.topics, testing::Contains("roof/intrusion").Times(wanted ? 1 : 0));
    EXPECT_THAT(names(config), testing::Contains("roof/intrusion").Times(wanted ? 1 : 0));
  }
}

TEST(TelemetryTopics, HoldAStateAsDiagnosticStatus) {
  diagnostic_msgs::DiagnosticArray message;
  test::to_message(DeviceState{"encoder", "/laser", Stamp{1'500'000'000}, {{"ticks", 42}, {"speed", 0.25}}},
                   message);
  EXPECT_EQ(message.header.stamp, ros::Time(1, 500'000'000));
  EXPECT_EQ(message.header.frame_id, "laser");
  ASSERT_EQ(message.status.size(), 1U);
  EXPECT_EQ(message.status[0].name, "encoder");
  ASSERT_EQ(message.status[0].values.size(), 2U);
  EXPECT_EQ(message.status[0].values[0].key, "ticks");
  EXPECT_EQ(message.status[0].values[0].value, "42");
  EXPECT_EQ(message.status[0].values[1].value, "0.25");
}

}  // namespace
}  // namespace lidard
