// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A recorded MRS1104 beside the clouds that SICK's own driver (sick_scan_xd) published of it: of 12 rows
// (four planes from the lowest up, three echoes of each) every fifth column.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

/// Telegram, beam and echo of a return.
using Place = std::tuple<std::size_t, std::size_t, std::size_t>;

std::map<Place, Row> by_place(const Decoded& got) {
  std::map<Place, Row> rows;
  for (const Row& row : got.output.rows) {
    const auto beam = static_cast<std::size_t>(std::lround((row.azimuth_deg + 47.5) / 0.25));
    rows[{row.packet, beam, static_cast<std::size_t>(row.echo)}] = row;
  }
  return rows;
}

/// The telegrams that SICK's driver put into its clouds, by plane from the lowest up. Planes follow each
/// other as -2.5, 5, 0, 2.5 deg, and its clouds begin with the plane at 0 deg, so that the first lacks two.
constexpr std::size_t none = 1000;
constexpr std::size_t telegrams[3][4] = {{0, none, none, 1}, {4, 2, 3, 5}, {8, 6, 7, 9}};

TEST(Mrs1000Capture, PointsAndEchoesEqualTheCloudsOfTheVendorsDriver) {
  LIDARD_NEED_CAPTURE(path, "sick/mrs1000_test01.pcap");
  LIDARD_NEED_CAPTURE(truth_path, "sick/mrs1000_test01_clouds.jsonl");
  DriverConfig config;
  config.keep_origins = true;
  config.keep_partial = true;
  const Decoded got = decode_capture(path, "sick_mrs1000", config);
  EXPECT_EQ(got.counters.rejected_total(), 1U) << "a sample of the inertial unit that came twice";
  const std::map<Place, Row> rows = by_place(got);
  ASSERT_EQ(rows.size(), got.output.rows.size()) << "two returns at one place";
  std::ifstream file(truth_path);
  std::size_t points = 0, second_echoes = 0, clouds = 0;
  for (std::string line; std::getline(file, line); ++clouds) {
    const auto truth = nlohmann::json::parse(line);
    ASSERT_LT(clouds, 3U);
    ASSERT_EQ(truth["rows"].size(), 12U);
    for (std::size_t r = 0; r < 12; ++r) {
      const std::size_t telegram = telegrams[clouds][r % 4];
      for (const auto& point : truth["rows"][r]) {
        const double x = point[1], y = point[2], z = point[3];
        const auto found = rows.find({telegram, point[0].get<std::size_t>(), r / 4});
        const bool is_point = x != 0 || y != 0 || z != 0;
        ASSERT_EQ(found != rows.end(), is_point)
            << "cloud " << clouds << " row " << r << " column " << point[0];
        if (!is_point) continue;
        ++points;
        second_echoes += r / 4 == 1 ? 1U : 0U;
        const Row& row = found->second;
        EXPECT_EQ(row.ring, static_cast<int>(r % 4));
        EXPECT_NEAR(row.x, x, 0.0002);
        EXPECT_NEAR(row.y, y, 0.0002);
        EXPECT_NEAR(row.z, z, 0.0002);
        EXPECT_EQ(row.intensity, point[4].get<double>());
      }
    }
  }
  EXPECT_EQ(clouds, 3U);
  // Counted in the file of the clouds by another program.
  EXPECT_EQ(points, 1974U);
  EXPECT_EQ(second_echoes, 149U);
}

/// 43 telegrams; how many values of DIST1, DIST2 and DIST3 are distances was counted by another program.
TEST(Mrs1000Capture, EveryEchoOfEveryTelegramComesOut) {
  LIDARD_NEED_CAPTURE(path, "sick/mrs1000_test01.pcap");
  DriverConfig config;
  config.keep_origins = true;
  config.keep_partial = true;
  const Decoded got = decode_capture(path, "sick_mrs1000", config);
  std::map<int, std::size_t> echoes;
  for (const Row& row : got.output.rows) ++echoes[row.echo];
  EXPECT_EQ(echoes[0], 39139U);
  EXPECT_EQ(echoes[1], 3107U);
  EXPECT_EQ(echoes[2], 0U);
}

// At rest: the acceleration is that of gravity, and the rotation that the unit tells turns it upright. The
// samples come every 10 ms; the values of the first were read from its bytes.
TEST(Mrs1000Capture, TheInertialUnitTellsWhatIsUp) {
  LIDARD_NEED_CAPTURE(path, "sick/mrs1000_test01.pcap");
  DriverConfig config;
  config.model = find_model("sick_mrs1000");
  config.frame_id = "mrs";
  ASSERT_TRUE(config.model->sends<ImuSample>());
  const auto driver = config.model->make(config);
  Collector out;
  PcapSource source(path);
  std::vector<Stamp> arrivals;
  for (Packet packet; source.next(packet);) {
    if (packet.from.port != 2112) continue;
    driver->receive(packet, out);
    arrivals.resize(out.imus.size(), packet.arrival);
  }
  ASSERT_EQ(out.imus.size(), 86U);
  EXPECT_EQ(driver->counters().rejected[static_cast<std::size_t>(Reject::duplicate)], 1U) << "one came twice";
  EXPECT_EQ(driver->counters().rejected_total(), 1U);
  const ImuSample& first = out.imus.front();
  EXPECT_EQ(first.frame_id, "mrs");
  EXPECT_NEAR((first.linear_acceleration - Eigen::Vector3d(-0.1771763, 0.1592193, 9.8464546)).norm(), 0,
              1e-5);
  EXPECT_NEAR((first.angular_velocity - Eigen::Vector3d(-0.0031959, 0.0031959, 0)).norm(), 0, 1e-6);
  for (std::size_t i = 0; i < out.imus.size(); ++i) {
    const ImuSample& sample = out.imus[i];
    EXPECT_NEAR(sample.linear_acceleration.norm(), 9.81, 0.2);
    ASSERT_TRUE(sample.orientation);
    EXPECT_GT((*sample.orientation * sample.linear_acceleration.normalized()).z(), 0.999);
    EXPECT_LE(sample.stamp, arrivals[i]);
    EXPECT_LT(seconds(arrivals[i] - sample.stamp), 0.03);
    if (i <= 3) continue;
    EXPECT_NEAR(seconds(sample.stamp - out.imus[i - 1].stamp), 0.01, 0.002) << i;
  }
}

}  // namespace
}  // namespace lidard::test
