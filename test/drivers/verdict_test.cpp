// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What drivers say of the bytes that they are given.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "drivers/hokuyo/uam_frame.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/drivers/sick/cola/fake_cola_device.h"
#include "test/support/collector.h"
#include "test/support/velodyne_wire.h"

namespace lidard::test {
namespace {

Verdict verdict_on(const char* model, ByteView bytes, Transport transport) {
  DriverConfig config;
  config.model = find_model(model);
  const auto driver = config.model->make(config);
  Packet packet;
  packet.payload = bytes;
  packet.arrival = Stamp{1'767'225'600'000'000'000};
  packet.transport = transport;
  Counted nowhere;
  return driver->receive(packet, nowhere);
}

Verdict verdict_on(const char* model, const Bytes& bytes, Transport transport) {
  return verdict_on(model, ByteView(bytes.data(), bytes.size()), transport);
}

TEST(Verdict, OnlyMeasurementsAreData) {
  ColaBench bench;
  EXPECT_TRUE(verdict_on("sick_lms1xx", bench.sample.bytes(Cola::binary), Transport::tcp).has_data);
  EXPECT_FALSE(verdict_on("sick_lms1xx", binary("sWA LMDscandatacfg"), Transport::tcp).has_data);
  const Bytes telemetry(512, 0);
  EXPECT_FALSE(verdict_on("velodyne_vlp16", telemetry, Transport::udp).has_data);
  const std::string answer = "QT\n00P\n\n";
  EXPECT_FALSE(verdict_on("hokuyo_ust_10lx", ByteView(answer), Transport::tcp).has_data);
  EXPECT_FALSE(verdict_on("sick_microscan3", Bytes(20, 2), Transport::tcp).has_data) << "its dialogue";
}

TEST(Verdict, DataThatCannotBeReadIsDataWithAReason) {
  for (const char* model : {"velodyne_vlp16", "sick_microscan3", "sick_picoscan150"}) {
    const Verdict verdict = verdict_on(model, Bytes(100, 0xee), Transport::udp);
    EXPECT_TRUE(verdict.has_data) << model;
    EXPECT_NE(verdict.reject, Reject::none) << model;
  }
  std::string frame = hokuyo::uam_request("AR00");
  frame[frame.size() - 2] ^= 1;
  const Verdict damaged = verdict_on("hokuyo_uam_05lp", ByteView(frame), Transport::tcp);
  EXPECT_TRUE(damaged.has_data);
  EXPECT_EQ(damaged.reject, Reject::checksum);
}

// Whether packets with another product byte are lying or foreign shows in the time between two of them.
TEST(Verdict, APacketThatWasHeldBackIsRejectedWithTheNextOne) {
  DriverConfig config;
  config.model = find_model("velodyne_vlp16");
  const auto driver = config.model->make(config);
  Counted nowhere;
  std::vector<WirePacket> packets = spin(model_modes().front(), 1);
  ASSERT_EQ(model_modes().front().model, "velodyne_vlp16");
  for (WirePacket& packet : packets) packet.bytes[1205] = 0x28;  // a VLP-32C's
  EXPECT_EQ(give(*driver, packets[0], nowhere), Reject::none) << "not known yet";
  EXPECT_EQ(give(*driver, packets[11], nowhere), Reject::model) << "eleven periods later";
}

// 63-9243 section 9.4: a packet of a VLP-32C takes 663.552 us, of a VLP-16 1327.104 us, twice as long.
TEST(Verdict, PacketsOfAnotherPuckAreNeverTakenForThoseOfTheModelWhateverIsLost) {
  const auto mode_of = [](const char* model) {
    for (const ModelMode& mode : model_modes())
      if (mode.model == model) return mode;
    throw std::out_of_range(model);
  };
  for (const auto& [configured, sent] : {std::pair{"velodyne_vlp32c", "velodyne_vlp16"},
                                         {"velodyne_vlp16", "velodyne_vlp32c"},
                                         {"velodyne_vlp16", "velodyne_vls128"},
                                         {"velodyne_vls128", "velodyne_vlp16"}}) {
    const std::vector<WirePacket> packets = spin(mode_of(sent), 0.5);
    for (const std::size_t every : {1U, 2U, 3U}) {
      SCOPED_TRACE(std::string(sent) + " as " + configured + ", one of " + std::to_string(every));
      DriverConfig config;
      config.model = find_model(configured);
      config.keep_partial = true;
      const auto driver = config.model->make(config);
      Columns out;
      for (std::size_t i = 0; i < packets.size(); i += every) give(*driver, packets[i], out);
      driver->finish(out);
      EXPECT_EQ(out.points, 0U);
      EXPECT_EQ(driver->counters().rejected[static_cast<std::size_t>(Reject::model)],
                driver->counters().packets);
    }
  }
}

}  // namespace
}  // namespace lidard::test
