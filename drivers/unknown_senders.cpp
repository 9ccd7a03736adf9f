// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/unknown_senders.h"

#include <algorithm>

namespace lidard {
namespace {

/// The newest senders, against forged ones.
constexpr std::size_t most_names = 32;

std::string name_of(const Flow& flow, std::uint64_t packets) {
  return flow.to_string() + " (" + std::to_string(packets) + " packets)";
}

}  // namespace

void UnknownSenders::note(const Packet& packet) {
  const Flow flow = flow_of(packet);
  if (senders_.size() == most_names && senders_.count(flow) == 0)
    senders_.erase(std::min_element(senders_.begin(), senders_.end(), [](const auto& a, const auto& b) {
      return a.second.last < b.second.last;
    }));
  Sender& sender = senders_[flow];
  sender.packets += packet.stands_for;
  sender.last = packet.arrival;
}

std::vector<std::string> UnknownSenders::names(Stamp since) const {
  std::vector<std::string> names;
  for (const auto& [flow, sender] : senders_) {
    if (sender.last >= since) names.push_back(name_of(flow, sender.packets));
  }
  return names;
}

std::string UnknownSenders::sender_to(std::uint16_t port, Stamp since) const {
  for (const auto& [flow, sender] : senders_) {
    if (flow.transport == Transport::udp && flow.port == port && sender.last >= since)
      return name_of(flow, sender.packets);
  }
  return {};
}

}  // namespace lidard
