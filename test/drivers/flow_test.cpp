// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/flow.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/registry/registry.h"

namespace lidard {
namespace {

using testing::ElementsAre;

const IpAddress ours = IpAddress::v4(192, 168, 0, 100);
const IpAddress first = IpAddress::v4(192, 168, 0, 21);
const IpAddress second = IpAddress::v4(192, 168, 0, 22);

Packet datagram(const IpAddress& from, std::uint16_t port) {
  Packet packet;
  packet.from = {from, 40000};
  packet.to = {ours, port};
  return packet;
}

Packet chunk(const Endpoint& from, const Endpoint& to) {
  Packet packet;
  packet.from = from;
  packet.to = to;
  packet.transport = Transport::tcp;
  return packet;
}

TEST(Flow, OfADatagramHasThePortItWasSentToAndOfAChunkTheDevicesOwn) {
  EXPECT_EQ(flow_of(datagram(first, 2368)), (Flow{Transport::udp, first, 2368}));
  EXPECT_EQ(flow_of(chunk({first, 2112}, {ours, 50000})), (Flow{Transport::tcp, first, 2112}));
  EXPECT_EQ(flow_of(datagram(first, 2368)).to_string(), "192.168.0.21 -> port 2368");
  EXPECT_EQ(flow_of(chunk({first, 2112}, {ours, 50000})).to_string(), "192.168.0.21:2112 over TCP");
}

TEST(Flow, OfADeviceAreItsDataItsTelemetryAndItsPartOfTheDialogue) {
  Model model = *find_model("sick_picoscan150");
  EXPECT_THAT(flows_of(model, first, 2115, 7503, 2111),
              ElementsAre(Flow{Transport::udp, first, 2115}, Flow{Transport::udp, first, 7503},
                          Flow{Transport::tcp, first, 2111}));
  EXPECT_THAT(flows_of(model, first, 2115, 0, 0), ElementsAre(Flow{Transport::udp, first, 2115}));
  model.transport = Transport::tcp;
  EXPECT_THAT(flows_of(model, first, 2112, 7503, 2111), ElementsAre(Flow{Transport::tcp, first, 2112}))
      << "one connection carries data and dialogue";
}

TEST(FlowTable, AKnownSenderComesBeforeAnybody) {
  FlowTable<int> owners;
  owners.add({Transport::udp, IpAddress(), 2368}, 1);
  owners.add({Transport::udp, first, 2368}, 2);
  owners.add({Transport::udp, first, 2368}, 3);
  ASSERT_NE(owners.find(datagram(first, 2368)), nullptr);
  EXPECT_EQ(*owners.find(datagram(first, 2368)), 2) << "the first owner of a flow keeps it";
  ASSERT_NE(owners.find(datagram(second, 2368)), nullptr);
  EXPECT_EQ(*owners.find(datagram(second, 2368)), 1);
  EXPECT_EQ(owners.find(datagram(first, 2369)), nullptr);
  EXPECT_EQ(owners.find(chunk({first, 2368}, {ours, 50000})), nullptr) << "another transport";
}

TEST(FlowTable, KnowsTheDeviceThatAChunkWasSentTo) {
  FlowTable<int> owners;
  owners.add({Transport::tcp, first, 2112}, 1);
  const Packet request = chunk({ours, 50000}, {first, 2112});
  EXPECT_EQ(owners.find(request), nullptr);
  ASSERT_NE(owners.find_receiver(request), nullptr);
  EXPECT_EQ(owners.find_receiver(chunk({first, 2112}, {ours, 50000})), nullptr);
  EXPECT_EQ(owners.find_receiver(chunk({ours, 50000}, {second, 2112})), nullptr);
}

}  // namespace
}  // namespace lidard
