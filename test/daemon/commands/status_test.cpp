// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/status.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "daemon/files/text_table.h"
#include "daemon/live/runtime_socket.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;
using std::chrono::microseconds;

DaemonState sample_state() {
  DaemonState state;
  state.node = "/lidard";
  state.now = HostStamp{1'700'000'000'250'000'000};
  state.uptime = std::chrono::hours(25);
  state.summary = "1/1 lidars";
  DiagnosticItem item;
  item.name = "sensor \"front\"\n\\";
  item.health = Health::error;
  item.message = "bytes \xff\xfe of a device\nand a line";
  item.values = {{"Packets", "7"}};
  state.items = {item};
  TopicFigures figures;
  figures.frames = 42;
  figures.rate_hz = 33.3;
  figures.median_latency = microseconds(100);
  figures.p99_latency = microseconds(900);
  figures.longest_latency = microseconds(1500);
  state.topics = {{"front/scan", figures}};
  return state;
}

TEST(Status, IsJsonWhateverDevicesSay) {
  Journal journal([](const Event&) {});
  for (int i = 0; i < 12; ++i)
    journal.add({HostStamp{1'700'000'000'000'000'000 + i * 1'000'000L}, "sensor " + std::to_string(i),
                 Health::warn, std::to_string(i)});
  journal.add({HostStamp{1'700'000'000'011'000'000}, "sensor 11", Health::warn, "11"});
  const Json said = Json::parse(status_json(sample_state(), journal));
  EXPECT_EQ(said["at"], "2023-11-14T22:13:20.250Z");
  EXPECT_EQ(said["uptime_s"], 25 * 3600);
  EXPECT_EQ(said["items"][0]["level"], "ERROR");
  EXPECT_THAT(said["items"][0]["message"].get<std::string>(), HasSubstr("of a device"));
  EXPECT_EQ(said["items"][0]["values"]["Packets"], "7");
  EXPECT_EQ(said["topics"][0]["latency_ms"]["p99"], 0.9);
  ASSERT_EQ(said["events"].size(), 10U) << "the newest";
  EXPECT_EQ(said["events"][0]["text"], "2");
  EXPECT_EQ(said["events"][9]["at"], "2023-11-14T22:13:20.011Z");
  EXPECT_EQ(said["events"][9]["count"], 2);
  EXPECT_EQ(said["events"][8]["first"], "2023-11-14T22:13:20.010Z");
  EXPECT_EQ(said["events"][8]["count"], 1);
}

TEST(Status, CountsHoursBeyondADayAndEndsWithOneWhereSomethingIsInError) {
  const std::string path = testing::TempDir() + "lidard-status-" + std::to_string(getpid());
  const Journal journal([](const Event&) {});
  boost::asio::io_context io;
  RuntimeSocket socket(io,
                       {{"status", [&](const auto& reply) { reply(status_json(sample_state(), journal)); }}});
  ASSERT_EQ(socket.start(path), "");
  std::thread thread([&io] { io.run(); });
  for (const bool json : {false, true}) {
    StatusOptions options;
    options.socket = path;
    options.json = json;
    std::ostringstream out, err;
    EXPECT_EQ(run_status(options, out, err), 1) << err.str();
    EXPECT_THAT(out.str(), HasSubstr(json ? "\"uptime_s\": 90000" : "up 25:00:00"));
  }
  io.stop();
  thread.join();
}

TEST(Status, HasATableOfTopicsWithALineForEachHoweverLongItsName) {
  DaemonState state = sample_state();
  state.topics.front().first = "front_left_bumper/scan_of_the_strict_profile";
  const std::string path = testing::TempDir() + "lidard-status-" + std::to_string(getpid());
  const Journal journal([](const Event&) {});
  boost::asio::io_context io;
  RuntimeSocket socket(io, {{"status", [&](const auto& reply) { reply(status_json(state, journal)); }}});
  ASSERT_EQ(socket.start(path), "");
  std::thread thread([&io] { io.run(); });
  StatusOptions options;
  options.socket = path;
  std::ostringstream out, err;
  run_status(options, out, err);
  io.stop();
  thread.join();
  EXPECT_THAT(out.str(), ::testing::ContainsRegex("profile +42 .*\n"));
  const std::size_t name = out.str().find("TOPIC"), frames = out.str().find("FRAMES");
  EXPECT_GT(frames - name, state.topics.front().first.size()) << out.str();
}

TEST(Events, AreAllThatTheJournalHas) {
  Journal journal([](const Event&) {});
  for (std::size_t i = 0; i < Journal::most_events + 3; ++i)
    journal.add({HostStamp{}, "sensor " + std::to_string(i), Health::ok, "back"});
  const Json said = Json::parse(events_json(journal));
  EXPECT_EQ(said["forgotten"], 3);
  EXPECT_EQ(said["events"].size(), Journal::most_events);
  EXPECT_EQ(said["events"][0]["level"], "OK");
}

/// The lines of a table in so many columns.
std::vector<std::string> lines_of(const TextTable& table, std::size_t width, std::size_t widest = 21) {
  std::stringstream out;
  print_columns(table, out, "", width, widest);
  std::vector<std::string> lines;
  for (std::string line; std::getline(out, line);) lines.push_back(line);
  return lines;
}

TEST(Columns, OfAnOverviewKeepItsWidth) {
  const std::string name(30, 'n'), word(100, 'w'), words = word + " a b " + word;
  const TextTable table{{"STATE", "WHAT", "SAYS"}, {"OK", "short", "few words"}, {"ERROR", name, words}};
  const auto lines = lines_of(table, 80);
  std::string said;
  for (const std::string& line : lines) {
    EXPECT_LE(line.size(), 80U) << line;
    for (const char c : line) said += c == ' ' ? "" : std::string(1, c);
  }
  EXPECT_EQ(said, "STATEWHATSAYSOKshortfewwordsERROR" + name + word + "ab" + word) << "nothing is cut off";
  EXPECT_EQ(lines[1], "OK     short                  few words");
  EXPECT_EQ(lines[2], "ERROR  " + name) << "a long name has a line of its own";
  EXPECT_EQ(lines[3], std::string(30, ' ') + word.substr(0, 50));
  EXPECT_EQ(lines_of(table, 80, 32)[2], "ERROR  " + name + "  " + word.substr(0, 41));
  EXPECT_EQ(lines_of(table, 0).size(), 3U) << "without a width one line for each row";
}

TEST(Metrics, EscapeNamesAsPrometheusWantsIt) {
  const std::string text = metrics_text(sample_state());
  EXPECT_THAT(text, HasSubstr("lidard_health{item=\"sensor \\\"front\\\"\\n\\\\\"} 2\n"));
  EXPECT_THAT(text, HasSubstr("lidard_frames_total{topic=\"front/scan\"} 42\n"));
  EXPECT_THAT(text, HasSubstr("lidard_latency_seconds{topic=\"front/scan\",quantile=\"0.99\"} 0.000900\n"));
}

}  // namespace
}  // namespace lidard
