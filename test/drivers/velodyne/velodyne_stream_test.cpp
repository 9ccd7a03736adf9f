// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <utility>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/support/allocations.h"
#include "test/support/captures.h"
#include "test/support/collector.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using test::Collector;
using test::WirePacket;
using Bytes = std::vector<std::uint8_t>;

const test::ModelMode vlp16{"velodyne_vlp16", sim::ReturnMode::strongest, ""};

/// 250 packets of a VLP-16: 3.3 turns.
std::vector<WirePacket> stream_of(const test::ModelMode& which) {
  sim::VelodyneOptions options;
  options.start_azimuth_deg = 77.3;
  return test::spin(which, 1200.0 / 360, options);
}

std::unique_ptr<Driver> make_driver(bool keep_partial = true, bool origins = true) {
  DriverConfig config;
  config.model = find_model("velodyne_vlp16");
  config.clock = ClockMode::arrival;
  config.keep_partial = keep_partial;
  config.keep_origins = origins;
  return config.model->make(config);
}

/// The sensor's clock, us of the hour.
void set_clock_forward(Bytes& packet, std::int64_t by_us) {
  const auto us = static_cast<std::uint32_t>(ByteView(packet.data(), packet.size()).le32(1200) + by_us);
  for (std::size_t i = 0; i < 4; ++i) packet[1200 + i] = static_cast<std::uint8_t>(us >> (8 * i));
}

TEST(VelodyneStream, FirstAndLastRevolutionAreCountedAndKeptBack) {
  const auto driver = make_driver(false);
  Collector out;
  for (const WirePacket& packet : stream_of(vlp16)) test::give(*driver, packet, out);
  driver->finish(out);
  EXPECT_EQ(out.clouds.size(), 2U);
  for (const Cloud& cloud : out.clouds) EXPECT_EQ(cloud.columns.size(), 1800U);
  EXPECT_EQ(driver->counters().frames, 2U);
  EXPECT_EQ(driver->counters().partial_frames, 2U);
}

