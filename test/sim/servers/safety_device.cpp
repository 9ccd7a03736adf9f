// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/safety_device.h"

namespace lidard::sim {
namespace {

// SICK 8022708 p. 14-15: length of all the data 8, number of the data set 12, offset in it 16.
constexpr std::size_t header_bytes = 24;
// SICK 8022708 p. 16: the scan's number in the data.
constexpr std::size_t number_at = 12;

}  // namespace

std::optional<Endpoint> LiveSafetyScanner::destination(ByteView datagram) {
  std::optional<Endpoint> to;
  server_.with<SafetyDevice>([&](SafetyDevice& device) {
    collect(datagram, device.settings.latest);
    const SafetySettings::Output& output = device.settings.current;
    const bool due = output.every <= 1 || datagram.le32(number_at) % output.every == 0;
    if (output.enabled && due) to = Endpoint{output.host, output.port};
  });
  return to;
}

void LiveSafetyScanner::collect(ByteView datagram, SafetySettings::Bytes& latest) {
  if (datagram.le32(16) == 0) collected_.clear();
  const ByteView piece = datagram.from(header_bytes);
  collected_.insert(collected_.end(), piece.begin(), piece.end());
  if (collected_.size() == datagram.le32(8)) latest = collected_;
}

}  // namespace lidard::sim
