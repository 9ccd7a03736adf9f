// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The lower and the upper limit of each kind of number: what lies on them is taken, what lies beyond is
// refused at its place. The limits of all keys stand in config/KEYS.md.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using test::error_of;
using testing::HasSubstr;

/// A number of the configuration. `text` is the configuration with % where `key: number` goes, which is in
/// `line`; a limit that is empty is none (another rule holds there, or there is no limit).
struct Limit {
  const char* name;
  std::string text;
  int line;
  std::string key;
  std::string lowest, below, highest, above;
};

std::string sensor_of(const std::string& model, const std::string& more = "") {
  return "sensors:\n  s:\n    {model: " + model + ", ip_address: 10.0.0.9" + more + ", %}\n";
}
const std::string sources =
    "sensors: {a: {topic: /a, pose: {xyz: [0, 0, 0]}}, roof: {model: velodyne_vlp16}}\n";
std::string merged_with(const std::string& more = "") {
  return sources + "merged_scans:\n  m: {laserscan_topics: a" + more + ", %}\n";
}
std::string control(const std::string& more = "") {
  return "sensors:\n  s:\n    {model: velodyne_vlp16, ip_address: 10.0.0.9, control: {" + more + "%}}\n";
}

const std::vector<Limit>& limits() {
  static const std::vector<Limit> all{
      {"udp port", sensor_of("velodyne_vlp16"), 3, "ip_port", "1", "0", "65535", "65536"},
      {"skip", sensor_of("hokuyo_ust_10lx"), 3, "skip", "0", "-1", "9", "10"},
      {"min range", sensor_of("velodyne_vlp16"), 3, "min_range", "0", "-0.001", "1000", "1000.1"},
      {"cut angle", sensor_of("velodyne_vlp16"), 3, "cut_angle", "-6.28", "-6.2841", "6.28", "6.2841"},
      {"cut angle in degrees", sensor_of("velodyne_vlp16"), 3, "cut_angle_deg", "-400", "-400.1", "400",
       "400.1"},
      {"view direction", sensor_of("velodyne_vlp16"), 3, "view_direction", "-6.2831", "-6.2832", "6.2831",
       "6.2832"},
      {"view width", sensor_of("velodyne_vlp16"), 3, "view_width", "0.0001", "0", "6.2831853", "6.2832"},
      {"ring", sensor_of("velodyne_vlp16"), 3, "scan_ring", "0", "", "15", "16"},
      {"ring of a VLP-32", sensor_of("velodyne_vlp32c"), 3, "scan_ring", "0", "-2", "31", "32"},
      {"ring resolution", sensor_of("velodyne_vlp16", ", scan_ring: 7"), 3, "scan_resolution", "0.0005",
       "0.00049", "0.2", "0.2001"},
      {"control rpm step", control("allow_write: true, "), 3, "rpm", "360", "359", "1140", "1141"},
      {"pose", "sensors:\n  a: {topic: /a, pose: {%, rpy: [0, 0, 0]}}\n", 2, "xyz", "[-1000, 0, 0]",
       "[-1000.1, 0, 0]", "[0, 0, 1000]", "[0, 0, 1000.1]"},
      {"turn of a pose", "sensors:\n  a: {topic: /a, pose: {xyz: [0, 0, 0], %}}\n", 2, "rpy",
       "[-6.284, 0, 0]", "[-6.29, 0, 0]", "[0, 0, 6.284]", "[0, 0, 6.29]"},
      {"turn of a pose in degrees", "sensors:\n  a: {topic: /a, pose: {xyz: [0, 0, 0], %}}\n", 2, "rpy_deg",
       "[-400, 0, 0]", "[-400.1, 0, 0]", "[0, 400, 0]", "[0, 400.1, 0]"},
      {"outline", "vehicle:\n  {%}\n" + sources, 2, "footprint", "[[-1000, -1], [1, -1], [0, 1]]",
       "[[-1000.1, -1], [1, -1], [0, 1]]", "[[-1, -1], [1000, -1], [0, 1]]",
       "[[-1, -1], [1000.1, -1], [0, 1]]"},
      {"range_max", merged_with(", range_min: 0"), 3, "range_max", "0.001", "0", "10000", "10000.1"},
      {"heights", merged_with(", min_height: 1"), 3, "max_height", "1.001", "1", "", ""},
      {"free_required", merged_with(", range_max: 20"), 3, "free_required", "0.1", "0.099", "20", "20.001"},
  };
  return all;
}

std::string with(const Limit& limit, const std::string& value) {
  std::string text = limit.text;
  return text.replace(text.find('%'), 1, limit.key + ": " + value);
}

class ConfigLimits : public testing::TestWithParam<Limit> {};

TEST_P(ConfigLimits, TakeWhatLiesOnThemAndRefuseWhatLiesBeyondAtItsPlace) {
  const Limit& limit = GetParam();
  for (const std::string& good : {limit.lowest, limit.highest}) {
    if (good.empty()) continue;
    EXPECT_EQ(error_of(with(limit, good)), "no error") << limit.key << ": " << good;
  }
  for (const std::string& bad : {limit.below, limit.above}) {
    if (bad.empty()) continue;
    const std::string error = error_of(with(limit, bad));
    EXPECT_THAT(error, testing::StartsWith("f:" + std::to_string(limit.line) + ":")) << bad;
    EXPECT_THAT(error, HasSubstr(limit.key)) << bad;
    EXPECT_THAT(error, HasSubstr("; expected ")) << bad;
  }
}

TEST_P(ConfigLimits, NoNumberIsOneThatIsNotFiniteOrAWord) {
  const Limit& limit = GetParam();
  if (limit.lowest.front() == '[') return;  // a list
  for (const char* bad : {".nan", ".inf", "-.inf", "much", "1m", "0x10", "[1]", "{}", "''"}) {
    const std::string error = error_of(with(limit, bad));
    EXPECT_THAT(error, testing::StartsWith("f:" + std::to_string(limit.line) + ":"))
        << limit.key << ": " << bad;
    EXPECT_THAT(error, HasSubstr(limit.key)) << bad;
  }
}

INSTANTIATE_TEST_SUITE_P(Config, ConfigLimits, testing::ValuesIn(limits()), [](const auto& each) {
  std::string name = each.param.name;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
});

}  // namespace
}  // namespace lidard
