// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/velodyne_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lidard {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr const char* snapshot =
    R"({"info": {"serial": "AG1"}, "config": {"rpm": 600, "returns": "Strongest", "fov": {"start": 0, "end": 359},
        "host": {"addr": "192.168.1.77", "dport": 2368, "tport": "8308"}}})";

/// Path, body and text of the only change.
std::vector<std::string> only_change(const std::string& answer, const VelodyneSettings& wanted) {
  const auto todo = plan(answer, wanted);
  if (!todo) return {"no plan"};
  EXPECT_THAT(todo->unknown, IsEmpty());
  if (todo->changes.size() != 1) return {std::to_string(todo->changes.size()) + " changes"};
  const VelodyneChange& change = todo->changes[0];
  return {change.path, change.body, change.text};
}

TEST(VelodynePlan, IsEmptyWithoutWishes) {
  EXPECT_THAT(plan(snapshot, {})->changes, IsEmpty());
  EXPECT_EQ(plan(snapshot, {})->serial, "AG1");
  EXPECT_THAT(plan("{}", {})->unknown, IsEmpty());
}

TEST(VelodynePlan, NamesPathFormAndChange) {
  VelodyneSettings wanted;
  wanted.rpm = 1200;
  EXPECT_THAT(only_change(snapshot, wanted), ElementsAre("/cgi/setting", "rpm=1200", "rpm: 600 -> 1200"));
  wanted = {};
  wanted.returns = VelodyneReturns::dual;
  EXPECT_THAT(only_change(snapshot, wanted),
              ElementsAre("/cgi/setting", "returns=Dual", "returns: Strongest -> Dual"));
  wanted = {};
  wanted.fov_start_deg = 270;
  EXPECT_THAT(only_change(snapshot, wanted),
              ElementsAre("/cgi/setting/fov", "start=270", "fov start: 0 -> 270"));
  wanted = {};
  wanted.host_port = 2369;
  EXPECT_THAT(only_change(snapshot, wanted),
              ElementsAre("/cgi/setting/host", "dport=2369", "host port: 2368 -> 2369"));
  wanted = {};
  wanted.host_telemetry_port = 8309;
  EXPECT_THAT(only_change(snapshot, wanted),
              ElementsAre("/cgi/setting/host", "tport=8309", "host telemetry_port: 8308 -> 8309"));
  wanted = {};
  wanted.host_address = IpAddress::v4(192, 168, 1, 5);
  EXPECT_THAT(only_change(snapshot, wanted), ElementsAre("/cgi/setting/host", "addr=192.168.1.5",
                                                         "host address: 192.168.1.77 -> 192.168.1.5"));
}

TEST(VelodynePlan, IgnoresTheCaseOfWords) {
  VelodyneSettings wanted;
  wanted.returns = VelodyneReturns::strongest;
  EXPECT_THAT(plan(R"({"config": {"returns": "STRONGEST"}})", wanted)->changes, IsEmpty());
}

TEST(VelodynePlan, SendsAFullTurnAs359AndTakes360ForTheSame) {
  VelodyneSettings wanted;
  wanted.fov_end_deg = 360;
  EXPECT_THAT(plan(snapshot, wanted)->changes, IsEmpty());
  EXPECT_THAT(plan(R"({"config": {"fov": {"end": 360}}})", wanted)->changes, IsEmpty());
  EXPECT_THAT(only_change(R"({"config": {"fov": {"end": 90}}})", wanted),
              ElementsAre("/cgi/setting/fov", "end=359", "fov end: 90 -> 359"));
}

TEST(VelodynePlan, MovesTheStreamLast) {
  const VelodyneSettings wanted{300, VelodyneReturns::last, 10, 20, IpAddress::v4(1, 2, 3, 4), 1, 2};
  std::vector<std::string> bodies;
  const auto todo = plan(snapshot, wanted);
  for (const auto& change : todo->changes) bodies.push_back(change.body);
  EXPECT_THAT(bodies, ElementsAre("rpm=300", "returns=Last", "start=10", "end=20", "dport=1", "tport=2",
                                  "addr=1.2.3.4"));
}

TEST(VelodynePlan, DoesNotTouchWhatIsNotReported) {
  const VelodyneSettings wanted{300, VelodyneReturns::last, 10, 20, IpAddress::v4(1, 2, 3, 4), 1, 2};
  const auto todo = plan(R"({"config": {}})", wanted);
  EXPECT_THAT(todo->changes, IsEmpty());
  EXPECT_EQ(todo->unknown.size(), 7U);
}

TEST(VelodynePlan, RefusesWhatIsNoObject) {
  for (const char* text : {"", "[]", "3", "{\"a\":", "<html>", "{\"a\":\"\xff\"}", "{} {}"}) {
    EXPECT_FALSE(plan(text, {})) << text;
  }
}

TEST(VelodynePlan, SurvivesAHostileAnswer) {
  VelodyneSettings wanted;
  wanted.rpm = 300;
  std::string deep;
  for (int i = 0; i < 200000; ++i) deep += "{\"config\":";
  EXPECT_FALSE(plan(deep, wanted));
  EXPECT_THAT(plan(deep + "1" + std::string(200000, '}'), wanted)->unknown, ElementsAre("rpm"));
  for (const char* rpm : {"{}", "[600]", "null", "\"\""})
    EXPECT_THAT(plan(R"({"config": {"rpm": )" + std::string(rpm) + "}}", wanted)->unknown,
                ElementsAre("rpm"));
  EXPECT_THAT(plan(R"({"config": [{"rpm": 600}]})", wanted)->unknown, ElementsAre("rpm"));
  EXPECT_THAT(only_change(R"({"config": {"rpm": "\u001b[31m)" + std::string(500, 'x') + R"("}})", wanted),
              ElementsAre("/cgi/setting", "rpm=300", "rpm: ?[31m" + std::string(123, 'x') + " -> 300"));
}

}  // namespace
}  // namespace lidard
