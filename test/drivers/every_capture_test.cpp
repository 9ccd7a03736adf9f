// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What holds of every driver, shown with the shipped captures and with some turns of Velodynes: no frame is
// stamped beyond the arrival of the packet that brought it, `time_offset` moves all stamps, and after a
// restart a capture is decoded as before.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/capture/pcap_source.h"
#include "drivers/registry/registry.h"
#include "test/support/captures.h"
#include "test/support/collector.h"
#include "test/support/velodyne_wire.h"

namespace lidard::test {
namespace {

struct Played {
  const char* capture;  ///< or nothing, for turns of a Velodyne
  const char* model;
  sim::ReturnMode mode = sim::ReturnMode::strongest;
  const char* timing = "";
};
const Played captures[] = {{"sick_lms111", "sick_lms1xx"},
                           {"sick_tim571_text", "sick_tim5xx"},
                           {"sick_mrs1104", "sick_mrs1000"},
                           {"hokuyo_ust_10lx", "hokuyo_ust_10lx"},
                           {"hokuyo_utm_30lx_ew", "hokuyo_utm_30lx_ew"},
                           {"hokuyo_uam_05lp", "hokuyo_uam_05lp"},
                           {"picoscan150", "sick_picoscan150"},
                           {"multiscan136", "sick_multiscan136"},
                           {"demo", "sick_microscan3"},
                           {nullptr, "velodyne_vlp16"},
                           {nullptr, "velodyne_vlp32c", sim::ReturnMode::dual},
                           {nullptr, "velodyne_hdl64e_s2", sim::ReturnMode::strongest, "48"}};

class EveryDriver : public ::testing::TestWithParam<Played> {
 protected:
  EveryDriver() {
    if (GetParam().capture == nullptr) {
      for (const WirePacket& packet : spin({GetParam().model, GetParam().mode, GetParam().timing}, 2.4)) {
        bytes_.push_back(packet.bytes);
        packets_.push_back(
            {{}, packet.arrival, {IpAddress::v4(192, 168, 1, 201), 2368}, {IpAddress(), 2368}});
      }
      return;
    }
    PcapSource source(project_file(std::string("pcaps/") + GetParam().capture + ".pcap"));
    std::optional<IpAddress> sender;
    for (Packet packet; source.next(packet);) {
      if (!is_for(*find_model(GetParam().model), packet)) continue;
      if (!sender) sender = packet.from.address;
      if (packet.from.address != *sender) continue;
      bytes_.emplace_back(packet.payload.begin(), packet.payload.end());
      packets_.push_back(packet);
    }
  }
  std::unique_ptr<Driver> make_driver(Span time_offset = Span(0)) const {
    DriverConfig config;
    config.model = find_model(GetParam().model);
    config.time_offset = time_offset;
    return config.model->make(config);
  }
  std::size_t size() const { return packets_.size(); }
  Packet packet(std::size_t i) const {
    Packet packet = packets_[i];
    packet.payload = {bytes_[i].data(), bytes_[i].size()};
    return packet;
  }
  Collector play(Driver& driver, std::size_t count) const {
    Collector out;
    for (std::size_t i = 0; i < count; ++i) driver.receive(packet(i), out);
    return out;
  }
  Collector play(Driver& driver) const {
    Collector out = play(driver, size());
    driver.finish(out);
    return out;
  }

