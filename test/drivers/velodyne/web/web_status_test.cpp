// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/web_status.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lidard::velodyne {
namespace {

using Level = SettingsStatus::Level;

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

WebState answering() {
  WebState state;
  state.answered = true;
  state.serial = "AG1";
  state.local_address = "192.168.1.77";
  state.tree = {
      {"config.rpm", "600"},         {"config.returns", "Strongest"}, {"config.host.addr", "192.168.1.77"},
      {"config.host.dport", "2368"}, {"status.motor.rpm", "598"},     {"status.motor.state", "On"},
      {"status.laser.state", "On"},  {"info.serial", "AG1"}};
  return state;
}

Received receiving() {
  Received received;
  received.data = true;
  received.destination = {IpAddress::v4(192, 168, 1, 77), 2368};
  received.listens_on = 2368;
  return received;
}

Received silent() {
  Received received;
  received.listens_on = 2368;
  return received;
}

TEST(WebContradictions, AreNoneWhereReportAndDataAgree) {
  EXPECT_THAT(contradictions(answering(), receiving()), IsEmpty());
  EXPECT_THAT(contradictions(answering(), silent()), IsEmpty());
  EXPECT_THAT(contradictions({}, receiving()), IsEmpty());
}

TEST(WebContradictions, NameADestinationThatIsNotOurs) {
  WebState state = answering();
  state.tree["config.host.dport"] = "2370";
  EXPECT_THAT(
      contradictions(state, silent()),
      ElementsAre("the sensor reports that it sends to port 2370, but ip_port is 2368; correct ip_port, or "
                  "set host_port: 2368 in control"));
  EXPECT_THAT(contradictions(state, receiving()), ElementsAre(HasSubstr("but its data arrive on 2368")));
  state = answering();
  state.tree["config.host.addr"] = "192.168.1.99";
  EXPECT_THAT(
      contradictions(state, silent()),
      ElementsAre(StartsWith("the sensor sends its data to 192.168.1.99, but this host is 192.168.1.77")));
  EXPECT_THAT(contradictions(state, receiving()),
              ElementsAre(HasSubstr("sends to 192.168.1.99, but its data arrive for 192.168.1.77")));
}

TEST(WebContradictions, TakeBroadcastAndMulticastForOurs) {
  for (const char* everybody : {"255.255.255.255", "192.168.1.255", "239.0.0.1"}) {
    WebState state = answering();
    state.tree["config.host.addr"] = everybody;
    EXPECT_THAT(contradictions(state, silent()), IsEmpty()) << everybody;
    EXPECT_THAT(contradictions(state, receiving()), IsEmpty()) << everybody;
  }
}

TEST(WebStatus, SaysWhatIsWrongMostUrgentFirst) {
  WebState state = answering();
  SettingsStatus item = web_status(state, receiving());
  EXPECT_EQ(item.serial, "AG1");
  EXPECT_EQ(item.level, Level::ok);
  EXPECT_EQ(item.message, "answering");

  state.tree["status.motor.state"] = "Off";
  item = web_status(state, receiving());
  EXPECT_EQ(item.level, Level::warn);
  EXPECT_EQ(item.message, "the motor is off; switch it on in the sensor's web page (rpm)");

  state.unknown = {"rpm"};
  item = web_status(state, receiving());
  EXPECT_EQ(item.message, "the sensor does not report rpm, so it is not written; remove it from control");

  state.trouble = "no web interface";
  EXPECT_EQ(web_status(state, receiving()).message, "no web interface");

  state.refused = {"rpm: 600 -> 1200"};
  item = web_status(state, receiving());
  EXPECT_EQ(item.level, Level::error);
  EXPECT_THAT(item.message, StartsWith("the sensor did not apply rpm: 600 -> 1200; "));
}

TEST(WebStatus, TellsMotorLaserAndPps) {
  for (const auto& [key, value, message] :
       {std::tuple("status.motor.state", "Off", "the motor is off"),
        std::tuple("status.laser.state", "Off", "the laser is off"),
        std::tuple("status.gps.pps_state", "Error", "the sensor reports an error of the PPS signal")}) {
    WebState state = answering();
    state.tree[key] = value;
    const SettingsStatus item = web_status(state, silent());
    EXPECT_EQ(item.level, Level::warn);
    EXPECT_THAT(item.message, StartsWith(message));
  }
}

}  // namespace
}  // namespace lidard::velodyne
