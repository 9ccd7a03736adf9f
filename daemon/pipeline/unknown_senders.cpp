// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/unknown_senders.h"

namespace lidard {
namespace {

/// So many are remembered by name; a flood of forged ones must not grow memory.
constexpr std::size_t most_names = 32;

}  // namespace

void UnknownSenders::note(const Packet& packet) {
  const bool datagram = packet.transport == Transport::udp;
  const std::pair key(packet.transport,
                      Endpoint{packet.from.address, datagram ? packet.to.port : packet.from.port});
  const auto entry = packets_.find(key);
  if (entry != packets_.end()) {
    ++entry->second;
  } else if (packets_.size() < most_names) {
    packets_.emplace(key, 1);
  } else {
    ++not_named_;
  }
}

std::vector<std::string> UnknownSenders::names() const {
  std::vector<std::string> senders;
  for (const auto& [key, count] : packets_) {
    const auto& [transport, sender] = key;
    const std::string which = transport == Transport::udp
                                  ? sender.address.to_string() + " -> port " + std::to_string(sender.port)
                                  : sender.to_string() + " over TCP";
    senders.push_back(which + " (" + std::to_string(count) + " packets)");
  }
  if (not_named_ > 0) senders.push_back("further senders (" + std::to_string(not_named_) + " packets)");
  return senders;
}

}  // namespace lidard