 private:
  std::vector<std::vector<std::uint8_t>> bytes_;
  std::vector<Packet> packets_;
};

/// By how much a frame is stamped beyond the arrival of the packet at hand.
struct Watch final : FrameReceiver {
  void scan(PlanarScan& scan) override { judge(scan.stamp); }
  void cloud(Cloud& cloud) override { judge(cloud.stamp); }
  void judge(Stamp stamp) {
    ++frames;
    beyond = std::max(beyond, seconds(stamp - arrival));
  }
  Stamp arrival;
  int frames = 0;
  double beyond = -1;
};

TEST_P(EveryDriver, StampsNoFrameBeyondTheArrivalOfItsLastPacket) {
  using Bend = std::function<Stamp(Stamp arrival, std::size_t packet)>;
  const Bend bends[] = {
      [](Stamp at, std::size_t) { return at; },
      // The host's clock is set forth and back by an hour; the network delays by up to 40 ms.
      [](Stamp at, std::size_t i) { return at + std::chrono::hours(i / 40 % 2); },
      [](Stamp at, std::size_t i) { return at + std::chrono::milliseconds(i * 7919 % 41); }};
  for (const Bend& bend : bends) {
    const auto driver = make_driver();
    Watch watch;
    for (std::size_t i = 0; i < size(); ++i) {
      Packet one = packet(i);
      const Stamp arrival = bend(one.arrival, i);
      const bool overtakes = arrival < watch.arrival && watch.arrival - arrival < restart_limit;
      one.arrival = watch.arrival = overtakes ? watch.arrival : arrival;
      driver->receive(one, watch);
    }
    EXPECT_LE(watch.beyond, 0) << "with bend " << &bend - bends;
    EXPECT_GT(watch.frames, 0);
  }
}

/// All stamps of a frame but for those that count from the first one.
std::vector<Stamp> stamps_of(const Collector& out) {
  std::vector<Stamp> all;
  for (const PlanarScan& scan : out.scans) all.push_back(scan.stamp);
  for (const auto& [topic, scans] : out.extra_scans)
    for (const PlanarScan& scan : scans) all.push_back(scan.stamp);
  for (const DeviceState& state : out.states) all.push_back(state.stamp);
  for (const ImuSample& sample : out.imus) all.push_back(sample.stamp);
  for (const Cloud& cloud : out.clouds) {
    all.insert(all.end(), {cloud.stamp, cloud.end});
    for (const CloudColumn& column : cloud.columns) all.push_back(column.stamp);
  }
  return all;
}

TEST_P(EveryDriver, MovesAllStampsByTheTimeOffset) {
  const Span offset = std::chrono::milliseconds(-21);
  const std::vector<Stamp> plain = stamps_of(play(*make_driver())),
                           moved = stamps_of(play(*make_driver(offset)));
  ASSERT_EQ(moved.size(), plain.size());
  ASSERT_FALSE(plain.empty());
  for (std::size_t i = 0; i < plain.size(); ++i) ASSERT_EQ(moved[i] - plain[i], offset) << i;
}

/// The newest frames are the same; a device whose geometry was known before has more at the begin.
void expect_same_frames(const Collector& is, const Collector& should) {
  ASSERT_GE(is.scans.size(), should.scans.size());
  for (std::size_t i = 1; i <= should.scans.size(); ++i) {
    const PlanarScan &a = is.scans[is.scans.size() - i], &b = should.scans[should.scans.size() - i];
    EXPECT_NEAR(seconds(a.stamp - b.stamp), 0, 1e-5) << i;
    EXPECT_NEAR(a.scan_time, b.scan_time, 2e-5) << i;
    EXPECT_EQ(a.statuses, b.statuses) << i;
    for (std::size_t beam = 0; beam < b.ranges.size(); ++beam)
      ASSERT_TRUE(a.statuses[beam] != BeamStatus::hit || a.ranges[beam] == b.ranges[beam]) << i;
  }
  ASSERT_GE(is.clouds.size(), should.clouds.size());
  for (std::size_t i = 1; i <= should.clouds.size(); ++i) {
    const Cloud &a = is.clouds[is.clouds.size() - i], &b = should.clouds[should.clouds.size() - i];
    EXPECT_NEAR(seconds(a.stamp - b.stamp), 0, 1e-5) << i;
    ASSERT_EQ(a.size(), b.size()) << i;
    for (std::size_t p = 0; p < b.size(); p += 7) {
      const CloudPoint at = a.points()[p], truth = b.points()[p];
      ASSERT_EQ(at.ring, truth.ring);
      ASSERT_LT(std::hypot(at.x - truth.x, at.y - truth.y, at.z - truth.z), 1e-3) << i << ", " << p;
    }
  }
}

TEST_P(EveryDriver, DecodesACaptureThatBeginsAgainAsTheFirstTime) {
  const auto fresh = make_driver(), again = make_driver();
  const Collector should = play(*fresh);
  ASSERT_GE(should.scans.size() + should.clouds.size(), 1U);
  const std::uint64_t lost = fresh->counters().lost_packets;
  for (const std::size_t until : {size(), size() * 2 / 3}) {
    play(*again, until);
    again->restart();
    const Collector is = play(*again);
    expect_same_frames(is, should);
    if (GetParam().capture == nullptr) {
      EXPECT_EQ(is.clouds.size(), should.clouds.size());
    }
    again->restart();
  }
  EXPECT_LE(again->counters().lost_packets, 4 * lost);
  EXPECT_EQ(again->counters().clock_steps, 0U);
  EXPECT_EQ(again->counters().rejected_total(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Captures, EveryDriver, ::testing::ValuesIn(captures),
                         [](const auto& each) { return std::string(each.param.model); });

}  // namespace
}  // namespace lidard::test
