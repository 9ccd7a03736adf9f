// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause

#include "drivers/hokuyo/models.h"
#include "drivers/hokuyo/uam_frame.h"
#include "drivers/registry/identifier.h"
#include "drivers/registry/registry.h"
#include "test/drivers/hokuyo/scip_bench.h"
#include "test/sim/devices/uam_device.h"

namespace lidard::test {
namespace {

using namespace std::chrono_literals;
using hokuyo::uam_crc;
using sim::UamDeviceOptions;

/// A wall 1 m away and 1 mm more per beam.
std::vector<sim::UamBeam> uam_wall(std::size_t beams) {
  std::vector<sim::UamBeam> wall;
  for (std::size_t i = 0; i < beams; ++i)
    wall.push_back({static_cast<std::uint16_t>(1000 + i), static_cast<std::uint16_t>(3 * i)});
  return wall;
}

class UamBench : public TcpBench {
 public:
  explicit UamBench(UamDeviceOptions options = {}, DriverConfig config = {},
                    const std::string& model = "hokuyo_uam_05lp")
      : TcpBench(model, std::move(config)),
        sensor(
            std::move(options),
            [this](Stamp, std::size_t beams) { return wall.empty() ? uam_wall(beams) : wall; }, now - 100s) {
    device = &sensor;
  }
  double value(const std::string& name) const {
    for (const DeviceValue& each : states.back().values) {
      if (each.name == name) return each.value;
    }
    ADD_FAILURE() << "no " << name;
    return -1;
  }

