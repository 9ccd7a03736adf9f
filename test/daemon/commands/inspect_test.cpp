// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/commands/commands.h"
#include "daemon/config/config.h"
#include "daemon/offline/survey.h"
#include "drivers/capture/pcap_source.h"
#include "drivers/capture/pcap_writer.h"
#include "drivers/registry/registry.h"
#include "test/drivers/capture/pcap_testing.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

struct Said {
  int exit;
  std::string out, err;
};

Said inspect(const std::vector<std::string>& captures, bool json = false) {
  std::ostringstream out, err;
  const int exit = run_inspect(captures, json, out, err);
  return {exit, out.str(), err.str()};
}

Json inspect_json(const std::string& capture, int exit = 0) {
  const Said said = inspect({capture}, true);
  EXPECT_EQ(said.exit, exit) << said.err;
  return Json::parse(said.out);
}

Bytes foreign_capture() {
  PcapBytes file;
  for (int i = 0; i < 11; ++i) file.add(ethernet(ipv4(udp(Bytes(30 + i % 2), 4000, 5009))), 100 + 0.1 * i);
  return file.add(ethernet(Bytes(28), {0x0806}), 101).bytes;
}

TEST(Inspect, ListsForeignStreamsWithSizeAndRate) {
  const MemoryFile file(foreign_capture());
  const Json said = inspect_json(file.path());
  EXPECT_TRUE(said["sensors"].empty());
  EXPECT_TRUE(said["config"].is_null());
  ASSERT_EQ(said["unknown"].size(), 1U);
  const Json& flow = said["unknown"][0];
  EXPECT_EQ(flow["sender"], "192.168.1.201");
  EXPECT_EQ(flow["source_port"], 4000);
  EXPECT_EQ(flow["port"], 5009);
  EXPECT_EQ(flow["destinations"], Json({"255.255.255.255"}));
  EXPECT_EQ(flow["packets"], 11);
  EXPECT_EQ(flow["smallest"], 30);
  EXPECT_EQ(flow["largest"], 31);
  EXPECT_NEAR(flow["rate_hz"].get<double>(), 10, 1e-6);
  EXPECT_NEAR(flow["duration_s"].get<double>(), 1, 1e-6);
  EXPECT_EQ(said["captures"][0]["not_ip"], 1);
  EXPECT_EQ(said["captures"][0]["frames"], 12);

  const Said text = inspect({file.path()});
  EXPECT_EQ(text.exit, 0);
  EXPECT_THAT(text.out, HasSubstr("11 datagrams in 12 frames, 1.000 s; 1 not IP\n"));
  EXPECT_THAT(text.out, HasSubstr("no sensor was recognised"));
  EXPECT_THAT(
      text.out,
      HasSubstr("# 192.168.1.201  udp        5009  11       10       1           30        31       -\n"));
  EXPECT_THAT(text.out, Not(HasSubstr("sensors:")));
}

TEST(Inspect, TellsManyStreamsApartAndShowsTheBusiest) {
  PcapBytes file;
  for (std::uint16_t port = 1; port <= 1500; ++port) file.add(ethernet(ipv4(udp({1}, 9, port))), 1);
  file.add(ethernet(ipv4(udp({1}, 9, 77))), 2);
  const MemoryFile memory(file.bytes);
  const Json said = inspect_json(memory.path());
  EXPECT_EQ(said["unknown"].size(), 1000U);
  EXPECT_EQ(said["unknown"][0]["port"], 77);
  EXPECT_EQ(said["uncounted"], 500);
  EXPECT_THAT(inspect({memory.path()}).out, HasSubstr("# and 990 more (see --json)\n# and 500 datagrams"));
}

TEST(Inspect, SaysWhyACaptureCannotBeReadAndGoesOnWithTheOthers) {
  const MemoryFile good(foreign_capture());
  Bytes bytes = foreign_capture();
  bytes.pop_back();
  const MemoryFile cut(bytes);
  const Said said = inspect({"/no/such.pcap", good.path(), cut.path()});
  EXPECT_EQ(said.exit, 1);
  EXPECT_THAT(said.err,
              HasSubstr("/no/such.pcap: cannot be opened: No such file or directory; check the path"));
  EXPECT_THAT(said.err, HasSubstr("what came before it was used\n"));
  EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 2);
  EXPECT_THAT(said.out, HasSubstr("22 "));  // both that could be read, as one stream

  const Said nothing = inspect({"/no/such.pcap"});
  EXPECT_EQ(nothing.exit, 1);
  EXPECT_EQ(nothing.out, "");
  EXPECT_THAT(inspect_json("/no/such.pcap", 1)["captures"][0]["error"], HasSubstr("cannot be opened"));
}

