// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A cloud's stamp is its earliest firing: no point is older. The packet's own stamp may stand behind it: 7 us
// or 8.7 us in a VLS-128 (UniBwTAS/velodyne; draft manual 63-9483), a whole packet in an old HDL-32E (its
// manual, p. 27).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/frames/cloud_layout.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/calibration.h"
#include "test/support/captures.h"
#include "test/support/collector.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using test::WirePacket;

/// Looks at the times of each cloud, as the driver makes it and in every layout of messages.
class Times final : public FrameReceiver {
 public:
  void scan(PlanarScan&) override { ADD_FAILURE() << "a scan of a Velodyne"; }
  void cloud(Cloud& cloud) override {
    ++clouds;
    expect_points(cloud);
    for (const CloudOrder order : {CloudOrder::list, CloudOrder::ring_rows, CloudOrder::firing_rows}) {
      for (const FrameStamp stamp : {FrameStamp::first, FrameStamp::last}) expect_layout(cloud, order, stamp);
    }
  }
  std::size_t clouds = 0;
  float earliest = 1e9F;          // of all points
  double worst_disagreement = 0;  // s, between a point's time and its place in its packet

 private:
  void expect_points(const Cloud& cloud) {
    float first = 1e9F;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const float time = cloud.points()[i].time;
      ASSERT_GE(time, 0) << "point " << i;
      first = std::min(first, time);
      if (cloud.origins.empty()) continue;
      const double firing = seconds(cloud.origins[i].stamp - cloud.stamp);
      worst_disagreement = std::max(worst_disagreement, std::fabs(time - firing));
    }
    earliest = std::min(earliest, first);
  }
  static void expect_layout(const Cloud& cloud, CloudOrder order, FrameStamp stamp) {
    CloudArranger arranger({order, stamp});
    const Cloud& arranged = arranger.arrange(cloud);
    for (std::size_t i = 0; i < arranged.size(); ++i) {
      const float time = arranged.points()[i].time;
      ASSERT_TRUE(stamp == FrameStamp::first ? time >= 0 : time <= 0) << time << " of point " << i;
    }
  }
};

DriverConfig stamp_config_of(const std::string& model) {
  DriverConfig config;
  config.model = find_model(model);
  config.cut_angle = 1;
  config.keep_partial = config.keep_origins = true;
  return config;
}

/// Arrivals of a simulated stream are exact, so that the host's time agrees with the device's to the stamps'
/// microsecond, and every firing of it comes back.
void expect_times(const test::ModelMode& which, const sim::VelodyneOptions& options, bool calibrated) {
  const auto packets = test::spin(which, 1.7, options);
  DriverConfig config = stamp_config_of(which.model);
  if (calibrated) config.calibration = std::make_shared<Calibration>(table_calibration(*config.model));
  const auto driver = config.model->make(config);
  Times times;
  for (const WirePacket& packet : packets) give(*driver, packet, times);
  driver->finish(times);
  EXPECT_GT(times.clouds, 1U);
  EXPECT_EQ(times.earliest, 0) << "the stamp is no firing";
  EXPECT_LT(times.worst_disagreement, 2.5e-6);
}

TEST(VelodyneStamp, IsTheEarliestFiringForEveryModelModeAndCalibration) {
  for (const test::ModelMode& which : test::model_modes()) {
    for (const bool has_view : {false, true}) {
      SCOPED_TRACE(which.name() + (has_view ? " with a view" : ""));
      sim::VelodyneOptions options;
      options.rest_spread_ns = 0;
      if (has_view) options.fov = sim::AzimuthSector{270, 90};
      if (has_view && which.model == "velodyne_hdl64e_s1") continue;  // no field of view is known
      expect_times(which, options, has_view);
    }
  }
  sim::VelodyneOptions old;
  old.old_stamp = true;
  SCOPED_TRACE("an HDL-32E that stamps the end of the packet");
  expect_times({"velodyne_hdl32e", sim::ReturnMode::strongest, ""}, old, false);
}

/// With the random rest of a VLS-128 and with the clocks that the simulated vehicle has.
TEST(VelodyneStamp, IsTheEarliestFiringInEveryShippedCapture) {
  std::size_t captures = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::project_file("pcaps"))) {
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() != ".pcap") continue;
    for (const Model& model : models()) {
      const std::string product = std::string(model.name).substr(model.name.find('_') + 1);
      if (model.vendor != "Velodyne" || stem.substr(0, product.size()) != product) continue;
      ++captures;
      SCOPED_TRACE(stem);
      const test::Decoded decoded = test::decode_capture(entry.path().string(), std::string(model.name),
                                                         stamp_config_of(std::string(model.name)));
      Times times;
      for (Cloud cloud : decoded.output.clouds) times.cloud(cloud);
      EXPECT_GT(times.clouds, 0U);
    }
  }
  EXPECT_GE(captures, 25U);
}

TEST(VelodyneStamp, IsTheEarliestFiringInRecordings) {
  const std::pair<const char*, const char*> recordings[] = {
      {"vlp16_strongest_1000", "velodyne_vlp16"}, {"vlp16_dual_1500", "velodyne_vlp16"},
      {"hdl32e_2011_port443", "velodyne_hdl32e"}, {"hdl32e_gprmc_876", "velodyne_hdl32e"},
      {"vlp32c_fov_379", "velodyne_vlp32c"},      {"vls128_strongest_2193", "velodyne_vls128"}};
  for (const auto& [name, model] : recordings) {
    LIDARD_NEED_CAPTURE(path, std::string("velodyne/") + name + ".pcap");
    SCOPED_TRACE(name);
    const test::Decoded decoded = test::decode_capture(path, model, stamp_config_of(model));
    Times times;
    for (Cloud cloud : decoded.output.clouds) times.cloud(cloud);
    EXPECT_GT(times.clouds, 1U);
  }
}

}  // namespace
}  // namespace lidard
