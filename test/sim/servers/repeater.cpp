// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/repeater.h"

#include <map>

#include "drivers/velodyne/packet.h"

namespace lidard::sim {
namespace {

constexpr std::uint32_t us_per_hour = 3'600'000'000;

bool is_velodyne(const std::vector<std::uint8_t>& payload) {
  if (payload.size() != velodyne::packet_size) return false;
  return velodyne::DataPacket(ByteView(payload.data(), payload.size())).flag(0) == velodyne::flag_lasers_0_31;
}

/// What one sender sends to one port.
struct Flow {
  Stamp first, last;
  std::int64_t packets = 0;
};

/// The stamp counts microseconds since the full hour.
void move_stamp(std::vector<std::uint8_t>& payload, std::uint64_t by_us) {
  const velodyne::DataPacket packet(ByteView(payload.data(), payload.size()));
  const std::uint64_t moved = (packet.stamp_us() + by_us) % us_per_hour;
  for (std::size_t i = 0; i < 4; ++i)
    payload[velodyne::stamp_offset + i] = static_cast<std::uint8_t>(moved >> (8 * i));
}

}  // namespace

Repeater::Repeater(PcapSource& capture) {
  for (Packet p; capture.next(p);)
    if (p.transport == Transport::udp)
      packets_.push_back({{p.payload.begin(), p.payload.end()}, p.arrival, p.from, p.to});
  std::map<std::pair<Endpoint, std::uint16_t>, Flow> flows;
  for (const Recorded& packet : packets_) {
    Flow& flow = flows[{packet.from, packet.to.port}];
    if (flow.packets++ == 0) flow.first = packet.arrival;
    flow.last = packet.arrival;
  }
  std::int64_t most = 1;
  for (const auto& [key, flow] : flows) {
    if (flow.packets <= most) continue;
    most = flow.packets;
    const std::int64_t whole = (flow.last - flow.first).count();
    period_ = std::chrono::microseconds((whole + whole / (flow.packets - 1) + 500) / 1000);
  }
}

void Repeater::play(std::uint64_t times, const std::function<void(const Packet&)>& use) {
  std::vector<std::uint8_t> payload;
  for (std::uint64_t turn = 0; turn < times; ++turn) {
    const Span later = period_ * static_cast<std::int64_t>(turn);
    for (const Recorded& recorded : packets_) {
      payload = recorded.payload;
      if (is_velodyne(payload)) move_stamp(payload, static_cast<std::uint64_t>(later.count() / 1000));
      Packet packet;
      packet.payload = ByteView(payload.data(), payload.size());
      packet.arrival = recorded.arrival + later;
      packet.from = recorded.from;
      packet.to = recorded.to;
      use(packet);
    }
  }
}

}  // namespace lidard::sim
