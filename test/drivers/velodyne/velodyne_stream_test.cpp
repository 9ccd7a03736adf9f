// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
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
using Bytes = std::vector<std::uint8_t>;

constexpr Stamp t0{1'767'226'643'000'000'000};

/// A VLP-16 that turns evenly and sees a different distance with every firing.
class Stream {
 public:
  explicit Stream(bool dual, double step_deg = 0.2) : dual_(dual), step_deg_(step_deg) {}

  Bytes next() {
    Bytes bytes(1206, 0);
    const auto put16 = [&](std::size_t at, unsigned value) {
      bytes[at] = static_cast<std::uint8_t>(value);
      bytes[at + 1] = static_cast<std::uint8_t>(value >> 8U);
    };
    const unsigned us = static_cast<unsigned>(
        static_cast<std::uint64_t>(std::llround(static_cast<double>(sequence_) * 55.296)) % 3'600'000'000U);
    for (std::size_t block = 0; block < 12; ++block) {
      const std::size_t pair = dual_ ? block / 2 : block;
      const double azimuth = start_deg_ + step_deg_ * static_cast<double>(sequence_ + 2 * pair);
      put16(100 * block, 0xEEFF);
      put16(100 * block + 2, static_cast<unsigned>(std::llround(azimuth * 100)) % 36000);
      for (std::size_t k = 0; k < 32; ++k) {
        const auto firing = static_cast<unsigned>((sequence_ + 2 * pair) * 16 + k);
        put16(100 * block + 4 + 3 * k, 1000 + firing % 60000);
        bytes[100 * block + 6 + 3 * k] = static_cast<std::uint8_t>(firing);
      }
    }
    for (std::size_t i = 0; i < 4; ++i) bytes[1200 + i] = static_cast<std::uint8_t>(us >> (8 * i));
    bytes[1204] = dual_ ? 0x39 : 0x37;
    bytes[1205] = 0x22;
    sequence_ += dual_ ? 12 : 24;
    return bytes;
  }
  Stamp arrival() const { return t0 + Span(static_cast<std::int64_t>(sequence_) * 55296 + 30'000); }

  std::uint64_t sequence_ = 0;
  double start_deg_ = 77.3;

 private:
  bool dual_;
  double step_deg_;
};

std::unique_ptr<Driver> make_driver(double cut_deg = 0, bool keep_partial = true, bool origins = true) {
  DriverConfig config;
  config.model = find_model("velodyne_vlp16");
  config.clock = ClockMode::arrival;
  config.cut_angle = cut_deg * M_PI / 180;
  config.keep_partial = keep_partial;
  config.keep_origins = origins;
  return config.model->make(config);
}

Reject give(Driver& driver, const Bytes& bytes, Stamp arrival, FrameReceiver& out) {
  const Endpoint sensor{IpAddress::v4(192, 168, 1, 201), 2368};
  return driver.receive({{bytes.data(), bytes.size()}, arrival, sensor, {{}, 2368}}, out).reject;
}

TEST(VelodyneStream, EveryFiringIsInExactlyOneFrameForEveryCutAngle) {
  for (const bool dual : {false, true}) {
    for (int cut = 0; cut < 360; cut += dual ? 5 : 1) {
      Stream stream(dual);
      const auto driver = make_driver(cut, true, false);
      Collector out;
      const int packets = dual ? 500 : 250;
      for (int i = 0; i < packets; ++i) {
        const Bytes bytes = stream.next();
        ASSERT_EQ(give(*driver, bytes, stream.arrival(), out), Reject::none);
      }
      driver->finish(out);
      std::size_t points = 0;
      std::size_t whole = 0;
      for (const Cloud& cloud : out.clouds) {
        points += cloud.size();
        for (std::size_t i = 0; i < cloud.size(); i += 97) {
          ASSERT_TRUE(cloud.points()[i].time >= 0 && cloud.points()[i].time < 0.1F);
        }
        if (!cloud.complete) continue;
        ++whole;
        ASSERT_EQ(cloud.columns.size(), dual ? 3600U : 1800U) << cut;
        const double first = cloud.columns.front().azimuth * 180 / M_PI;
        ASSERT_LT(std::fmod(first - cut + 720.0005, 360), 0.201) << cut;
      }
      const double to_first_cut = std::fmod(cut - 77.3 + 720, 360);
      ASSERT_EQ(whole, static_cast<std::size_t>((1200 - to_first_cut) / 360)) << cut;
      ASSERT_EQ(points, static_cast<std::size_t>(packets) * 384) << cut;
    }
  }
}

TEST(VelodyneStream, FirstAndLastRevolutionAreCountedAndKeptBack) {
  Stream stream(false);
  const auto driver = make_driver(0, false);
  Collector out;
  for (int i = 0; i < 250; ++i) {
    const Bytes bytes = stream.next();
    give(*driver, bytes, stream.arrival(), out);
  }
  driver->finish(out);
  EXPECT_EQ(out.clouds.size(), 2U);
  EXPECT_EQ(driver->counters().frames, 2U);
  EXPECT_EQ(driver->counters().partial_frames, 2U);
}

TEST(VelodyneStream, LossIsCountedExactlyWhateverIsDropped) {
  for (const double probability : {0.001, 0.01, 0.1, 0.5}) {
    for (const bool dual : {false, true}) {
      std::mt19937 random(static_cast<unsigned>(probability * 1000));
      Stream stream(dual);
      const auto driver = make_driver();
      Collector out;
      std::uint64_t lost = 0;
      std::uint64_t pending = 0;
      bool started = false;
      for (int i = 0; i < 3000; ++i) {
        const Bytes bytes = stream.next();
        if (static_cast<double>(random() % 100000) < probability * 100000) {
          if (started) ++pending;
          continue;
        }
        started = true;
        lost += pending;
        pending = 0;
        give(*driver, bytes, stream.arrival(), out);
      }
      driver->finish(out);
      EXPECT_EQ(driver->counters().lost_packets, lost) << probability << dual;
      EXPECT_EQ(driver->counters().rejected_total(), 0U);
      EXPECT_EQ(out.rows.size(), driver->counters().packets * 384);
    }
  }
}

TEST(VelodyneStream, TopOfTheHourLeavesNoTrace) {
  Stream stream(false);
  stream.sequence_ = static_cast<std::uint64_t>(3'600'000'000.0 / 55.296) / 24 * 24 - 24 * 100;
  const auto driver = make_driver();
  Collector out;
  for (int i = 0; i < 250; ++i) {
    const Bytes bytes = stream.next();
    give(*driver, bytes, stream.arrival(), out);
  }
  driver->finish(out);
  EXPECT_EQ(driver->counters().lost_packets, 0U);
  EXPECT_EQ(driver->counters().clock_steps, 0U);
  for (std::size_t f = 1; f + 1 < out.clouds.size(); ++f) EXPECT_EQ(out.clouds[f].columns.size(), 1800U);
  EXPECT_EQ(out.rows.size(), 250U * 384);
  for (std::size_t i = 1; i < out.rows.size(); ++i) {
    ASSERT_GE(out.rows[i].stamp_ns + 40'000, out.rows[i - 1].stamp_ns);
  }
}

TEST(VelodyneStream, ClockStepIsCountedAndCutsTheFrame) {
  Stream stream(false);
  const auto driver = make_driver();
  Collector out;
  for (int i = 0; i < 300; ++i) {
    if (i == 150) stream.sequence_ += 100'000'000;  // the sensor's clock was set
    const Bytes bytes = stream.next();
    give(*driver, bytes, t0 + std::chrono::microseconds(1327 * i), out);
  }
  driver->finish(out);
  EXPECT_EQ(driver->counters().clock_steps, 1U);
  EXPECT_EQ(out.rows.size(), 300U * 384);
  for (const auto& row : out.rows) {
    ASSERT_LT(row.time, 0.16);
    ASSERT_GE(row.time, 0);
  }
}

TEST(VelodyneStream, BrokenPacketsAreCountedByReason) {
  Stream stream(false);
  const auto driver = make_driver();
  Collector out;
  const Bytes good = stream.next();
  EXPECT_EQ(give(*driver, good, stream.arrival(), out), Reject::none);
  EXPECT_EQ(give(*driver, Bytes(good.begin(), good.end() - 1), stream.arrival(), out), Reject::size);
  EXPECT_EQ(give(*driver, {}, stream.arrival(), out), Reject::size);
  Bytes bad = stream.next();
  bad[500] = 0;
  EXPECT_EQ(give(*driver, bad, stream.arrival(), out), Reject::magic);
  bad = stream.next();
  bad[302] = 0xFF;
  bad[303] = 0xFF;
  EXPECT_EQ(give(*driver, bad, stream.arrival(), out), Reject::field);
  EXPECT_EQ(give(*driver, good, stream.arrival(), out), Reject::duplicate);
  EXPECT_EQ(driver->counters().rejected_total(), 5U);
  EXPECT_EQ(driver->counters().packets, 6U);
}

TEST(VelodyneStream, RandomBytesNeverCrashAndAreAllCounted) {
  std::mt19937 random(3);
  const auto driver = make_driver();
  Collector out;
  Stream stream(false);
  for (int i = 0; i < 3000; ++i) {
    Bytes bytes = stream.next();
    for (int n = 0; n < 3; ++n) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (i % 7 == 0) bytes.resize(random() % 1300);
    give(*driver, bytes, stream.arrival(), out);
  }
  driver->finish(out);
  const Counters& c = driver->counters();
  EXPECT_EQ(c.packets + c.other_packets, 3000U);
  EXPECT_GT(c.rejected_total(), 400U);
  for (const Cloud& cloud : out.clouds) ASSERT_LT(cloud.columns.size(), 60'000U);
}

TEST(VelodyneStream, DecodingAllocatesNothingAfterWarmUp) {
  test::Counted out;
  for (const bool dual : {false, true}) {
    Stream stream(dual);
    const auto driver = make_driver(0, false, false);
    std::vector<Bytes> packets;
    for (int i = 0; i < 2000; ++i) packets.push_back(stream.next());
    Stamp arrival = t0;
    const auto play = [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) {
        arrival = arrival + std::chrono::microseconds(dual ? 664 : 1327);
        give(*driver, packets[i], arrival, out);
      }
    };
    play(0, 700);
    const std::uint64_t before = test::allocations();
    play(700, 2000);
    EXPECT_EQ(test::allocations() - before, 0U) << dual;
    EXPECT_GT(driver->counters().frames, 3U);
  }
  EXPECT_GT(out.points, 100'000U);
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
    if (++number > 200) {
      const auto us = static_cast<std::uint32_t>(packet.payload.le32(1200) + by_us);
      for (std::size_t i = 0; i < 4; ++i) bytes[1200 + i] = static_cast<std::uint8_t>(us >> (8 * i));
    }
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
