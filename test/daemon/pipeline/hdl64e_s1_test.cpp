// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "daemon/offline/choice.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

// A real HDL-64E S1, with the calibration of the very sensor and one frame as the publisher took it from
// VeloView (chalmers-revere/opendlv.core, proxy-velodyne64/testsuites).
constexpr const char* capture = "velodyne/hdl64e_s1_atwall_306.pcap";
constexpr const char* frame = "velodyne/hdl64e_s1_atwall_306.veloview.csv.gz";
constexpr const char* calibration = "calibration/hdl64e_s1_atwall.db.xml";

using Point = std::array<double, 4>;  // x, y, z, intensity

/// VeloView counts x to the right and y ahead.
std::vector<Point> published(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> unpacked(
      ::popen(("gzip -dc '" + path + "'").c_str(), "r"), &::pclose);
  std::vector<Point> points;
  std::array<char, 256> line{};
  while (std::fgets(line.data(), line.size(), unpacked.get()) != nullptr) {
    double right = 0, ahead = 0, up = 0, intensity = 0;
    if (std::sscanf(line.data(), "%lf,%lf,%lf,%lf", &right, &ahead, &up, &intensity) == 4)
      points.push_back({ahead, -right, up, intensity});
  }
  return points;
}

Decoded decode(const std::string& path, const std::string& calibration_path) {
  DriverConfig config;
  config.keep_partial = config.keep_origins = true;
  const Model* model = find_model("velodyne_hdl64e_s1");
  if (!calibration_path.empty()) {
    std::vector<std::string> warnings;
    auto loaded = std::make_shared<Calibration>(load_calibration(calibration_path, warnings));
    loaded->model = usual_equations(*loaded, *model);
    config.calibration = std::move(loaded);
  }
  return decode_capture(path, "velodyne_hdl64e_s1", config);
}

TEST(Hdl64eS1, WithTheCalibrationOfTheSensorAWholeTurnIsThePublishedFrame) {
  LIDARD_NEED_CAPTURE(path, capture);
  LIDARD_NEED_CAPTURE(frame_path, frame);
  LIDARD_NEED_CAPTURE(calibration_path, calibration);
  const auto truth = published(frame_path);
  ASSERT_EQ(truth.size(), 89105U);
  const Decoded decoded = decode(path, calibration_path);
  std::vector<Point> points;
  for (const Row& row : decoded.output.rows) {
    if (row.frame == 1) points.push_back({row.x, row.y, row.z, row.intensity});
  }
  ASSERT_EQ(points.size(), truth.size());
  double worst_m = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      worst_m = std::max(worst_m, std::abs(points[i][axis] - truth[i][axis]));
    ASSERT_EQ(points[i][3], truth[i][3]) << i;
  }
  EXPECT_LT(worst_m, 1e-4);
}

TEST(Hdl64eS1, EveryReturnOfTheCaptureComesOutAndNothingIsLostOrRejected) {
  LIDARD_NEED_CAPTURE(path, capture);
  const Decoded decoded = decode(path, "");
  // Distances above 0 in the 306 whole packets, counted in their payloads without this decoder; a 307th is
  // cut by the end of the file.
  EXPECT_EQ(decoded.output.rows.size(), 104661U);
  EXPECT_EQ(decoded.counters.packets, 306U);
  EXPECT_EQ(decoded.counters.rejected_total(), 0U);
  EXPECT_EQ(decoded.counters.lost_packets, 0U);
  ASSERT_EQ(decoded.output.clouds.size(), 3U);
  EXPECT_FALSE(decoded.output.clouds[0].complete);
  EXPECT_TRUE(decoded.output.clouds[1].complete);
  ASSERT_EQ(decoded.info.warnings.size(), 1U);
  EXPECT_NE(decoded.info.warnings[0].find("`calibration`"), std::string::npos);
}

TEST(Hdl64eS1, TimesFollowTheArrivalsAndTheFiringsEachOther) {
  LIDARD_NEED_CAPTURE(path, capture);
  const Decoded decoded = decode(path, "");
  const Cloud& turn = decoded.output.clouds.at(1);
  // 360 deg at the 592.7 rpm of a line through azimuths and arrivals.
  EXPECT_NEAR(seconds(turn.end - turn.stamp), 60 / 592.7, 1e-4);
  double last_s = 0;
  std::pair<std::uint32_t, int> last_block{0, -1};
  std::size_t blocks = 0;
  for (const Row& row : decoded.output.rows) {
    if (row.frame != 1 || std::pair(row.packet, row.block) == last_block) continue;
    const double begin_s = row.time - row.laser % 32 * 1e-6;
    // Whole microseconds of a packet's stamp; the stamps follow the arrivals by 1.6 us at most.
    if (blocks++ > 0) {
      EXPECT_NEAR(begin_s - last_s, 32e-6, 3e-6) << row.packet;
    }
    last_s = begin_s;
    last_block = {row.packet, row.block};
  }
  EXPECT_EQ(blocks, turn.columns.size());
}

}  // namespace
}  // namespace lidard::test
