// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the daemon publishes and says of the shipped captures stays as it is: messages, diagnostics, tables,
// pictures. That it is right, other tests say; these notice when it changes.
#include "test/support/golden.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <regex>
#include <sstream>
#include <utility>

#include "daemon/commands/commands.h"
#include "daemon/health/pipeline_health.h"
#include "daemon/health/report.h"
#include "daemon/offline/survey.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/capture/pcap_source.h"
#include "test/daemon/pipeline/no_tf.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> shipped_captures() {
  std::vector<std::string> paths;
  for (const auto& entry : fs::directory_iterator(test::project_file("pcaps")))
    if (entry.path().extension() == ".pcap") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// A path for a file that is gone with its owner.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& end)
      : path(testing::TempDir() + "lidard-golden-" + fmt::format("{:05}", getpid() % 100000) + end) {}
  ~TemporaryFile() { std::remove(path.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string path;
};

/// Folders differ from machine to machine.
std::string without_folders(std::string text, const std::string& temporary = "") {
  if (!temporary.empty()) text = std::regex_replace(text, std::regex(temporary), "OUTPUT");
  return std::regex_replace(text, std::regex(test::project_file("")), "");
}

/// Sums up what a pipeline publishes, and the state in its diagnostics, not their values.
class SummedSink final : public DiagnosticSink {
 public:
  void publish(const OutputTopic& topic, const Frame& frame, Stamp released) override {
    note(topic, released);
    if (const PlanarScan* const scan = frame.scan())
      sums.scan(topic.name, *scan);
    else if (const Cloud* const cloud = frame.cloud())
      sums.cloud(topic.name, *cloud);
    else
      sums.message(topic.name, *std::get<const DeviceMessage*>(frame));
  }
  void diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) override {
    sums.add_exact("diagnostics", released.ns);
    for (const DiagnosticItem& item : items) {
      sums.add_exact("diagnostics of " + item.name, static_cast<int>(item.health));
      sums.add_text("diagnostics of " + item.name, item.message);
    }
  }
  test::Sums sums;

 private:
  void note(const OutputTopic& topic, Stamp released) {
    sums.add_exact(topic.name + " released", released.ns);
    sums.add_text("order", topic.name);
  }
};

std::string text_of(const std::vector<DiagnosticItem>& items, bool with_values) {
  constexpr const char* levels[] = {"OK", "WARN", "ERROR", "STALE"};
  std::string all;
  for (const DiagnosticItem& item : items) {
    all += "  " + std::string(levels[static_cast<std::size_t>(item.health)]) + " " + item.name + " [" +
           item.hardware_id + "] " + item.message + "\n";
    if (!with_values) continue;
    for (const auto& [key, value] : item.values) all += "    " + key + ": " + value + "\n";
  }
  return all;
}

/// Which packets come, and what happens beside them.
struct Day {
  const char* name;
  bool (*comes)(std::size_t number);
  bool drives;
};

const Day days[] = {
    {"a good day", [](std::size_t) { return true; }, false},
    {"a drive on which packets are lost", [](std::size_t n) { return n % 41 != 7 && n % 500 > 60; }, true}};

/// What a pipeline made of a capture.
struct Played {
  std::string sums, states, values, tables;
};

/// Plays a capture through a pipeline as `day` has it.
Played played(const std::string& path, const Config& config, const Day& day) {
  NoTf tf;
  SummedSink sink;
  Pipeline pipeline(config, tf, sink);
  const HealthReporter reporter(pipeline, sink);
  Stamp now{}, begin{};
  std::size_t number = 0;
  const auto pose_at = [](double t) { return make_pose({3 * t, 0.1 * t, 0}, {0, 0.02 * t, 0.5 * t}); };
  Packet packet;
  Played all;
  for (PcapSource source(path); source.next(packet); ++number) {
    now = packet.arrival;
    if (number == 0) begin = now;
    const double t = seconds(now - begin);
    if (day.drives && number % 20 == 0) pipeline.pose_message(now, pose_at(t), "", now);
    if (day.comes(number)) pipeline.packet(packet);
    pipeline.tick(now);
    if (number % 700 == 650) all.states += text_of(items_of(pipeline, now), false);
  }
  all.values = text_of(items_of(pipeline, now), true);
  pipeline.finish(now);
  std::ostringstream tables;
  print_table(pipeline.status(pipeline.now()).sensors, tables);
  print_verdicts(pipeline.status(pipeline.now()).sensors, tables);
  print_outputs("output", topic_totals(pipeline), tables);
  for (const std::string& sender : pipeline.unclaimed_senders()) tables << sender << '\n';
  for (const auto& fixed : pipeline.static_transforms())
    tables << fixed.parent << " -> " << fixed.child << '\n';
  all.tables = tables.str();
  for (const double later : {0.6, 2.1, 3.4, 12.0}) {
    pipeline.tick(now + span_from_seconds(later));
    const auto event = pipeline.next_event();
    all.states += "next " + std::to_string(event ? (*event - now).count() : -1) + "\n" +
                  text_of(items_of(pipeline, now + span_from_seconds(later)), false);
  }
  all.sums = sink.sums.digest(path + ", " + day.name);
  return all;
}

