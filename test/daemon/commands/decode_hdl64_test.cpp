// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <tuple>

#include "daemon/commands/commands.h"
#include "test/sim/servers/capture.h"
#include "test/sim/servers/velodyne_stream.h"

namespace lidard {
namespace {

struct Point {
  double x, y, z;
  long frame;
};
using Points = std::map<std::tuple<long, long, long>, Point>;  // by packet, block, laser

Points decode(const std::string& capture, const char* model) {
  DecodeOptions options;
  options.capture = capture;
  options.model = model;
  options.output = capture + ".csv";
  std::ostringstream err;
  EXPECT_EQ(run_decode(options, err), 0) << err.str();
  EXPECT_NE(err.str().find("rejected 0, lost 0"), std::string::npos) << err.str();
  std::ifstream csv(options.output);
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line,
            "frame,packet,block,laser,ring,return,stamp_ns,azimuth_deg,distance_m,x_m,y_m,z_m,intensity");
  Points points;
  while (std::getline(csv, line)) {
    std::istringstream fields(line);
    std::vector<double> values;
    for (std::string field; std::getline(fields, field, ',');) values.push_back(std::stod(field));
    points[{std::lround(values.at(1)), std::lround(values[2]), std::lround(values[3])}] = {
        values.at(9), values.at(10), values.at(11), std::lround(values[0])};
  }
  return points;
}

double distance(const Point& a, const Point& b) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

TEST(DecodeHdl64, UsesTheCalibrationInTheStreamAsSoonAsItIsWhole) {
  const std::string prefix = testing::TempDir() + "decode_hdl64_" + std::to_string(getpid());
  sim::VelodyneSetup setup;
  setup.model = "velodyne_hdl64e_s3";
  setup.range_max = 2.6;  // the nearest poles: enough
  setup.duration = std::chrono::milliseconds(1700);
  sim::make_capture(velodyne_room(setup), prefix, false);
  // The simulator's lasers are those of the S3's table; as an S2.1 they are placed by another unit's.
  const Points right = decode(prefix + ".pcap", "velodyne_hdl64e_s3");
  const Points learnt = decode(prefix + ".pcap", "velodyne_hdl64e_s21");
  for (const char* made : {".pcap", ".pcap.csv", ".truth"}) std::remove((prefix + made).c_str());
  ASSERT_EQ(right.size(), learnt.size());
  constexpr long round_packets = 4160;
  double before = 0;
  double after = 0;
  long first_frame = 0;
  std::size_t compared = 0;
  for (const auto& [place, point] : learnt) {
    const long packet = std::get<0>(place);
    if (packet < round_packets) {
      before = std::max(before, distance(point, right.at(place)));
      first_frame = point.frame;
    } else if (point.frame > first_frame + 1) {
      after = std::max(after, distance(point, right.at(place)));
      ++compared;
    }
  }
  EXPECT_GT(before, 0.05);
  EXPECT_GT(compared, 1000U);
  EXPECT_LT(after, 1e-4);
}

}  // namespace
}  // namespace lidard
