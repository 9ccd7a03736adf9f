// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/base/bytes.h"

namespace lidard {

/// What the reading of a header came to.
enum class HeaderResult : std::uint8_t {
  ok,
  not_ip,       ///< another protocol
  unsupported,  ///< a link-layer type we do not read
  cut,          ///< the bytes end before the header does
  malformed     ///< the header contradicts itself
};

/// The network-layer packet inside a link-layer frame.
struct LinkPayload {
  ByteView bytes;  ///< from the IP header to the end of the frame, padding included
  bool v6 = false;
};

/// Finds the IP packet in a frame of the given link-layer type, a LINKTYPE_ or DLT_ number
/// (tcpdump.org/linktypes.html): Ethernet with any number of VLAN tags, Linux cooked v1 and v2, raw IP, null,
/// loop.
HeaderResult find_ip(std::uint32_t link_type, ByteView frame, LinkPayload& out);

}  // namespace lidard
