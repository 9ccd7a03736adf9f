// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What a CoLa device tells beside its distances, and what becomes of its planes.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "drivers/registry/registry.h"
#include "drivers/sick/cola/cola_models.h"
#include "test/drivers/sick/cola/cola_bench.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/units.h"

namespace lidard::test {
namespace {

using sim::Cola;

TEST(ColaDriver, TheDeviceTellsItsStatusSerialAndName) {
  ColaBench bench;
  bench.sample.name = "front left";
  bench.sample.status[1] = 1;
  bench.send_next();
  EXPECT_EQ(bench.driver->info().serial, "12345678");
  EXPECT_EQ(bench.detail("Device name"), "front left");
  EXPECT_EQ(bench.detail("Dialect"), "CoLa B");
  EXPECT_TRUE(bench.has_warning("status 0 1"));
  bench.sample.status[1] = 0;
  bench.dialect = Cola::text;
  bench.send_next();
  EXPECT_FALSE(bench.has_warning("status"));
  EXPECT_EQ(bench.detail("Dialect"), "CoLa A");
  bench.sample.serial = 99;
  bench.send_next();
  EXPECT_TRUE(bench.has_warning("scanner 12345678 was replaced by scanner 99"));
}

TEST(ColaDriver, StatesGoOutOnTheirTopics) {
  ColaBench bench;
  bench.sample.encoders = {{1000, 7}};
  bench.send_next();
  ASSERT_EQ(bench.states.size(), 1U);
  EXPECT_EQ(bench.states[0].topic, "encoder");
  EXPECT_EQ(bench.states[0].stamp, bench.scans[0].stamp);
  EXPECT_EQ(bench.states[0].values.at(0).name, "position_1");
  EXPECT_EQ(bench.states[0].values.at(0).value, 1000);
  EXPECT_EQ(bench.states[0].values.at(1).value, 7);
  sim::ColaWords out(Cola::binary, "sSN LIDoutputstate");
  out.number(0, 2).number(bench.sample.start_us, 4).number(1, 1).number(3, 4).number(0, 2);
  bench.send(out.bytes());
  ASSERT_EQ(bench.states.size(), 2U);
  EXPECT_EQ(bench.states[1].topic, "lidoutputstate");
  EXPECT_EQ(bench.states[1].values.at(1).name, "output_1_count");
  EXPECT_EQ(bench.states[1].values.at(1).value, 3);
  EXPECT_NEAR(seconds(bench.now - bench.states[1].stamp), 0.003, 1e-6) << "the device's own time";
  const Model& model = *find_model("sick_lms1xx");
  for (const DeviceState& state : bench.states) {
    EXPECT_THAT(model.messages, ::testing::Contains(::testing::Field(&MessageTopic::name, state.topic)));
  }
}

// The order is that of the telegrams of an MRS1104 (mrs1000_capture_test.cpp).
TEST(ColaDriver, AnInertialUnitIsReadUnlessANumberIsNone) {
  ColaBench bench("sick_mrs1000");
  const auto telegram = [&](float last_of_rates, std::uint32_t time_us) {
    sim::ColaWords words(Cola::binary, "sSN InertialMeasurementUnit");
    for (const float value : {0.5F, -0.25F, 9.75F, 0.01F, -0.02F, last_of_rates}) words.real(value);
    words.number(0, 4).number(0, 4).number(0, 4);
    for (const float value : {0.8F, 0.F, 0.F, 0.6F}) words.real(value);
    return words.number(0, 4).number(time_us, 4).bytes();
  };
  bench.send_next();  // a scan, of another connection
  EXPECT_EQ(bench.send(telegram(0.03F, 20'000), 0, true), Reject::none);
  EXPECT_EQ(bench.imus.at(0).stamp, bench.now) << "before its first scan the device's time is not known";
  EXPECT_EQ(bench.send(telegram(std::numeric_limits<float>::quiet_NaN(), 1'010'000)), Reject::field);
  ASSERT_EQ(bench.imus.size(), 1U);
  EXPECT_NEAR((bench.imus[0].linear_acceleration - Eigen::Vector3d(0.5, -0.25, 9.75)).norm(), 0, 1e-6);
  EXPECT_NEAR((bench.imus[0].angular_velocity - Eigen::Vector3d(0.01, -0.02, 0.03)).norm(), 0, 1e-6);
  ASSERT_TRUE(bench.imus[0].orientation);
  EXPECT_NEAR(bench.imus[0].orientation->angularDistance(Eigen::Quaterniond(0.8, 0, 0, 0.6)), 0, 1e-6);
}

TEST(ColaDriver, APlaneMakesARingAndFourPlanesACloud) {
  DriverConfig config;
  config.keep_origins = true;
  ColaBench bench("sick_mrs1000", config);
  bench.sample.measurement_frequency = 180;
  bench.sample.channels = {{"DIST1", 1, 0, 0, 900000 / 65, true, {1000, 0, 2}},
                           {"DIST2", 1, 0, 0, 900000 / 65, true, {3000, 0, 0}}};
  for (const int layer : {-500, 0, -250, 250, -500, 0, -250, 250, -500}) {
    bench.sample.layer = static_cast<std::int16_t>(layer);
    bench.send_next();
  }
  ASSERT_EQ(bench.clouds.size(), 1U) << "the first three planes are a part, the last two are begun";
  EXPECT_EQ(bench.counters().partial_frames, 1U);
  const Cloud& cloud = bench.clouds[0];
  EXPECT_TRUE(cloud.complete);
  EXPECT_EQ(cloud.rings, 4);
  ASSERT_EQ(cloud.size(), 8U);
  const CloudPoint first = cloud.points()[0];
  EXPECT_EQ(first.ring, 0) << "250 is 2.5 deg downwards";
  EXPECT_NEAR(first.z, -std::sin(2.5 * pi_d / 180), 1e-6);
  EXPECT_NEAR(first.x, 0, 1e-6);
  EXPECT_NEAR(first.y, -std::cos(2.5 * pi_d / 180), 1e-6);
  EXPECT_NEAR(cloud.points()[1].y, -3 * std::cos(2.5 * pi_d / 180), 1e-6);
  EXPECT_EQ(cloud.points()[2].ring, 3);
  EXPECT_NEAR(cloud.points()[2].time, 0.02, 1e-6);
  ASSERT_EQ(cloud.columns.size(), 16U) << "three beams of each plane, and a second echo";
  EXPECT_EQ(cloud.columns[1].echo, 1);
  EXPECT_EQ(cloud.columns[2].echo, 0);
  bench.sample.layer = 7;
  EXPECT_EQ(bench.send_next(), Reject::model);
  EXPECT_TRUE(bench.has_warning("a plane at 7"));
}

TEST(ColaDriver, ACloudHoldsThePlanesOfOneTurn) {
  for (const bool is_new_connection : {true, false}) {
    ColaBench bench("sick_mrs1000");
    const auto send = [&](std::initializer_list<int> layers) {
      for (const int layer : layers) {
        bench.sample.layer = static_cast<std::int16_t>(layer);
        bench.send_next();
      }
    };
    send({250, -500, 0, -250, 250, -500});
    ASSERT_EQ(bench.clouds.size(), 1U);
    if (is_new_connection) {
      bench.now = bench.now + std::chrono::seconds(60);
      bench.sample.layer = 0;
      bench.sample.start_us += 60'000'000;
      bench.send(bench.sample.bytes(Cola::binary), 0, true);
    } else {  // a turn is lost
      bench.now = bench.now + std::chrono::milliseconds(80);
      bench.sample.start_us += 80'000;
      send({0});
    }
    send({-250});
    EXPECT_EQ(bench.clouds.size(), 1U) << "planes of two turns are no cloud";
    EXPECT_EQ(bench.counters().partial_frames, 1U);
    send({250, -500, 0, -250});
    EXPECT_EQ(bench.clouds.size(), 2U);
    EXPECT_EQ(bench.counters().partial_frames, 2U);
  }
}

TEST(ColaDriver, ThePlanesOfAnMrs1000AreCorrectedByTheAnglesThatAreSent) {
  ColaBench bench("sick_mrs1000");
  bench.sample.measurement_frequency = 180;
  const sim::SickChannel distances{"DIST1", 1, 0, 0, 900000 / 65, true, {1000, 1000, 1000}};
  const sim::SickChannel angles{
      "ANGL1", 1, -32768, 0, 900000 / 65, true, {32768, 32768 + 5000, 32768 - 5000}};
  for (const int layer : {250, -500, 0, -250}) {
    bench.sample.layer = static_cast<std::int16_t>(layer);
    bench.sample.channels = {distances};
    if (layer == -500) bench.sample.channels.push_back(angles);
    bench.send_next();
  }
  ASSERT_EQ(bench.clouds.size(), 1U);
  const Cloud& cloud = bench.clouds[0];
  ASSERT_EQ(cloud.size(), 12U);
  for (std::size_t i = 0; i < 3; ++i) {
    // The second plane's half a degree, in 1/10000 degree.
    const CloudPoint &plain = cloud.points()[i], corrected = cloud.points()[3 + i],
                     next = cloud.points()[6 + i];
    const double turned = std::atan2(corrected.y, corrected.x) - std::atan2(plain.y, plain.x);
    EXPECT_NEAR(turned * deg_per_rad, i == 0 ? 0 : i == 1 ? 0.5 : -0.5, 1e-4) << i;
    EXPECT_NEAR(std::atan2(next.y, next.x), std::atan2(plain.y, plain.x), 1e-6) << "of one telegram alone";
  }
}

}  // namespace
}  // namespace lidard::test
