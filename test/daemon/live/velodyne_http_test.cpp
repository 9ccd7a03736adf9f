// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/velodyne_http.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "test/support/fake_velodyne.h"
#include "test/support/starved.h"

namespace lidard {
namespace {

using namespace std::chrono_literals;
using test::FakeVelodyne;
using Fault = FakeVelodyne::Fault;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Texts = std::vector<std::string>;

const IpAddress loopback = IpAddress::v4(127, 0, 0, 1);

/// A patient condition: machines that run tests are busy.
bool within(std::chrono::seconds limit, const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

VelodyneHttpTiming quick() {
  VelodyneHttpTiming timing;
  timing.pace = 10ms;
  timing.limit = 2s;
  timing.save_limit = 2s;
  timing.settle = 20ms;
  timing.after_save = 20ms;
  timing.first_retry = 20ms;
  timing.last_retry = 100ms;
  return timing;
}

VelodyneControl reading(const FakeVelodyne& sensor) {
  VelodyneControl control;
  control.read = true;
  control.port = sensor.port();
  control.period = 50ms;
  return control;
}

VelodyneControl writing(const FakeVelodyne& sensor) {
  VelodyneControl control = reading(sensor);
  control.allow_write = true;
  return control;
}

class VelodyneHttpTest : public ::testing::Test {
 protected:
  void run(const VelodyneControl& control, const VelodyneHttpTiming& timing = quick()) {
    http_ = std::make_unique<VelodyneHttp>("sensor roof", loopback, control, timing);
    http_->start();
  }
  bool asked(std::size_t times) {
    return within(30s, [&] { return sensor_.requests().size() >= times; });
  }
  /// So many further rounds of questions have ended: whatever was to be written is written.
  bool rounds(std::size_t count) {
    const std::size_t wanted = sensor_.requests("GET /cgi/snapshot.hdl").size() + count + 1;
    return within(30s, [&] { return sensor_.requests("GET /cgi/snapshot.hdl").size() >= wanted; });
  }
  Texts posts() const { return sensor_.requests("POST"); }

  FakeVelodyne sensor_;
  std::unique_ptr<VelodyneHttp> http_;
};

TEST_F(VelodyneHttpTest, AsksNothingByDefault) {
  VelodyneControl control;
  control.port = sensor_.port();
  run(control);
  std::this_thread::sleep_for(200ms);
  EXPECT_THAT(sensor_.requests(), IsEmpty());
  control.allow_write = true;
  run(control);
  std::this_thread::sleep_for(200ms);
  EXPECT_THAT(sensor_.requests(), IsEmpty());
}

TEST_F(VelodyneHttpTest, OnlyReadsWithoutPermissionToWrite) {
  VelodyneControl control = reading(sensor_);
  control.wanted.rpm = 1200;
  run(control);
  ASSERT_TRUE(asked(9));
  const auto all = sensor_.requests();
  EXPECT_EQ(all[0].text, "GET /cgi/snapshot.hdl");
  EXPECT_EQ(all[1].text, "GET /cgi/status.json");
  EXPECT_EQ(all[2].text, "GET /cgi/diag.json");
  EXPECT_EQ(sensor_.requests("GET").size(), sensor_.requests("").size());
  const VelodyneHttpState state = http_->state();
  EXPECT_EQ(state.serial, "AG29999999");
  EXPECT_EQ(state.tree.at("status.motor.rpm"), "599");
  EXPECT_EQ(state.tree.at("diag.volt_temp.top.hv"), "2960");
  EXPECT_EQ(state.trouble, "");
  EXPECT_EQ(state.local_address, "127.0.0.1");
}

TEST_F(VelodyneHttpTest, PostsNothingWhenTheSnapshotAgrees) {
  VelodyneControl control = writing(sensor_);
  control.wanted = {600, VelodyneReturns::strongest,        true, 0,   360, false,
                    0,   IpAddress::v4(255, 255, 255, 255), 2368, 8308};
  control.save = true;
  run(control);
  ASSERT_TRUE(rounds(3));
  EXPECT_THAT(posts(), IsEmpty());
  EXPECT_EQ(http_->state().writes, 0U);
}

TEST_F(VelodyneHttpTest, PostsOnlyWhatDiffersAndEachOnce) {
  sensor_.set("config.fov.end", "90");
  VelodyneControl control = writing(sensor_);
  control.wanted = {1200, VelodyneReturns::strongest, true, 0, 360, true, 9050, loopback, 2368, 8309};
  run(control);
  ASSERT_TRUE(rounds(4));
  EXPECT_THAT(posts(),
              ElementsAre("POST /cgi/setting rpm=1200", "POST /cgi/setting/fov end=359",
                          "POST /cgi/setting/phaselock enabled=on&offset=9050&offsetInput=90.5",
                          "POST /cgi/setting/host tport=8309", "POST /cgi/setting/host addr=127.0.0.1"));
  const VelodyneHttpState state = http_->state();
  EXPECT_THAT(state.refused, IsEmpty());
  EXPECT_EQ(state.writes, 5U);
  EXPECT_TRUE(state.settling);
  EXPECT_EQ(sensor_.get("config.rpm"), "1200");
}

TEST_F(VelodyneHttpTest, SavesOnceAfterTheSensorTookEverything) {
  VelodyneControl control = writing(sensor_);
  control.wanted.rpm = 900;
  control.wanted.returns = VelodyneReturns::dual;
  control.save = true;
  run(control);
  ASSERT_TRUE(within(30s, [&] { return posts().size() >= 3; }));
  ASSERT_TRUE(rounds(3));
  EXPECT_THAT(posts(), ElementsAre("POST /cgi/setting rpm=900", "POST /cgi/setting returns=Dual",
                                   "POST /cgi/save data=submit"));
  const auto all = sensor_.requests("");
  const auto save = std::find(all.begin(), all.end(), "POST /cgi/save data=submit");
  const auto written = std::find(all.begin(), all.end(), "POST /cgi/setting returns=Dual");
  EXPECT_NE(std::find(written, save, "GET /cgi/snapshot.hdl"), save) << "saved before it was verified";
}

TEST_F(VelodyneHttpTest, GoesOnAfterEveryKindOfBadAnswer) {
  for (const Fault fault : {Fault::error_500, Fault::garbage, Fault::half_closed, Fault::hang}) {
    FakeVelodyne sensor;
    sensor.misbehave(fault, 2, "GET /cgi/snapshot.hdl");
    VelodyneControl control = writing(sensor);
    control.wanted.rpm = 1200;
    VelodyneHttp http("sensor roof", loopback, control, quick());
    http.start();
    ASSERT_TRUE(within(30s, [&] { return !http.state().trouble.empty(); })) << static_cast<int>(fault);
    ASSERT_TRUE(within(30s, [&] {
      return sensor.get("config.rpm") == "1200" && http.state().trouble.empty();
    })) << static_cast<int>(fault);
    EXPECT_EQ(http.state().failures, 2U);
    EXPECT_THAT(sensor.requests("POST"), ElementsAre("POST /cgi/setting rpm=1200"));
  }
}

TEST_F(VelodyneHttpTest, WritesNothingWhileTheSnapshotIsUnreadable) {
  sensor_.misbehave(Fault::error_500, 1'000'000, "GET /cgi/snapshot.hdl");
  VelodyneControl control = writing(sensor_);
  control.wanted.rpm = 1200;
  run(control);
  ASSERT_TRUE(asked(10));
  EXPECT_THAT(posts(), IsEmpty());
  EXPECT_THAT(http_->state().trouble, HasSubstr("HTTP status 500"));
}

TEST_F(VelodyneHttpTest, WritesAlthoughDiagnosticsAreNotKnownToTheSensor) {
  sensor_.misbehave(Fault::error_500, 1'000'000, "GET /cgi/diag.json");
  VelodyneControl control = writing(sensor_);
  control.wanted.rpm = 1200;
  run(control);
  ASSERT_TRUE(within(30s, [&] { return sensor_.get("config.rpm") == "1200"; }));
}

TEST_F(VelodyneHttpTest, AcceptsHttp10AndLengthsThatAreTooLarge) {
  for (const Fault fault : {Fault::http_1_0, Fault::length_too_large}) {
    FakeVelodyne sensor;
    sensor.misbehave(fault, 1'000'000);
    VelodyneHttp http("sensor roof", loopback, reading(sensor), quick());
    http.start();
    ASSERT_TRUE(within(30s, [&] { return sensor.requests().size() >= 7; }));
    EXPECT_EQ(http.state().failures, 0U) << static_cast<int>(fault) << " " << http.state().trouble;
    EXPECT_EQ(http.state().serial, "AG29999999");
  }
}

TEST_F(VelodyneHttpTest, RepeatsAWriteThatFailed) {
  for (const Fault fault : {Fault::error_500, Fault::half_closed, Fault::hang}) {
    FakeVelodyne sensor;
    if (fault == Fault::error_500) sensor.misbehave(fault, 2, "POST");
    if (fault != Fault::error_500) sensor.misbehave(fault, 1, "POST");
    VelodyneControl control = writing(sensor);
    control.wanted.rpm = 1200;
    VelodyneHttp http("sensor roof", loopback, control, quick());
    http.start();
    ASSERT_TRUE(within(30s, [&] { return sensor.get("config.rpm") == "1200"; }));
    const std::size_t asked = sensor.requests("GET").size();
    ASSERT_TRUE(within(30s, [&] { return sensor.requests("GET").size() >= asked + 6; }));
    // What was taken without an answer is not written again.
    EXPECT_EQ(sensor.requests("POST").size(), fault == Fault::error_500 ? 3U : 1U);
  }
}

TEST_F(VelodyneHttpTest, GivesUpASettingThatTheSensorIgnores) {
  sensor_.ignore_settings();
  VelodyneControl control = writing(sensor_);
  control.wanted.rpm = 1200;
  control.save = true;
  run(control);
  ASSERT_TRUE(within(30s, [&] { return !http_->state().refused.empty(); }));
  ASSERT_TRUE(rounds(4));
  EXPECT_EQ(posts(), Texts(3, "POST /cgi/setting rpm=1200"));
  EXPECT_THAT(http_->state().refused, ElementsAre("rpm: 600 -> 1200"));
}

TEST_F(VelodyneHttpTest, DoesNotWriteWhatTheSensorDoesNotReport) {
  sensor_.forget("config.rpm");
  VelodyneControl control = writing(sensor_);
  control.wanted.rpm = 1200;
  run(control);
  ASSERT_TRUE(rounds(2));
  EXPECT_THAT(posts(), IsEmpty());
  EXPECT_THAT(http_->state().unknown, ElementsAre("rpm"));
}

TEST_F(VelodyneHttpTest, WritesAgainToASensorThatForgotItsSettingsWhileItWasAway) {
  VelodyneControl control = writing(sensor_);
  control.wanted.rpm = 1200;
  run(control);
  ASSERT_TRUE(within(30s, [&] { return sensor_.get("config.rpm") == "1200"; }));
  sensor_.switch_off();
  ASSERT_TRUE(within(30s, [&] { return http_->state().trouble.find("no web interface") == 0; }));
  ASSERT_TRUE(within(30s, [&] { return http_->state().tree.empty(); }));
  EXPECT_EQ(http_->state().serial, "AG29999999");
  sensor_.set("config.rpm", "600");
  sensor_.switch_on();
  ASSERT_TRUE(within(30s, [&] { return sensor_.get("config.rpm") == "1200"; }));
  EXPECT_EQ(posts(), Texts(2, "POST /cgi/setting rpm=1200"));
}

TEST_F(VelodyneHttpTest, NeverAsksFasterThanItsPace) {
  EXPECT_GE(VelodyneHttpTiming{}.pace, 1s);
  VelodyneHttpTiming timing = quick();
  timing.pace = 100ms;
  timing.settle = 0ms;
  timing.first_retry = 0ms;
  sensor_.misbehave(Fault::error_500, 3);
  VelodyneControl control = writing(sensor_);
  control.period = 0ms;
  control.wanted.rpm = 1200;
  control.wanted.returns = VelodyneReturns::dual;
  const test::Starved starved;
  run(control, timing);
  ASSERT_TRUE(within(30s, [&] { return posts().size() == 2; }));
  ASSERT_TRUE(rounds(1));
  // A request that the sensor notices late is nearer to the next one.
  const auto shortest = 100ms - std::min<std::chrono::nanoseconds>(starved.time(), 90ms);
  const auto all = sensor_.requests();
  for (std::size_t i = 1; i < all.size(); ++i)
    EXPECT_GE(all[i].time - all[i - 1].time, shortest) << all[i].text;
}

TEST_F(VelodyneHttpTest, ASensorThatHangsDoesNotDelayTheEnd) {
  VelodyneHttpTiming timing = quick();
  timing.limit = 60s;
  sensor_.misbehave(Fault::hang, 1'000'000);
  run(reading(sensor_), timing);
  ASSERT_TRUE(asked(1));
  const test::Starved starved;
  const auto begin = std::chrono::steady_clock::now();
  http_->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 2s + starved.time());
}

TEST_F(VelodyneHttpTest, APauseDoesNotDelayTheEnd) {
  VelodyneControl control = reading(sensor_);
  control.period = 3600s;
  run(control);
  ASSERT_TRUE(asked(3));
  const test::Starved starved;
  const auto begin = std::chrono::steady_clock::now();
  http_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 2s + starved.time());
}

}  // namespace
}  // namespace lidard