TEST(Inspect, SaysHowToRecordAgainWhatTheSnapshotLengthCut) {
  const Bytes frame = ethernet(ipv4(udp(Bytes(100))));
  const Bytes cut(frame.begin(), frame.begin() + 60);
  const MemoryFile file(PcapBytes().add(cut, 1, frame.size()).bytes);
  EXPECT_THAT(inspect({file.path()}).out,
              HasSubstr("1 cut by the snapshot length (record with tcpdump -s 0)"));
}

/// The text is a configuration with exactly the sensors of the JSON.
void expect_config_replays(const std::string& capture) {
  const Said text = inspect({capture});
  const Json sensors = inspect_json(capture)["sensors"];
  const Config config = parse_config(text.out, "inspect");
  ASSERT_EQ(config.sensors.size(), sensors.size());
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    EXPECT_EQ(config.sensors[i].name, sensors[i]["name"]);
    EXPECT_EQ(config.sensors[i].frame_id, sensors[i]["name"]);
    EXPECT_EQ(config.sensors[i].model->name, sensors[i]["model"].get<std::string>());
    EXPECT_EQ(config.sensors[i].ip_port, sensors[i]["port"]);
    // A capture may come over IPv6; a configuration names no such sender.
    const std::string sender = sensors[i]["sender"];
    const bool named = sender.find(':') == std::string::npos;
    ASSERT_EQ(config.sensors[i].ip_address.has_value(), named);
    if (named) {
      EXPECT_EQ(config.sensors[i].ip_address->to_string(), sender);
    }
  }
}

TEST(Inspect, FindsEverySensorOfTheDemoVehicle) {
  const std::string path = project_file("pcaps/demo.pcap");
  const Json said = inspect_json(path);
  ASSERT_EQ(said["sensors"].size(), 3U);
  EXPECT_EQ(said["sensors"][0]["model"], "sick_microscan3");
  EXPECT_EQ(said["sensors"][1]["name"], "sick_microscan3_2");
  EXPECT_EQ(said["sensors"][2]["model"], "velodyne_vlp16");
  EXPECT_NE(said["sensors"][0]["serial"], said["sensors"][1]["serial"]);
  for (const Json& sensor : said["sensors"]) {
    EXPECT_GT(sensor["frames"], 10);
    EXPECT_EQ(sensor["lost_packets"], 0);
    for (const auto& rejects : sensor["rejected"]) EXPECT_EQ(rejects, 0);
  }
  EXPECT_TRUE(said["unknown"].empty());
  expect_config_replays(path);
}

TEST(Inspect, FindsAVlp16WithItsPositionPackets) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_gps_293.pcap");
  const Json said = inspect_json(path);
  ASSERT_EQ(said["sensors"].size(), 1U);
  const Json& sensor = said["sensors"][0];
  EXPECT_EQ(sensor["model"], "velodyne_vlp16");
  EXPECT_EQ(sensor["port"], 2368);
  EXPECT_EQ(sensor["data_packets"], 293);
  EXPECT_EQ(sensor["other_packets"], 57);
  EXPECT_EQ(sensor["telemetry"]["port"], 8308);
  EXPECT_EQ(sensor["telemetry"]["packets"], 57);
  EXPECT_EQ(sensor["lost_packets"], 0);
  for (const auto& rejects : sensor["rejected"]) EXPECT_EQ(rejects, 0);
  EXPECT_TRUE(said["unknown"].empty());
  expect_config_replays(path);
}

TEST(Inspect, MeasuresTheRateOfSingleAndDualReturn) {
  LIDARD_NEED_CAPTURE(single, "velodyne/vlp16_strongest_1000.pcap");
  LIDARD_NEED_CAPTURE(dual, "velodyne/vlp16_dual_603.pcap");
  // 63-9243 Rev D section 9.4: 24 (12) firing sequences of 55.296 us in a packet.
  EXPECT_NEAR(inspect_json(single)["sensors"].at(0)["rate_hz"].get<double>(), 753.5, 8);
  EXPECT_NEAR(inspect_json(dual)["sensors"].at(0)["rate_hz"].get<double>(), 1507, 16);
}

