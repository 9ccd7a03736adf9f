// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/velodyne_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lidard {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

VelodyneTree snapshot() {
  return {{"config.rpm", "600"},        {"config.returns", "Strongest"},      {"config.fov.start", "0"},
          {"config.fov.end", "359"},    {"config.host.addr", "192.168.1.77"}, {"config.host.dport", "2368"},
          {"config.host.tport", "8308"}};
}

/// Path, body and text of the only change.
std::vector<std::string> only_change(const VelodyneTree& tree, const VelodyneSettings& wanted) {
  const VelodynePlan todo = plan(tree, wanted);
  EXPECT_THAT(todo.unknown, IsEmpty());
  if (todo.changes.size() != 1) return {std::to_string(todo.changes.size()) + " changes"};
  const VelodyneChange& change = todo.changes[0];
  return {change.path, change.body, change.text};
}

TEST(VelodynePlan, IsEmptyWithoutWishes) {
  EXPECT_THAT(plan(snapshot(), {}).changes, IsEmpty());
  EXPECT_THAT(plan({}, {}).unknown, IsEmpty());
}

TEST(VelodynePlan, NamesPathFormAndChange) {
  VelodyneSettings wanted;
  wanted.rpm = 1200;
  EXPECT_THAT(only_change(snapshot(), wanted), ElementsAre("/cgi/setting", "rpm=1200", "rpm: 600 -> 1200"));
  wanted = {};
  wanted.returns = VelodyneReturns::dual;
  EXPECT_THAT(only_change(snapshot(), wanted),
              ElementsAre("/cgi/setting", "returns=Dual", "returns: Strongest -> Dual"));
  wanted = {};
  wanted.fov_start_deg = 270;
  EXPECT_THAT(only_change(snapshot(), wanted),
              ElementsAre("/cgi/setting/fov", "start=270", "fov start: 0 -> 270"));
  wanted = {};
  wanted.host_port = 2369;
  EXPECT_THAT(only_change(snapshot(), wanted),
              ElementsAre("/cgi/setting/host", "dport=2369", "host port: 2368 -> 2369"));
  wanted = {};
  wanted.host_telemetry_port = 8309;
  EXPECT_THAT(only_change(snapshot(), wanted),
              ElementsAre("/cgi/setting/host", "tport=8309", "host telemetry_port: 8308 -> 8309"));
  wanted = {};
  wanted.host_address = IpAddress::v4(192, 168, 1, 5);
  EXPECT_THAT(only_change(snapshot(), wanted), ElementsAre("/cgi/setting/host", "addr=192.168.1.5",
                                                           "host address: 192.168.1.77 -> 192.168.1.5"));
}

TEST(VelodynePlan, IgnoresTheCaseOfWords) {
  VelodyneTree tree = snapshot();
  tree["config.returns"] = "STRONGEST";
  VelodyneSettings wanted;
  wanted.returns = VelodyneReturns::strongest;
  EXPECT_THAT(plan(tree, wanted).changes, IsEmpty());
}

TEST(VelodynePlan, SendsAFullTurnAs359AndTakes360ForTheSame) {
  VelodyneTree tree = snapshot();
  VelodyneSettings wanted;
  wanted.fov_end_deg = 360;
  EXPECT_THAT(plan(tree, wanted).changes, IsEmpty());
  tree["config.fov.end"] = "360";
  EXPECT_THAT(plan(tree, wanted).changes, IsEmpty());
  tree["config.fov.end"] = "90";
  EXPECT_THAT(only_change(tree, wanted), ElementsAre("/cgi/setting/fov", "end=359", "fov end: 90 -> 359"));
}

TEST(VelodynePlan, MovesTheStreamLast) {
  const VelodyneSettings wanted{300, VelodyneReturns::last, 10, 20, IpAddress::v4(1, 2, 3, 4), 1, 2};
  std::vector<std::string> bodies;
  for (const auto& change : plan(snapshot(), wanted).changes) bodies.push_back(change.body);
  EXPECT_THAT(bodies, ElementsAre("rpm=300", "returns=Last", "start=10", "end=20", "dport=1", "tport=2",
                                  "addr=1.2.3.4"));
}

TEST(VelodynePlan, DoesNotTouchWhatIsNotReported) {
  const VelodyneSettings wanted{300, VelodyneReturns::last, 10, 20, IpAddress::v4(1, 2, 3, 4), 1, 2};
  const VelodynePlan todo = plan({{"config.rpm", ""}}, wanted);
  EXPECT_THAT(todo.changes, IsEmpty());
  EXPECT_EQ(todo.unknown.size(), 7U);
}

TEST(VelodyneJson, IsReadFlat) {
  const auto tree = read_velodyne_json(
      R"({"info":{"model":"VLP-16"},"config":{"rpm":600,"fov":{"start":0}},"x":true,"n":null,"f":1.5,"l":[1]})");
  ASSERT_TRUE(tree);
  EXPECT_EQ(*tree, (VelodyneTree{{"info.model", "VLP-16"},
                                 {"config.rpm", "600"},
                                 {"config.fov.start", "0"},
                                 {"x", "on"},
                                 {"n", ""},
                                 {"f", "1.5"}}));
}

TEST(VelodyneJson, RefusesWhatIsNoObject) {
  for (const char* text : {"", "[]", "3", "{\"a\":", "<html>", "{\"a\":\"\xff\"}", "{} {}"}) {
    EXPECT_FALSE(read_velodyne_json(text)) << text;
  }
}

TEST(VelodyneJson, SurvivesAHostileAnswer) {
  std::string deep;
  for (int i = 0; i < 200000; ++i) deep += "{\"a\":";
  EXPECT_FALSE(read_velodyne_json(deep));
  EXPECT_TRUE(read_velodyne_json(deep + "1" + std::string(200000, '}'))->empty());
  std::string wide = "{";
  for (int i = 0; i < 5000; ++i) wide += "\"" + std::to_string(i) + "\":\"" + std::string(500, 'x') + "\",";
  const auto tree = read_velodyne_json(wide + "\"z\":\"\\u001b[31m\"}");
  ASSERT_TRUE(tree);
  EXPECT_LE(tree->size(), 1000U);
  EXPECT_EQ(tree->begin()->second.size(), 128U);
  EXPECT_EQ(read_velodyne_json("{\"z\":\"\\u001b[31m\"}")->at("z"), "?[31m");
}

}  // namespace
}  // namespace lidard