  std::vector<sim::UamBeam> wall;
  sim::UamDevice sensor;
};

std::string stream_of(UamDeviceOptions options, const std::string& command, Span time) {
  sim::UamDevice device(
      std::move(options), [](Stamp, std::size_t beams) { return uam_wall(beams); }, scip_epoch - 100s);
  device.connected(scip_epoch);
  device.receive(hokuyo::uam_request(command), scip_epoch);
  std::string all;
  while (const auto sent = device.next(scip_epoch + time)) all += sent->bytes;
  return all;
}

TEST(Uam, ChecksumsAreThoseOfKnownRequests) {
  EXPECT_EQ(uam_crc("000EAR00"), 0xA012);
  EXPECT_EQ(uam_crc("000EAR01"), 0xB19B);
  EXPECT_EQ(uam_crc("000EAR02"), 0x8300);
  EXPECT_EQ(uam_crc("000EAR03"), 0x9289);
  EXPECT_EQ(uam_crc("000EAR04"), 0xE636);
  EXPECT_EQ(uam_crc("000EVR00"), 0x3492);
  EXPECT_EQ(uam_crc("000EDL00"), 0x5BCB);
  EXPECT_EQ(hokuyo::uam_request("AR00"),
            "\x02"
            "000EAR00A012\x03");
  EXPECT_EQ(sim::uam_checksum("000EAR04"), 0xE636);
}

TEST(Uam, FramesHaveTheLengthsThatAreKnown) {
  const auto longest = [](const std::string& stream) {
    Counters counters;
    hokuyo::UamReader reader(counters);
    reader.add(ByteView(stream));
    std::size_t length = 0;
    for (hokuyo::UamFrame frame; reader.next(frame);) length = std::max(length, frame.text.size());
    return length;
  };
  EXPECT_EQ(longest(stream_of({}, "AR02", 100ms)), 4379U);
  EXPECT_EQ(longest(stream_of({}, "AR04", 100ms)), 8703U);
  EXPECT_EQ(longest(stream_of({}, "AR07", 100ms)), 8699U);
}

TEST(Uam, WritesExactlyWhatAStreamNeeds) {
  UamBench bench;
  bench.run(3s);
  EXPECT_EQ(bench.written, hokuyo::uam_request("VR00") + hokuyo::uam_request("AR02"));
  EXPECT_NEAR(static_cast<double>(bench.scans.size()), 99, 2);
  EXPECT_EQ(bench.driver->info().serial, "H7001234");
  EXPECT_EQ(bench.detail("Product Name"), "UAM-05LP-T301");
  EXPECT_EQ(bench.detail("Firmware Version"), "2.1.0");
  EXPECT_EQ(bench.driver->counters().rejected_total(), 0U);
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(Uam, DistancesAnglesAndCodesAreRead) {
  UamBench bench;
  bench.wall = uam_wall(1081);
  bench.wall[3].distance = 0xffff;
  bench.wall[4].distance = 0xfffe;
  bench.wall[5].distance = 0xfffd;
  bench.wall[6].distance = 0xfffc;
  bench.wall[7].distance = 40000;
  bench.wall[8].distance = 0;
  bench.run(1s);
  ASSERT_FALSE(bench.scans.empty());
  const PlanarScan& scan = bench.scans[0];
  EXPECT_EQ(scan.beams, 1081U);
  EXPECT_NEAR(scan.angle_min, -0.75 * 3.14159265358979, 1e-6);
  EXPECT_NEAR(scan.angle_max, 0.75 * 3.14159265358979, 1e-5);
  EXPECT_FLOAT_EQ(scan.ranges[0], 1.0F);
  EXPECT_FLOAT_EQ(scan.ranges[1080], 2.08F);
  EXPECT_TRUE(scan.intensities.empty());
  EXPECT_EQ(scan.statuses[3], BeamStatus::invalid);
  EXPECT_EQ(scan.statuses[4], BeamStatus::none);
  EXPECT_EQ(scan.statuses[5], BeamStatus::near);
  EXPECT_EQ(scan.statuses[6], BeamStatus::invalid);
  EXPECT_EQ(scan.statuses[7], BeamStatus::invalid);
  EXPECT_EQ(scan.statuses[8], BeamStatus::near);
}

TEST(Uam, IntensitiesAndFineStepsAreModelsOfTheirOwn) {
  UamBench bright({}, {}, "hokuyo_uam_05lp_intensity"), fine({}, {}, "hokuyo_uam_05lp_fine");
  bright.run(1s);
  fine.run(1s);
  ASSERT_FALSE(bright.scans.empty());
  ASSERT_FALSE(fine.scans.empty());
  EXPECT_FLOAT_EQ(bright.scans[0].ranges[100], 1.1F);
  EXPECT_FLOAT_EQ(bright.scans[0].intensities[100], 300.0F);
  EXPECT_EQ(fine.scans[0].beams, 2161U);
  EXPECT_FLOAT_EQ(fine.scans[0].ranges[2160], 3.16F);
}

TEST(Uam, TheStateComesWithTheStampOfItsScan) {
  UamDeviceOptions options;
  options.report.operating_mode = 1;
  options.report.area = 0x1f;
  options.report.ossd1 = 0;
  options.report.error_state = 1;
  options.report.error_code = 0x12;
  options.report.encoder_speed = 0x1234;
  options.report.warning2 = 1;
  options.report.contaminated = 1;
  UamBench bench(options);
  bench.run(1s);
  ASSERT_EQ(bench.states.size(), bench.scans.size());
  EXPECT_EQ(bench.states.back().topic, "status");
  EXPECT_EQ(bench.states.back().stamp, bench.scans.back().stamp);
  EXPECT_EQ(bench.value("operating_mode"), 1);
  EXPECT_EQ(bench.value("area"), 32) << "areas count from 1";
  EXPECT_EQ(bench.value("ossd1"), 0);
  EXPECT_EQ(bench.value("ossd2"), 1);
  EXPECT_EQ(bench.value("error_code"), 0x52);
  EXPECT_EQ(bench.value("encoder_speed"), 0x1234);
  EXPECT_EQ(bench.value("warning1"), 0);
  EXPECT_EQ(bench.value("warning2"), 1);
  EXPECT_TRUE(bench.has_warning("reports an error"));
  EXPECT_TRUE(bench.has_warning("dirty"));
  bench.sensor.options().report = {};
  bench.run(1s);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(Uam, ARefusalIsToldAndTheStreamIsAskedForAgain) {
  UamDeviceOptions options;
  options.boot = 103s;
  UamBench bench(options);
  bench.run(2500ms);
  EXPECT_TRUE(bench.has_warning("refuses to send (AR02, status 01)"));
  EXPECT_TRUE(bench.scans.empty());
  bench.run(2500ms);
  EXPECT_GT(bench.scans.size(), 30U);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(Uam, SilenceEndsTheConnection) {
  UamBench bench;
  bench.run(1s);
  bench.muted = true;
  bench.run(2s);
  EXPECT_GE(bench.reconnects, 1);
  EXPECT_TRUE(bench.has_warning("sends nothing"));
  bench.muted = false;
  bench.run(4s);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

const Model* recognized(const std::string& stream) {
  Identifier identifier;
  Packet packet;
  packet.transport = Transport::tcp;
  packet.payload = ByteView(stream);
  packet.stream_start = true;
  identifier.add(packet);
  return identifier.verdict();
}

TEST(Uam, StreamsOfHokuyosAreRecognised) {
  EXPECT_EQ(recognized(stream_of({}, "AR02", 100ms)), find_model("hokuyo_uam_05lp"));
  EXPECT_EQ(recognized(stream_of({}, "AR04", 100ms).substr(100)), find_model("hokuyo_uam_05lp_intensity"));
  const auto scip = [](const std::string& product, const std::string& requests) {
    sim::ScipDeviceOptions options;
    options.product = product;
    sim::ScipDevice device(
        options, [](Stamp) { return scip_wall(1081); }, scip_epoch - 100s);
    device.connected(scip_epoch);
    device.receive(requests, scip_epoch);
    std::string all;
    while (const auto sent = device.next(scip_epoch + 100ms)) all += sent->bytes;
    return recognized(all);
  };
  EXPECT_EQ(scip("UST-20LX", "VV\nPP\nMD0000108001000\n"), find_model("hokuyo_ust_20lx"));
  EXPECT_EQ(scip("UTM-30LX-EW", "PP\nMD0000108001000\n"), find_model("hokuyo_utm_30lx_ew"));
  EXPECT_EQ(scip("URG-04LX", "PP\nMD0000072501000\n"), find_model("hokuyo_scip"));
  EXPECT_EQ(scip("UST-20LX", "MD0000108001000\n"), find_model("hokuyo_scip")) << "no name was sent";
  EXPECT_EQ(scip("UST-20LX", "II\n"), nullptr);
  EXPECT_EQ(recognized(std::string(5000, 'x')), nullptr);
}

}  // namespace
}  // namespace lidard::test