/// The demo vehicle with other outputs.
const std::pair<const char*, const char*> vehicles[] = {
    {"the demo vehicle as it is", ""},
    {"outputs with all that can be asked for",
     "  all: {laserscan_topics: [front_left, front_right], profile: strict, status_topic: "
     "known,\n"
     "    policy: rate, rate: 17, beams: 360, range_max: 20,\n"
     "    on_missing_motion: wait, destination_frame: out,\n"
     "    destination_pose: {xyz: [0.5, 0.1, 0.2], rpy_deg: [0, 0, 30]}}\n"
     "  triggered: {laserscan_topics: [front_left, front_right], profile: safety, policy: trigger,\n"
     "    trigger: front_right, angle_min_deg: -100, angle_max_deg: 80}\n"
     "virtual_scans:\n"
     "  sure: {cloud_topic: roof, virtual_laser_scan: [low, high], profile: strict, mode: band,\n"
     "    poses: {low: {xyz: [1, 0, 0.4]}, high: {xyz: [0, 0.3, 1.4], rpy_deg: [1, 2, 40]}},\n"
     "    min_height: -0.2, max_height: 0.3, ground: {model: plane, z: 0.0}, beams: 180, range_max: 30}\n"
     "  safe: {cloud_topic: roof, virtual_laser_scan: [middle], profile: safety, mode: slice, ground: "
     "{model: slope},\n"
     "    output_laser_topic: cut, poses: {middle: {xyz: [0, 0, 0.8]}}, beams: 240, range_max: 25}\n"},
};

std::string demo_with(const std::string& outputs) {
  std::string text = test::content(test::project_file("config/demo.yaml"));
  if (!outputs.empty()) {
    text.resize(text.find("virtual_scans:"));
    text = std::regex_replace(text, std::regex("base_frame: base_link  "),
                              "base_frame: base_link\n  odometry_topic: /odom  ");
    text += outputs;
  }
  return text;
}

/// The words of a text and its numbers, which may differ by rounding.
std::string summed(const std::string& title, const std::string& text, char between) {
  test::Sums sums;
  std::istringstream in(text);
  std::string cell;
  std::size_t number = 0;
  while (std::getline(in, cell, between)) {
    char* end = nullptr;
    const double value = std::strtod(cell.c_str(), &end);
    const bool is_number = end != cell.c_str() && cell.find('.') != std::string::npos;
    const std::string column = "cell " + std::to_string(number++ % 12);
    if (is_number)
      sums.add(column, value);
    else
      sums.add_text(column + " text", cell);
  }
  return sums.digest(title);
}

/// The same of a text for readers.
std::string summed(const std::string& title, const std::string& text) {
  return summed(title, std::regex_replace(text, std::regex("\n"), " "), ' ');
}

TEST(Golden, TheDemoVehiclePublishesAndSaysWhatItDidBefore) {
  std::string all;
  bool written_out = false;
  for (const auto& [name, outputs] : vehicles) {
    const Config config = parse_config(demo_with(outputs), "demo");
    for (const Day& day : days) {
      const Played demo = played(test::project_file("pcaps/demo.pcap"), config, day);
      all += std::string(name) + ", " + day.name + "\n" + demo.sums;
      // One of the four is written out, so that a reader sees what changed.
      const std::string rest = demo.values + demo.tables;
      all += written_out ? summed(name, rest) : rest;
      written_out = true;
      all += "  states " + test::checksum(demo.states) + "\n";
    }
  }
  test::expect_golden("daemon_demo.txt", all);
}

TEST(Golden, EveryShippedCaptureIsPublishedAsBefore) {
  std::string all;
  for (const std::string& path : shipped_captures()) {
    if (fs::path(path).filename() == "demo.pcap") continue;
    const Config config = parse_config(config_of(survey({path})), "found");
    for (const Day& day : days) {
      const Played capture = played(path, config, day);
      all += std::string(fs::path(path).filename()) + ", " + day.name + "\n" + capture.sums + "  states " +
             test::checksum(capture.states) + "\n" +
             (day.drives ? summed(path, capture.tables) : capture.tables);
    }
  }
  test::expect_golden("daemon_captures.txt", all);
}

