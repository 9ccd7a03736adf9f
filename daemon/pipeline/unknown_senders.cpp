// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/unknown_senders.h"

namespace lidard {
namespace {

/// So many are remembered by name; a flood of forged ones must not grow memory.
constexpr std::size_t most_names = 32;

std::string name_of(const Flow& flow, std::uint64_t packets) {
  return flow.to_string() + " (" + std::to_string(packets) + " packets)";
}

}  // namespace

void UnknownSenders::note(const Packet& packet) {
  const Flow flow = flow_of(packet);
  const auto entry = packets_.find(flow);
  if (entry != packets_.end()) {
    ++entry->second;
  } else if (packets_.size() < most_names) {
    packets_.emplace(flow, 1);
  } else {
    ++not_named_;
  }
}

std::vector<std::string> UnknownSenders::names() const {
  std::vector<std::string> senders;
  for (const auto& [flow, packets] : packets_) senders.push_back(name_of(flow, packets));
  if (not_named_ > 0) senders.push_back("further senders (" + std::to_string(not_named_) + " packets)");
  return senders;
}

std::string UnknownSenders::sender_to(std::uint16_t port) const {
  for (const auto& [flow, packets] : packets_) {
    if (flow.transport == Transport::udp && flow.port == port) return name_of(flow, packets);
  }
  return {};
}

}  // namespace lidard