TEST(Inspect, BelievesThePacketPeriodWhereTheProductByteLies) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_2014_says_hdl32.pcap");
  const Json said = inspect_json(path);
  EXPECT_EQ(said["sensors"].at(0)["model"], "velodyne_vlp16");
  EXPECT_THAT(said["sensors"].at(0)["remark"], HasSubstr("HDL-32E"));
  EXPECT_THAT(inspect({path}).out, HasSubstr("# velodyne_vlp16: product byte says HDL-32E"));
}

TEST(Inspect, FindsTheSameSensorInEveryOddRelativeOfACapture) {
  for (const std::string name :
       {"vlan.pcap", "sll2.pcap", "frag_reorder.pcap", "pcapng_two_if.pcapng", "ipv6.pcap"}) {
    LIDARD_NEED_CAPTURE(path, "odd/" + name);
    const Json said = inspect_json(path);
    ASSERT_EQ(said["sensors"].size(), 1U) << name;
    EXPECT_EQ(said["sensors"][0]["data_packets"], 84) << name;
    EXPECT_EQ(said["sensors"][0]["lost_packets"], 0) << name;
    expect_config_replays(path);
  }
}

TEST(Inspect, ReportsLostPackets) {
  LIDARD_NEED_CAPTURE(path, "odd/drop10.pcap");
  const Json said = inspect_json(path);
  // Every tenth of 100 is gone: three were position packets, and nothing tells of the very last.
  EXPECT_EQ(said["sensors"].at(0)["lost_packets"], 6);
}

TEST(Inspect, ReportsRejectedPacketsByReason) {
  LIDARD_NEED_CAPTURE(path, "odd/noise.pcap");
  const Json said = inspect_json(path);
  const Json& sensor = said["sensors"].at(0);
  std::uint64_t rejected = 0;
  for (const auto& reason : sensor["rejected"]) rejected += reason.get<std::uint64_t>();
  // To port 2368: four of 1205, three of 1212 and two of 0 bytes; to port 8308: one of 518 and one of 0.
  EXPECT_EQ(sensor["rejected"]["size"], 11);
  EXPECT_EQ(rejected, 11U);
  ASSERT_EQ(said["unknown"].size(), 1U);
  EXPECT_EQ(said["unknown"][0]["port"], 5353);
}

TEST(Inspect, WritesAnAcceptedConfigurationOfADamagedCapture) {
  // A connection to a multicast group, found by fuzz_pcap.
  FoundSensor sensor;
  sensor.name = "front";
  sensor.model = find_model("hokuyo_scip");
  sensor.data.transport = Transport::tcp;
  sensor.data.address = IpAddress::v4(192, 168, 0, 10);
  sensor.data.port = 10940;
  sensor.data.destinations = {IpAddress::v4(224, 168, 0, 2)};
  Survey seen;
  seen.sensors = {sensor};
  EXPECT_EQ(parse_config(config_of(seen), "inspect").sensors.size(), 1U);
}

TEST(Inspect, ASenderWithTheAddressOfAGroupIsNoSensor) {
  // Found by fuzz_pcap: the configuration would be rejected.
  const MemoryFile file{Bytes()};
  PcapWriter writer(file.path());
  PcapSource source(project_file("pcaps/demo.pcap"));
  Packet packet;
  for (int left = 300; left > 0 && source.next(packet);) {
    if (packet.transport != Transport::udp || packet.to.port != 2368) continue;
    writer.write(packet.arrival, {IpAddress::v4(235, 168, 0, 30), 2368}, packet.to, packet.payload);
    --left;
  }
  writer.close();
  const Json said = inspect_json(file.path());
  EXPECT_TRUE(said["sensors"].empty());
  EXPECT_EQ(said["unknown"].at(0)["packets"], 300) << said.dump();
}

TEST(Inspect, FindsSensorsOfSeveralCapturesAtOnce) {
  LIDARD_NEED_CAPTURE(one, "velodyne/vlp16_gps_293.pcap");
  LIDARD_NEED_CAPTURE(two, "odd/ipv6.pcap");
  const Said said = inspect({one, two});
  EXPECT_EQ(said.exit, 0);
  const Config config = parse_config(said.out, "inspect");
  ASSERT_EQ(config.sensors.size(), 2U);
  EXPECT_EQ(config.sensors[1].name, "velodyne_vlp16_2");
}

}  // namespace
}  // namespace lidard::test
