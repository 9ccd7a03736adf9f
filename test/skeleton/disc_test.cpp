// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A driver that the program does not know is registered at run time and goes through the commands like all
// others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "daemon/cli.h"
#include "drivers/registry/registry.h"
#include "test/drivers/capture/pcap_testing.h"
#include "test/skeleton/disc_driver.h"
#include "test/support/collector.h"

namespace lidard::acme {
namespace {

using test::Bytes;
using test::little;
using test::operator+;
using ::testing::HasSubstr;

class Registration : public ::testing::Environment {
 public:
  void SetUp() override {
    ASSERT_EQ(find_model("acme_disc270"), nullptr) << "the program knows it by itself";
    const Model* other = find_model("velodyne_vlp16");
    register_family(disc_family);
    ASSERT_NE(find_model("acme_disc270"), nullptr);
    ASSERT_EQ(find_model("velodyne_vlp16"), other) << "models keep their addresses";
  }
};
const auto* const registration = ::testing::AddGlobalTestEnvironment(new Registration);

/// Distance in mm of a beam, by its number.
using Distances = std::function<std::uint16_t(std::size_t beam)>;

Bytes disc_packet(std::uint32_t scan, std::size_t part, std::uint32_t device_us, const Distances& distances,
                  bool dirty = false) {
  Bytes bytes{'D', 'I', 'S', 'C', 1, static_cast<std::uint8_t>(part)};
  bytes = bytes + little(scan, 2) + little(4711, 4) + little(device_us, 4) + little(dirty ? 1 : 0, 2);
  for (std::size_t i = 0; i < disc::beams_of_part; ++i)
    bytes = bytes + little(distances(part * disc::beams_of_part + i), 2);
  return bytes;
}

double direction(std::size_t beam) {
  return (disc::first_deg + disc::step_deg * static_cast<double>(beam)) * rad_per_deg;
}

/// Of a room of 12 m by 8 m around the origin: from a place in it into a direction, m.
double to_wall(double x, double y, double toward) {
  const double c = std::cos(toward), s = std::sin(toward);
  const double along_x = c > 0 ? (6 - x) / c : c < 0 ? (-6 - x) / c : 1e9;
  const double along_y = s > 0 ? (4 - y) / s : s < 0 ? (-4 - y) / s : 1e9;
  return std::min(along_x, along_y);
}

struct Mounted {
  double x, y, yaw;
  std::uint8_t last_of_address;
};
constexpr double begin_s = 1'700'000'000;
constexpr std::uint32_t first_us = 0xffff0000;  // the device's counter overflows after 65 ms

/// What devices in that room send, each part when its last beam was measured, 0.2 ms on the way.
class Capture {
 public:
  Capture(const std::vector<Mounted>& devices, std::uint32_t scans) {
    test::PcapBytes pcap;
    for (std::uint32_t scan = 0; scan < scans; ++scan) {
      for (std::size_t part = 0; part < disc::parts; ++part) {
        for (const Mounted& device : devices) add(pcap, device, scan, part);
      }
    }
    file_ = std::make_unique<test::MemoryFile>(pcap.bytes);
  }
  std::string path() const { return file_->path(); }