/// What is said of a capture and its sensors; the configuration below it is in the JSON, too.
std::string remarks_of(const std::string& text) {
  std::istringstream lines(text.substr(0, text.find("# This output")));
  std::string all;
  for (std::string line; std::getline(lines, line);) all += line.compare(0, 2, "# ") == 0 ? line + "\n" : "";
  return all;
}

TEST(Golden, InspectSaysWhatItSaidBefore) {
  std::string all;
  for (const std::string& path : shipped_captures()) {
    for (const bool json : {false, true}) {
      std::ostringstream out, err;
      const int code = run_inspect({path}, json, out, err);
      all += "exit " + std::to_string(code) + "\n" +
             (json ? "JSON " + test::checksum(without_folders(out.str())) + "\n" : remarks_of(out.str())) +
             err.str();
    }
  }
  test::expect_golden("daemon_inspect.txt", without_folders(all));
}

TEST(Golden, DecodeWritesAndSaysWhatItDidBefore) {
  std::string all;
  std::size_t number = 0;
  for (const std::string& path : shipped_captures()) {
    ++number;
    std::string said;
    for (const char* format : {"csv", "json"}) {
      const TemporaryFile file("." + std::string(format));
      DecodeOptions options;
      options.capture = path;
      options.format = format;
      options.output = file.path;
      options.stamps = number % 3 == 0 ? StampColumn::device : StampColumn::host;
      // A frame of the big ones is enough.
      if (fs::file_size(path) > 100'000) options.frame = 1;
      std::ostringstream err;
      const int code = run_decode(options, err);
      // The same of both formats, but for the width of the file's name in a table.
      const std::string text =
          "exit " + std::to_string(code) + "\n" +
          std::regex_replace(without_folders(err.str(), file.path), std::regex(" {2,}"), "  ");
      if (std::exchange(said, text) != text) all += text;
      if (code == 0) all += summed(path + ", " + format, test::content(file.path), ',');
    }
  }
  test::expect_golden("daemon_decode.txt", all);
}

TEST(Golden, CheckPrintsTheExamplesAsBefore) {
  std::vector<std::string> paths;
  for (const auto& entry : fs::directory_iterator(test::project_file("config")))
    if (entry.path().extension() == ".yaml") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::string all;
  for (const std::string& path : paths) {
    std::ostringstream out, err;
    const int code = run_check(path, out, err);
    all += path + ": exit " + std::to_string(code) + "\n" + out.str() + err.str();
  }
  test::expect_golden("daemon_check.txt", without_folders(all));
}

TEST(Golden, AReplayWritesAndSaysWhatItDidBefore) {
  const TemporaryFile bag(".bag");
  ReplayOptions options;
  options.config = test::project_file("config/demo.yaml");
  options.captures = {test::project_file("pcaps/demo.pcap"), test::project_file("pcaps/vlp16_fov.pcap")};
  options.rate = 0;
  options.bag = bag.path;
  options.start = 0.3;
  options.duration = 1.1;
  std::ostringstream out, err;
  std::string all = "exit " + std::to_string(run_replay(options, out, err)) + "\n" + out.str() + err.str();
  test::Sums sums;
  rosbag::Bag file(bag.path);
  for (const rosbag::MessageInstance& message : rosbag::View(file)) {
    const std::string topic = message.getTopic();
    sums.add_exact(topic + " time", static_cast<std::int64_t>(message.getTime().toNSec()));
    sums.add_text(topic + " type", message.getDataType());
    sums.add_exact(topic + " size", message.size());
    if (const auto scan = message.instantiate<sensor_msgs::LaserScan>()) {
      sums.add_exact(topic + " stamp", static_cast<std::int64_t>(scan->header.stamp.toNSec()));
      sums.add_text(topic + " frame", scan->header.frame_id);
      sums.add_all(topic + " head",
                   {scan->angle_min, scan->angle_max, scan->range_min, scan->range_max, scan->scan_time});
      sums.add_all(topic + " ranges", scan->ranges);
      sums.add_all(topic + " intensities", scan->intensities);
      continue;
    }
    std::vector<std::uint8_t> bytes(message.size());
    ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    message.write(stream);
    sums.add_text(topic + " bytes", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  test::expect_golden("daemon_replay.txt", without_folders(all + sums.text(), bag.path));
}

}  // namespace
}  // namespace lidard
