// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// States and the sentences that they make; test/sentences.py demands a state for each sentence.
#include "daemon/health/sentences.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "daemon/health/output_health.h"
#include "daemon/health/reception_verdict.h"
#include "daemon/health/report.h"
#include "daemon/health/sensor_health.h"
#include "daemon/health/topic_health.h"
#include "drivers/registry/registry.h"
#include "test/support/says.h"

namespace lidard {
namespace {

using test::Says;
using testing::AllOf;
using testing::HasSubstr;

const Stamp instant{1'767'226'643'000'000'000};

TEST(Sentence, CountsAFigureOnceAndPutsItInWhereverItStands) {
  static constexpr Sentence sentence{Health::warn, "{first:.1f} and {second}, not {first:.2f}",
                                     "set {second}"};
  static_assert(FigureNames(sentence).count() == 2);
  EXPECT_EQ(text<sentence>(1.25, "two"), "1.2 and two, not 1.25; set two");
  EXPECT_EQ(fact<sentence>(1.25, "two"), "1.2 and two, not 1.25");
  static constexpr Sentence bare{Health::ok, "well", ""};
  EXPECT_EQ(text<bare>(), "well");
  DiagnosticItem item{"x"};
  item.set<sentence>(0.0, "{braces}");
  EXPECT_EQ(item.health, Health::warn);
  EXPECT_EQ(item.message, "0.0 and {braces}, not 0.00; set {braces}");
}

/// A sensor that delivers.
struct SensorState {
  explicit SensorState(const std::string& keys = "model: velodyne_vlp16, ip_address: 192.168.1.201")
      : config(parse_config("sensors: {s: {" + keys + "}}", "s").sensors.at(0)) {
    report.config = &config;
    report.seen = true;
    report.last_arrival = instant;
    report.counters.packets = 100;
    report.counters.frames = 1;
  }
  std::string says() const { return sensor_health(report, {}, instant).message; }
  SensorConfig config;
  SensorStatus report;
};

TEST(Sentences, OfASensorThatDelivers) {
  SensorState state;
  EXPECT_THAT(state.says(), Says(says::receiving));
  state.report.filters = {{"s/points", {}}};
  EXPECT_THAT(sensor_health(state.report, {}, instant).values,
              testing::Contains(testing::Pair("Filter", Says(says::filter_counts))));
  state.report.filters[0].counters.has_no_intensities = true;
  EXPECT_THAT(state.says(), Says(says::no_intensities));
  state.report.info.warnings = {"it is hot"};
  EXPECT_EQ(state.says(), "it is hot");
  state.report.recent.counters.packets = 98;
  state.report.recent.counters.lost_packets = 2;
  state.report.recent.watched_s = 10;
  EXPECT_THAT(state.says(), AllOf(Says(says::packets_lost), Says(says::too_little),
                                  HasSubstr("The device says: it is hot")));
  EXPECT_THAT(state.says(), Says(says::device_says));
  state.report.clock_ahead = std::chrono::hours(1);
  EXPECT_THAT(state.says(), AllOf(Says(says::stamps_replaced), Says(says::from_address)));
  EXPECT_THAT(state.says(), AllOf(HasSubstr(text<says::ahead_of>()), Says(says::or_offset)));
  state.report.clock_ahead = -std::chrono::hours(1);
  EXPECT_THAT(state.says(), HasSubstr(text<says::behind>()));
  state.report.rivals = "VLP-16 and VLP-32C";
  EXPECT_THAT(state.says(), Says(says::two_devices));

  SensorState scanner("model: sick_lms1xx, ip_address: 192.168.1.11");
  scanner.report.rivals = "1 and 2";
  EXPECT_THAT(scanner.says(), AllOf(Says(says::two_devices), Says(says::serial_numbers)));
  SensorState driven("topic: /scan");
  driven.report.counters.packets = 1;
  driven.report.counters.reject(Reject::field);
  EXPECT_EQ(sensor_health(driven.report, {}, instant).health, Health::error);
  EXPECT_THAT(driven.says(), AllOf(Says(says::unusable_messages), HasSubstr("/scan")));
}

TEST(Sentences, OfASensorWithoutAWholeFrame) {
  const Model& vlp16 = *find_model("velodyne_vlp16");
  Counters counters;
  counters.packets = 1;
  EXPECT_THAT(why_no_frame(vlp16, counters, std::chrono::milliseconds(40)), Says(says::part_of_a_frame));
  EXPECT_THAT(why_no_frame(vlp16, counters, std::chrono::milliseconds(400)), Says(says::no_whole_frame));
  counters.reject(Reject::size);
  EXPECT_THAT(why_no_frame(vlp16, counters, std::chrono::milliseconds(400)), Says(says::no_usable_packet));
}

TEST(Sentences, OfASilentSensor) {
  SensorState state;
  state.report.last_arrival = instant - std::chrono::seconds(1);
  EXPECT_THAT(state.says(), AllOf(Says(says::silent), Says(says::nothing_received)));
  state.report.connection.port.error = EACCES;
  EXPECT_THAT(state.says(), AllOf(Says(says::silent), Says(says::nothing_because)));
  UnknownSenders others;
  Packet packet;
  packet.to.port = 2368;
  packet.arrival = instant;
  others.note(packet);
  EXPECT_THAT(sensor_health(state.report, others, instant).message, Says(says::nothing_but_others));
  SensorState driven("topic: /scan");
  driven.report.seen = false;
  EXPECT_THAT(driven.says(), AllOf(Says(says::nothing_from_driver), Says(says::from_topic)));
  driven.report.starting = true;
  EXPECT_THAT(driven.says(), Says(says::waiting_for_data));
}

TEST(Sentences, OfAReceptionWithLosses) {
  const auto said = [](const Reception& reception, FrameKind kind) {
    const ReceptionVerdict verdict = judge(reception, kind);
    return verdict.figures + "; " + verdict.remedy;
  };
  Reception half;
  half.counters.packets = 100;
  half.watched_s = half.frames_s = 10;
  half.expected = 100;
  half.frames = 40;
  EXPECT_THAT(said(half, FrameKind::cloud), Says(says::frames_missing));
  half.counters.lost_packets = 60;
  EXPECT_THAT(said(half, FrameKind::cloud), Says(says::frames_lost));
  EXPECT_THAT(said(half, FrameKind::scan), AllOf(Says(says::frames_lost), Says(says::scans_lost)));
  Reception twice;
  twice.counters.packets = 9;
  twice.watched_s = 10;
  twice.counters.reject(Reject::duplicate);
  EXPECT_THAT(said(twice, FrameKind::cloud), Says(says::packets_twice));
  Reception blind;
  blind.frames_looked = 10;
  blind.beams = blind.blind = 100;
  EXPECT_THAT(said(blind, FrameKind::cloud), Says(says::beams_blind));

  SensorState state;
  state.report.whole = half;
  std::ostringstream out;
  print_verdicts({state.report}, out);
  EXPECT_THAT(out.str(), Says(says::too_little_in_all));
}

/// A merge of two sources that deliver.
struct MergeState {
  MergeState() {
    status.id.entry = "m";
    status.topics = {"m"};
    status.counters.published = 1;
    status.counters.last_published = instant;
    status.merge.emplace();
    status.merge->sources = {{"a", SourceState::ok, SourceState::ok},
                             {"b", SourceState::ok, SourceState::ok}};
  }
  DiagnosticItem item() const { return output_health(status, instant); }
  std::string says() const { return item().message; }
  std::string value(const std::string& key) const {
    for (const auto& [name, text] : item().values)
      if (name == key) return text;
    return {};
  }
  MakerStatus status;
};

TEST(Sentences, OfAnOutput) {
  MergeState state;
  EXPECT_THAT(state.says(), Says(says::publishing));
  EXPECT_THAT(state.value("Source a"), Says(says::source_state));
  state.status.is_wanted = false;
  EXPECT_THAT(state.says(), Says(says::not_built));
  state.status.merge->apart = std::chrono::hours(1);
  EXPECT_THAT(state.says(), Says(says::clocks_apart));
  state.status.merge->sources[0].lasting = SourceState::stale;
  EXPECT_THAT(state.says(), Says(says::sources_old));
  state.status.merge->sources[0].late_s = 0.1;
  EXPECT_THAT(state.says(), Says(says::sources_late));
  state.status.merge->sources[0].lasting = SourceState::lost;
  EXPECT_THAT(state.says(), Says(says::sources_lost));
  EXPECT_EQ(state.item().health, Health::error);
  state.status.counters.count_no_pose(instant);
  state.status.counters.why_no_pose = "no tf";
  EXPECT_THAT(state.says(), Says(says::published_without));
  EXPECT_EQ(state.item().health, Health::error);
  state.status.merge->sources[1].lasting = SourceState::lost;
  EXPECT_THAT(state.says(), Says(says::no_source_because));
  state.status.counters.last_published = instant - std::chrono::seconds(9);
  EXPECT_THAT(state.says(), Says(says::no_output_any_more));
  state.status.counters.published = 0;
  EXPECT_THAT(state.says(), Says(says::no_output));
  state.status.counters.no_pose = 0;
  EXPECT_THAT(state.says(), Says(says::no_input));
  state.status.starting = true;
  EXPECT_THAT(state.says(), Says(says::waiting_for_input));
}

TEST(Sentences, OfTheMountsOfAMerge) {
  MergeState state;
  MountDifference pair;
  pair.second = 1;
  pair.surfaces = 3;
  pair.since = pair.astray_since = instant;
  pair.determined = {true, false, true};
  pair.is_wrong = true;
  state.status.merge->mounts = {pair};
  EXPECT_THAT(state.says(),
              AllOf(Says(says::mount_wrong), Says(says::a_mount), HasSubstr("since 00:17:23 UTC")));
  EXPECT_THAT(state.says(), AllOf(Says(says::correction), Says(says::undetermined)));
  EXPECT_THAT(state.value("Mount check a/b"), Says(says::mount_check));
  state.status.merge->wrong_mount = 0;
  EXPECT_THAT(state.says(), AllOf(Says(says::mount_wrong), HasSubstr(text<says::the_mount>("a"))));
  state.status.merge->mounts[0].is_astray = true;
  EXPECT_THAT(state.says(), Says(says::nothing_in_common));
}

TEST(Sentences, OfTheMotionOfAMerge) {
  MergeState state;
  PoseTrack track;
  state.status.merge->track = &track;
  EXPECT_EQ(state.value("Motion"), text<says::track_empty>());
  track.add(instant, Pose::Identity());
  EXPECT_EQ(state.value("Motion"), text<says::track_complete>());
  state.status.merge->uses = {SourceUse::deskewed, SourceUse::extrapolated};
  EXPECT_EQ(state.value("Motion"), text<says::track_extrapolated>());
  state.status.merge->uses[0] = SourceUse::static_poses;
  EXPECT_EQ(state.value("Motion"), text<says::track_too_short>());
  state.status.merge->gate.left_out();
  EXPECT_THAT(state.says(), Says(says::dropped_for_poses));
  state.status.merge->gate.left_out("no tf");
  EXPECT_THAT(state.says(), Says(says::not_in_frame));
  MotionStatus motion;
  motion.lacks_speed = true;
  EXPECT_THAT(motion_health(motion).message,
              AllOf(Says(says::pose_refused), Says(says::no_pose_yet), Says(says::no_speed)));
}

TEST(Sentences, OfATopic) {
  TopicFigures figures;
  EXPECT_THAT(topic_health("t", figures).message, Says(says::publishing));
  figures.loses = true;
  EXPECT_THAT(topic_health("t", figures).message, Says(says::slow_subscriber));
}

}  // namespace
}  // namespace lidard