 private:
  static void add(test::PcapBytes& pcap, const Mounted& device, std::uint32_t scan, std::size_t part) {
    const auto distance = [&](std::size_t beam) {
      if (beam == 0) return disc::nothing;
      if (beam == 1) return disc::too_near;
      if (beam == 2) return disc::not_measured;
      const double m = to_wall(device.x, device.y, device.yaw + direction(beam));
      return static_cast<std::uint16_t>(std::lround(1000 * m));
    };
    const std::uint32_t us = first_us + scan * 40'000;
    const double sent =
        0.04 * scan + seconds(disc::beam) * static_cast<double>((part + 1) * disc::beams_of_part);
    test::V4 ip;
    ip.last_of_sender = device.last_of_address;
    const Bytes payload = disc_packet(scan, part, us, distance);
    pcap.add(test::ethernet(test::ipv4(test::udp(payload, 5000, disc::port), ip)), begin_s + sent + 0.0002);
  }
  std::unique_ptr<test::MemoryFile> file_;
};

/// Output of `lidard ARGUMENTS`; the exit code must be `expected`.
std::string run(std::vector<std::string> arguments, int expected = 0) {
  arguments.insert(arguments.begin(), "lidard");
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const int code = run_cli(static_cast<int>(pointers.size()), pointers.data());
  const std::string out = ::testing::internal::GetCapturedStdout();
  const std::string err = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(code, expected) << out << err;
  return expected == 0 ? out : err;
}

class Commands : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("lidard-skeleton-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string written(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return path(name);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

 private:
  std::filesystem::path folder_;
};

TEST_F(Commands, ListTheModel) { EXPECT_THAT(run({"models"}), HasSubstr("acme_disc270")); }

TEST_F(Commands, DecodeScansWithoutBeingToldTheModel) {
  const Capture capture({{0, 0, 0, 31}}, 10);
  std::istringstream rows(run({"decode", capture.path(), "--format", "csv"}));
  std::string header, row;
  std::getline(rows, header);
  ASSERT_EQ(header, "frame,beam,echo,angle_rad,range_m,intensity,stamp_ns,status");
  std::size_t count = 0;
  for (; std::getline(rows, row); ++count) {
    std::istringstream fields(row);
    std::vector<std::string> f;
    for (std::string field; std::getline(fields, field, ',');) f.push_back(field);
    const std::size_t beam = count % disc::beams;
    ASSERT_EQ(f.size(), 8U) << row;
    ASSERT_EQ(f[1], std::to_string(beam));
    ASSERT_NEAR(std::stod(f[3]), direction(beam), 1e-4);
    ASSERT_EQ(f[7], beam == 0 ? "none" : beam == 1 ? "near" : beam == 2 ? "invalid" : "hit");
    if (beam > 2) {
      ASSERT_NEAR(std::stod(f[4]), to_wall(0, 0, direction(beam)), 0.001);
    }
    // Whatever the device's counter says, a beam was measured when the room's clock says.
    const double at =
        0.04 * static_cast<double>(count / disc::beams) + seconds(disc::beam) * static_cast<double>(beam);
    const auto since_begin = std::stoll(f[6]) - static_cast<long long>(begin_s) * 1'000'000'000;
    ASSERT_NEAR(1e-9 * static_cast<double>(since_begin), at, 0.0003) << row;
  }
  EXPECT_EQ(count, 10 * disc::beams);
}

TEST_F(Commands, InspectACaptureAndPrintAConfigurationThatReplaysIt) {
  const Capture capture({{0, 0, 0, 31}, {1, 1, 1, 32}}, 10);
  const auto said = nlohmann::json::parse(run({"inspect", "--json", capture.path()}));
  ASSERT_EQ(said["sensors"].size(), 2U);
  EXPECT_EQ(said["sensors"][1]["model"], "acme_disc270");
  EXPECT_EQ(said["sensors"][1]["sender"], "192.168.1.32");
  EXPECT_EQ(said["sensors"][1]["serial"], "4711");
  EXPECT_EQ(said["sensors"][1]["frames"], 10);
  EXPECT_EQ(said["unknown"].size(), 0U);
  const std::string config = written("inspected.yaml", said["config"]);
  run({"replay", "-c", config, "--pcap", capture.path(), "--bag", path("inspected.bag")});
}

TEST_F(Commands, ReplayScansAndMergeThem) {
  const Capture capture({{2, 0, 0, 31}, {-2, 0, pi_d, 32}}, 20);
  const std::string config = written("two.yaml", R"(
sensors:
  front: {model: acme_disc270, ip_address: 192.168.1.31, pose: {xyz: [2, 0, 0.3]}}
  rear: {model: acme_disc270, ip_address: 192.168.1.32, pose: {xyz: [-2, 0, 0.3], rpy_deg: [0, 0, 180]}}
merged_scans:
  around:
    laserscan_topics: [front, rear]
    destination_frame: base_link
    scan_destination_topic: around
    angle_min_deg: -180
    angle_max_deg: 179.5
    angle_increment_deg: 0.5
)");
  EXPECT_THAT(run({"check", config}), HasSubstr("model: acme_disc270"));
  run({"replay", "-c", config, "--pcap", capture.path(), "--bag", path("two.bag")});

  rosbag::Bag bag(path("two.bag"));
  for (const char* topic : {"/front/scan", "/rear/scan"}) {
    rosbag::View scans(bag, rosbag::TopicQuery(topic));
    EXPECT_EQ(scans.size(), 20U) << topic;
  }
  rosbag::View merged(bag, rosbag::TopicQuery("/around"));
  ASSERT_GE(merged.size(), 18U);
  for (const auto& message : merged) {
    const auto scan = message.instantiate<sensor_msgs::LaserScan>();
    ASSERT_EQ(scan->ranges.size(), 720U);
    std::size_t hits = 0;
    for (std::size_t i = 0; i < 720; ++i) {
      if (!std::isfinite(scan->ranges[i])) continue;
      const double toward = scan->angle_min + static_cast<double>(i) * scan->angle_increment;
      EXPECT_NEAR(scan->ranges[i], to_wall(0, 0, toward), 0.05) << toward;
      ++hits;
    }
    EXPECT_GE(hits, 715U) << "both scanners together see every wall";
  }
}

TEST_F(Commands, RefuseKeysThatTheModelDoesNotTake) {
  const std::string config = written("skip.yaml", "sensors:\n  front: {model: acme_disc270, skip: 2}\n");
  EXPECT_THAT(run({"check", config}, 78), HasSubstr("skip.yaml:2"));
}

TEST(Registering, RefusesASecondModelOfThatNameAndOneWithoutADriver) {
  const std::size_t before = models().size();
  const std::size_t families_before = families().size();
  EXPECT_THROW(register_family(disc_family), std::invalid_argument);
  Family idle = disc_family;
  idle.append_models = [](std::vector<Model>& list) { list.emplace_back().name = "acme_disc90"; };
  EXPECT_THROW(register_family(idle), std::invalid_argument);
  EXPECT_EQ(models().size(), before);
  EXPECT_EQ(families().size(), families_before);
}

/// A driver and what it produced.
struct Bench {
  explicit Bench(DriverConfig config = {}) {
    config.model = find_model("acme_disc270");
    driver = config.model->make(config);
  }
  Reject give(const Bytes& bytes) {
    Packet packet;
    packet.payload = test::view(bytes);
    packet.arrival = now;
    now = now + disc::turn / 4;
    return driver->receive(packet, output).reject;
  }
  Reject give(std::uint32_t scan, std::size_t part, bool dirty = false) {
    return give(disc_packet(
        scan, part, scan * 40'000, [](std::size_t) { return std::uint16_t{5000}; }, dirty));
  }
  void give_scan(std::uint32_t scan) {
    for (std::size_t part = 0; part < disc::parts; ++part) give(scan, part);
  }
  const Counters& counters() const { return driver->counters(); }

  test::Collector output;
  std::unique_ptr<Driver> driver;
  Stamp now{static_cast<std::int64_t>(begin_s) * 1'000'000'000};
};

TEST(DiscDriver, CountsWhatIsMissingTwiceOrLate) {
  Bench bench;
  bench.give_scan(65534);
  bench.give(65535, 0);
  bench.give(65535, 2);
  EXPECT_EQ(bench.give(65535, 2), Reject::duplicate);
  EXPECT_EQ(bench.give(65535, 1), Reject::stale);
  bench.give(65535, 3);
  bench.give_scan(0);
  EXPECT_EQ(bench.counters().frames, 2U);
  EXPECT_EQ(bench.counters().partial_frames, 1U);
  EXPECT_EQ(bench.counters().lost_packets, 1U);
  EXPECT_EQ(bench.counters().reordered, 1U);
  EXPECT_EQ(bench.counters().rejected_total(), 2U);
}

TEST(DiscDriver, GoesOnAfterTheDeviceWasSwitchedOffAndOn) {
  Bench bench;
  for (std::uint32_t scan = 20000; scan < 20020; ++scan) bench.give_scan(scan);
  for (std::uint32_t scan = 0; scan < 20; ++scan) bench.give_scan(scan);
  EXPECT_EQ(bench.counters().frames, 40U);
  EXPECT_EQ(bench.counters().lost_packets, 0U);
  EXPECT_EQ(bench.counters().clock_steps, 1U);
}

TEST(DiscDriver, DropsAScanThatTheEndCutsOff) {
  Bench bench;
  bench.give(7, 0);
  bench.driver->finish(bench.output);
  EXPECT_EQ(bench.counters().partial_frames, 1U);
  EXPECT_EQ(bench.counters().frames, 0U);
}

TEST(DiscDriver, WarnsOfADirtyWindowWhileItIsOne) {
  Bench bench;
  bench.give(1, 0, true);
  ASSERT_EQ(bench.driver->info().warnings.size(), 1U);
  EXPECT_THAT(bench.driver->info().warnings[0], HasSubstr("clean it"));
  bench.give(1, 1);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(DiscDriver, KeepsTheConfiguredBeamsAndTheirTime) {
  DriverConfig config;
  config.angle_min = -90 * rad_per_deg;
  config.angle_max = 90 * rad_per_deg;
  Bench all, some(config);
  for (std::uint32_t scan = 0; scan < 3; ++scan) all.give_scan(scan), some.give_scan(scan);
  ASSERT_EQ(some.output.scans.size(), 3U);
  const PlanarScan &kept = some.output.scans[2], &whole = all.output.scans[2];
  EXPECT_EQ(kept.beams, 481U);
  EXPECT_NEAR(kept.angle_min, -90 * rad_per_deg, 1e-6);
  EXPECT_EQ(violation(kept), nullptr);
  EXPECT_EQ(kept.stamp - whole.stamp, disc::beam * 120);
}

TEST(DiscDriver, SaysWhyItRefusesAPacket) {
  Bench bench;
  const auto changed = [](std::size_t at, std::uint8_t value) {
    Bytes bytes = disc_packet(1, 0, 0, [](std::size_t) { return disc::nothing; });
    bytes[at] = value;
    return bytes;
  };
  EXPECT_EQ(bench.give(Bytes{}), Reject::magic);
  EXPECT_EQ(bench.give(changed(0, 'd')), Reject::magic);
  EXPECT_EQ(bench.give(changed(4, 2)), Reject::version);
  EXPECT_EQ(bench.give(changed(5, 4)), Reject::field);
  Bytes longer = changed(0, 'D');
  longer.push_back(0);
  EXPECT_EQ(bench.give(longer), Reject::size);
  EXPECT_EQ(bench.counters().packets, bench.counters().rejected_total());
}

TEST(DiscDriver, MakesNoImpossibleScanOfAnyBytes) {
  std::mt19937 random(1);
  Bench bench;
  for (int i = 0; i < 20'000; ++i) {
    Bytes bytes = disc_packet(static_cast<std::uint32_t>(i / 4), static_cast<std::size_t>(i % 4),
                              40'000U * static_cast<std::uint32_t>(i / 4),
                              [&](std::size_t) { return static_cast<std::uint16_t>(random()); });
    for (auto faults = random() % 3; faults-- > 0;)
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (random() % 20 == 0) bytes.resize(random() % 400);
    bench.give(bytes);
  }
  const Counters& c = bench.counters();
  EXPECT_GT(c.frames, 1000U);
  EXPECT_EQ(c.packets, 20'000U);
  EXPECT_LE(4 * c.frames + c.rejected_total(), c.packets);
  for (const PlanarScan& scan : bench.output.scans) ASSERT_EQ(violation(scan), nullptr);
}

}  // namespace
}  // namespace lidard::acme
