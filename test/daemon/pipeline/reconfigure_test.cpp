// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// A pipeline that gets another configuration while it works, and two pipelines that share the work of one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "daemon/health/pipeline_health.h"
#include "daemon/live/division.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/capture/pcap_source.h"
#include "test/support/captures.h"
#include "test/support/recording_sink.h"

namespace lidard {
namespace {

std::string demo() { return test::content(test::project_file("config/demo.yaml")); }

/// The demo with one more entry of merged scans, which takes a virtual scan too.
Config demo_with_all() {
  return parse_config(
      demo() +
          "  extra: {cloud_topic: roof, virtual_laser_scan: [knee], poses: {knee: {xyz: [0.1, "
          "0, 0.5]}}, beams: 360}\n",
      "demo");
}

std::string with(std::string text, const std::string& before, const std::string& after) {
  const auto at = text.find(before);
  EXPECT_NE(at, std::string::npos) << before;
  return text.replace(at, before.size(), after);
}

/// Plays the demo's capture; `each` is called before each packet with its number.
void play(const std::function<void(std::size_t, const Packet&)>& each) {
  PcapSource source(test::project_file("pcaps/demo.pcap"));
  Packet packet;
  for (std::size_t number = 0; source.next(packet); ++number) each(number, packet);
}

struct Played {
  explicit Played(Config first) : config(std::move(first)), pipeline(config, none, sink) {}
  Config config;
  NoTransforms none;
  test::RecordingSink sink;
  Pipeline pipeline;
};

void expect_same(const test::RecordingSink& a, const test::RecordingSink& b, const std::string& topic) {
  const auto has_scans = a.scans.count(topic) > 0;
  if (!has_scans) {
    const auto &all = a.clouds.at(topic), &same = b.clouds.at(topic);
    ASSERT_EQ(all.size(), same.size()) << topic;
    for (std::size_t i = 0; i < all.size(); ++i)
      ASSERT_EQ(all[i].points_bytes, same[i].points_bytes) << topic << i;
    return;
  }
  const auto &all = a.scans.at(topic), &same = b.scans.at(topic);
  ASSERT_EQ(all.size(), same.size()) << topic;
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_EQ(all[i].stamp, same[i].stamp) << topic << " " << i;
    ASSERT_EQ(all[i].ranges.size(), same[i].ranges.size()) << topic << " " << i;
    ASSERT_EQ(std::memcmp(all[i].ranges.data(), same[i].ranges.data(), all[i].ranges.size() * sizeof(float)),
              0)
        << topic << " " << i;
  }
}

const std::vector<std::string> demo_topics = {
    "front_left/scan", "front_right/scan", "roof/points", "scan_multi",
    "scan_strict",     "scan_safety",      "bumper",      "chest"};

TEST(PipelineReconfigure, LosesNothingWhereEntriesStayTheSame) {
  Played calm(parse_config(demo(), "demo"));
  play([&](std::size_t, const Packet& packet) { calm.pipeline.packet(packet); });
  Played changed(parse_config(demo(), "demo"));
  const Config same = parse_config(demo(), "other name"), more = demo_with_all();
  play([&](std::size_t number, const Packet& packet) {
    if (number == 700) changed.pipeline.configure(same);
    if (number == 1001) changed.pipeline.configure(more);
    if (number == 1503) changed.pipeline.configure(same);
    changed.pipeline.packet(packet);
  });
  for (const std::string& topic : demo_topics) expect_same(calm.sink, changed.sink, topic);
  EXPECT_GT(changed.sink.count("knee"), 1U) << "the entry that came lived for a while";
  EXPECT_LT(changed.sink.count("knee"), changed.sink.count("bumper"));
}

TEST(PipelineReconfigure, WhatChangesBeginsAnewAndTheRestGoesOn) {
  Played calm(parse_config(demo(), "demo"));
  play([&](std::size_t, const Packet& packet) { calm.pipeline.packet(packet); });
  Played changed(parse_config(demo(), "demo"));
  const Config moved = parse_config(
      with(with(demo(), "xyz: [0.0, -1.0, 0.35]", "xyz: [0.1, -1.0, 0.35]"), "beams: 720", "beams: 360"),
      "demo");
  play([&](std::size_t number, const Packet& packet) {
    if (number == 900) changed.pipeline.configure(moved);
    changed.pipeline.packet(packet);
  });
  for (const char* topic : {"front_left/scan", "roof/points"}) expect_same(calm.sink, changed.sink, topic);
  EXPECT_EQ(changed.sink.scans["bumper"].front().beams, 720U);
  EXPECT_EQ(changed.sink.scans["bumper"].back().beams, 360U);
  const auto reports = changed.pipeline.status(changed.pipeline.now()).sensors;
  EXPECT_LT(reports[1].counters.frames, reports[0].counters.frames)
      << "the sensor that was moved counts anew";
}

TEST(PipelineReconfigure, ASensorMayGoAndComeAtAnotherPlaceOfTheFile) {
  const std::string few =
      "sensors:\n  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, ip_port: 2368}\n";
  const std::string before = few + "  a: {model: sick_microscan3, ip_address: 192.168.0.21, ip_port: 6060}\n";
  const std::string after =
      "sensors:\n  a: {model: sick_microscan3, ip_address: 192.168.0.21, ip_port: 6060}\n"
      "  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, ip_port: 2368}\n";
  Played calm(parse_config(before, "f")), changed(parse_config(before, "f"));
  play([&](std::size_t number, const Packet& packet) {
    calm.pipeline.packet(packet);
    if (number == 500) changed.pipeline.configure(parse_config(after, "f"));
    if (number == 1100) changed.pipeline.configure(parse_config(few, "f"));
    changed.pipeline.packet(packet);
  });
  expect_same(calm.sink, changed.sink, "roof/points");
  EXPECT_LT(changed.sink.count("a/scan"), calm.sink.count("a/scan"));
  EXPECT_GT(changed.sink.count("a/scan"), 5U);
  EXPECT_EQ(changed.pipeline.status(changed.pipeline.now()).sensors.size(), 1U);
  EXPECT_EQ(changed.pipeline.unclaimed_senders().size(), 2U) << "both scanners have no entry then";
}

TEST(PipelineReconfigure, WhatWasSetByHandIsWhatTheFileSaysAgain) {
  Played one(parse_config(demo(), "demo"));
  OutputScanConfig wanted = one.config.virtual_scans[0].output;
  wanted.grid.beams = 100;
  ASSERT_EQ(one.pipeline.set_scan({MakerId::Kind::virtual_group, "levels"}, wanted), "");
  play([&](std::size_t number, const Packet& packet) {
    if (number == 900) one.pipeline.configure(one.config);
    one.pipeline.packet(packet);
  });
  EXPECT_EQ(one.sink.scans["bumper"].front().beams, 100U);
  EXPECT_EQ(one.sink.scans["bumper"].back().beams, 720U);
}

TEST(PipelineReconfigure, WhatIsNewHasASecondToDeliverAndTheRestHasNone) {
  const std::string one = "sensors: {a: {topic: /a}";
  Played played(parse_config(one + "}\n", "f"));
  const auto tick = [&](int at) {
    played.pipeline.tick(Stamp{1'000'000'000'000} + std::chrono::milliseconds(at));
  };
  const auto health = [&](int at) {
    std::string all;
    for (const auto& item :
         items_of(played.pipeline, Stamp{1'000'000'000'000} + std::chrono::milliseconds(at)))
      all += item.name + (item.health == Health::ok ? " ok, " : " bad, ");
    return all;
  };
  for (int at = 0; at <= 3000; at += 100) tick(at);
  EXPECT_EQ(health(3000), "sensor a bad, ");
  played.pipeline.configure(
      parse_config(one + ", b: {topic: /b}}\nmerged_scans: {m: {laserscan_topics: [a, b]}}\n", "f"));
  EXPECT_EQ(health(3900), "sensor a bad, sensor b ok, merged m ok, ");
  EXPECT_EQ(health(4000), "sensor a bad, sensor b bad, merged m bad, ");
}

TEST(Division, GivesWhatOnePipelineGives) {
  const std::string text =
      with(demo(), "virtual_scans:",
           "  mixed: {laserscan_topics: [front_left, bumper], profile: flatten}\nvirtual_scans:");
  Played all(parse_config(text, "demo"));
  play([&](std::size_t, const Packet& packet) { all.pipeline.packet(packet); });
  const Division division(all.config);
  Played planes(division.planes), clouds(division.clouds);
  clouds.pipeline.set_forward([&](const std::string& source, const PlanarScan& scan, Stamp now) {
    planes.pipeline.forwarded_scan(source, scan, now);
  });
  play([&](std::size_t, const Packet& packet) {
    const bool of_planes = packet.to.port == 6060;
    planes.pipeline.advance(packet.arrival);
    (of_planes ? planes : clouds).pipeline.packet(packet);
  });
  for (const char* topic :
       {"front_left/scan", "front_right/scan", "scan_multi", "scan_strict", "scan_safety", "mixed"})
    expect_same(all.sink, planes.sink, topic);
  for (const char* topic : {"roof/points", "bumper", "chest"}) expect_same(all.sink, clouds.sink, topic);
  EXPECT_EQ(planes.pipeline.status(planes.pipeline.now()).sensors.size(), 2U)
      << "what is forwarded is no lidar";
  EXPECT_EQ(planes.pipeline.static_transforms().size(), all.pipeline.static_transforms().size());
}

}  // namespace
}  // namespace lidard
