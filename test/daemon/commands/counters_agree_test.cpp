// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// inspect, decode and replay tell the same packets, frames, losses and rejects of a file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "daemon/commands/commands.h"
#include "daemon/config/config.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using Json = nlohmann::json;

struct Told {
  std::uint64_t packets, frames, partial, lost, rejected;
};

bool operator==(const Told& a, const Told& b) {
  return a.packets == b.packets && a.frames == b.frames && a.partial == b.partial && a.lost == b.lost &&
         a.rejected == b.rejected;
}
std::ostream& operator<<(std::ostream& out, const Told& told) {
  return out << told.packets << " packets, " << told.frames << " frames, " << told.partial << " partial, "
             << told.lost << " lost, " << told.rejected << " rejected";
}

Told by_inspect(const Json& sensor) {
  std::uint64_t rejected = 0;
  for (const auto& each : sensor["rejected"]) rejected += each.get<std::uint64_t>();
  return {sensor["data_packets"], sensor["frames"], sensor["partial_frames"], sensor["lost_packets"],
          rejected};
}

/// The row of a sensor in the table that a replay ends with.
Told by_replay(const std::string& table, const std::string& name) {
  const std::regex row("(?:^|\n)" + name + R"( +\S+ +(\d+) +(\d+) +\S+ +\S+ +(\d+) +(\d+)  (\d+))");
  std::smatch found;
  if (!std::regex_search(table, found, row)) return {};
  const auto number = [&](std::size_t i) { return std::stoull(found[i]); };
  return {number(1), number(2), number(3), number(4), number(5)};
}

/// What decode says at its end. It hands out partial frames too, and says how many of its frames are.
Told by_decode(const std::string& text) {
  const std::regex numbers(
      R"(: (\d+) frames, \d+ returns\n  packets (\d+), rejected (\d+)[^\n]*, lost (\d+)\n)");
  std::smatch found;
  if (!std::regex_search(text, found, numbers)) return {};
  const auto number = [&](std::size_t i) { return std::stoull(found[i]); };
  return {number(2), number(1), 0, number(4), number(3)};
}

std::string replay(const std::string& capture, const std::string& yaml) {
  ReplayOptions options;
  options.captures = {capture};
  options.rate = 0;
  options.bag = testing::TempDir() + "counters_agree_" + std::to_string(getpid()) + ".bag";
  std::ostringstream out, err;
  static_cast<void>(run_replay(options, parse_config(yaml, "inspected"), out, err));
  std::remove(options.bag.c_str());
  return out.str();
}

std::string decode(const std::string& capture, const Json& sensor) {
  DecodeOptions options;
  options.capture = capture;
  options.model = sensor["model"];
  options.source = IpAddress::parse(sensor["sender"].get<std::string>());
  options.port = sensor["port"];
  options.output = "/dev/null";
  std::ostringstream err;
  static_cast<void>(run_decode(options, err));
  return err.str();
}

/// Number of sensors compared.
std::size_t compare(const std::string& capture) {
  SCOPED_TRACE(capture);
  std::ostringstream out, err;
  static_cast<void>(run_inspect({capture}, true, out, err));
  const Json said = Json::parse(out.str());
  if (said["sensors"].empty()) return 0;
  const std::string table = replay(capture, said["config"]);
  for (const Json& sensor : said["sensors"]) {
    const Told inspected = by_inspect(sensor);
    EXPECT_EQ(by_replay(table, sensor["name"]), inspected) << sensor["name"] << '\n' << table;
    const std::string text = decode(capture, sensor);
    Told decoded = by_decode(text);
    EXPECT_GE(decoded.frames, inspected.frames) << text;
    EXPECT_LE(decoded.frames, inspected.frames + inspected.partial) << text;
    decoded.frames = inspected.frames;
    decoded.partial = inspected.partial;
    EXPECT_EQ(decoded, inspected) << sensor["name"] << '\n' << text;
  }
  return said["sensors"].size();
}

bool is_capture(const std::filesystem::path& path) {
  return path.extension() == ".pcap" || path.extension() == ".pcapng";
}

std::size_t compare_all(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && is_capture(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::size_t sensors = 0;
  for (const std::string& file : files) sensors += compare(file);
  return sensors;
}

TEST(CountersAgree, OnEveryCaptureOfTheVirtualVehicle) { EXPECT_GE(compare_all(project_file("pcaps")), 40U); }

TEST(CountersAgree, OnEveryRecordedCapture) {
  for (const std::string folder : {"burst", "hokuyo", "odd", "sick", "velodyne"}) {
    LIDARD_NEED_CAPTURE(path, folder);
    const std::size_t sensors = compare_all(path);
    if (folder == "sick") {
      EXPECT_GE(sensors, 12U) << "all but a radar";
    }
  }
}

}  // namespace
}  // namespace lidard::test