TEST(VelodyneStream, ClockStepIsCountedAndCutsTheFrame) {
  const auto driver = make_driver();
  Collector out;
  std::vector<WirePacket> packets = stream_of(vlp16);
  for (std::size_t i = 0; i < packets.size(); ++i) {
    if (i >= 150) set_clock_forward(packets[i].bytes, 1'929'600'000);
    test::give(*driver, packets[i], out);
  }
  driver->finish(out);
  EXPECT_EQ(driver->counters().clock_steps, 1U);
  EXPECT_EQ(out.rows.size(), packets.size() * 384);
  for (const auto& row : out.rows) {
    ASSERT_LT(row.time, 0.16);
    ASSERT_GE(row.time, 0);
  }
}

TEST(VelodyneStream, BrokenPacketsAreCountedByReason) {
  const std::vector<WirePacket> packets = stream_of(vlp16);
  const auto driver = make_driver();
  Collector out;
  const auto verdict = [&](WirePacket packet, auto damage) {
    damage(packet.bytes);
    return test::give(*driver, packet, out);
  };
  EXPECT_EQ(test::give(*driver, packets[0], out), Reject::none);
  EXPECT_EQ(verdict(packets[0], [](Bytes& bytes) { bytes.pop_back(); }), Reject::size);
  EXPECT_EQ(verdict(packets[0], [](Bytes& bytes) { bytes.clear(); }), Reject::size);
  EXPECT_EQ(verdict(packets[1], [](Bytes& bytes) { bytes[500] = 0; }), Reject::magic);
  EXPECT_EQ(verdict(packets[2], [](Bytes& bytes) { bytes[302] = bytes[303] = 0xFF; }), Reject::field);
  EXPECT_EQ(test::give(*driver, packets[0], out), Reject::duplicate);
  EXPECT_EQ(driver->counters().rejected_total(), 5U);
  EXPECT_EQ(driver->counters().packets, 6U);
}

TEST(VelodyneStream, DecodingAllocatesNothingAfterWarmUp) {
  for (const sim::ReturnMode mode : {sim::ReturnMode::strongest, sim::ReturnMode::dual}) {
    const std::vector<WirePacket> packets = test::spin({"velodyne_vlp16", mode, ""}, 12);
    test::Counted out;
    const auto driver = make_driver(false, false);
    std::uint64_t before = 0;
    for (std::size_t i = 0; i < packets.size(); ++i) {
      if (i == packets.size() / 3) before = test::allocations();
      test::give(*driver, packets[i], out);
    }
    EXPECT_EQ(test::allocations() - before, 0U) << static_cast<int>(mode);
    EXPECT_GT(driver->counters().frames, 9U);
    EXPECT_GT(out.points, 100'000U);
  }
}

/// A real stream whose sensor's clock is set in its midst, as a pulse per second does that comes back.
std::size_t returns_with_clock_set(const char* path, const char* model, std::int64_t by_us,
                                   Counters& counters) {
  DriverConfig config;
  config.model = find_model(model);
  config.keep_partial = true;
  const auto driver = config.model->make(config);
  test::Columns out;
  PcapSource source(path);
  Packet packet;
  std::size_t number = 0;
  while (source.next(packet)) {
    if (packet.payload.size() != 1206) continue;
    Bytes bytes(packet.payload.data(), packet.payload.data() + packet.payload.size());
    if (++number > 200) set_clock_forward(bytes, by_us);
    packet.payload = {bytes.data(), bytes.size()};
    driver->receive(packet, out);
  }
  driver->finish(out);
  counters = driver->counters();
  return out.points;
}

TEST(VelodyneStream, NoReturnIsLostWhereTheSensorsClockIsSetBack) {
  LIDARD_NEED_CAPTURE(vlp16, "velodyne/vlp16_gps_293.pcap");
  LIDARD_NEED_CAPTURE(hdl32e, "velodyne/hdl32e_2011_port443.pcap");
  for (const std::int64_t by_us : {-1, -300, -1328, -2000, -10'000, -100'000, -999'000, -5'000'000}) {
    SCOPED_TRACE(by_us);
    Counters counters;
    // The numbers that their publisher's tests have.
    EXPECT_EQ(returns_with_clock_set(vlp16.c_str(), "velodyne_vlp16", by_us, counters), 73486U);
    EXPECT_EQ(counters.rejected_total(), 0U);
    EXPECT_LE(counters.clock_steps, 1U);
    EXPECT_EQ(returns_with_clock_set(hdl32e.c_str(), "velodyne_hdl32e", by_us, counters), 146705U);
    EXPECT_EQ(counters.rejected_total(), 0U);
  }
}

TEST(VelodyneStream, AClockThatIsSetForwardIsNoLoss) {
  LIDARD_NEED_CAPTURE(vlp16, "velodyne/vlp16_gps_293.pcap");
  for (const std::int64_t by_us : {5000, 100'000, 250'000, 3'000'000, 9'000'000}) {
    SCOPED_TRACE(by_us);
    Counters counters;
    EXPECT_EQ(returns_with_clock_set(vlp16.c_str(), "velodyne_vlp16", by_us, counters), 73486U);
    EXPECT_EQ(counters.lost_packets, 0U);
    EXPECT_EQ(counters.clock_steps, 1U);
  }
}

// The firing cycle of an HDL-64E depends on its settings, which can be changed while it runs.
TEST(VelodyneStream, AnHdl64eThatChangesItsFiringCycleHasTheNewTimes) {
  const auto packets = [](const char* timing) {
    return test::spin({"velodyne_hdl64e_s3", sim::ReturnMode::strongest, timing}, 3);
  };
  DriverConfig config;
  config.model = find_model("velodyne_hdl64e_s3");
  for (const auto& [before, after] : {std::pair("48", "57.6"), std::pair("57.6", "48")}) {
    const auto changed = config.model->make(config), fresh = config.model->make(config);
    test::Columns from_changed, from_fresh;
    for (const test::WirePacket& packet : packets(before)) test::give(*changed, packet, from_changed);
    for (const test::WirePacket& packet : packets(after)) {
      test::give(*changed, packet, from_changed);
      test::give(*fresh, packet, from_fresh);
    }
    const auto& columns = from_fresh.frames.back().columns;
    const auto& same = from_changed.frames.back().columns;
    ASSERT_EQ(columns.size(), same.size());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const auto after_first = [c](const auto& list) { return seconds(list[c].stamp - list[0].stamp); };
      ASSERT_NEAR(after_first(same), after_first(columns), 2e-5) << before << " column " << c;
    }
  }
}

}  // namespace
}  // namespace lidard
