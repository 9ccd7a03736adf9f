// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "drivers/address.h"

namespace lidard {

/// A device that answered.
struct FoundDevice {
  std::string vendor, product, serial, firmware;
  IpAddress address;
  std::string model;  ///< name in the configuration; empty: the answer does not tell
};

struct DiscoverOptions {
  std::vector<Endpoint> hokuyos;  ///< asked one by one; the default is the address they are delivered with
  std::vector<Endpoint> sicks;    ///< where the search goes; empty: broadcast on every interface
  double wait = 2;                ///< s
  bool json = false;
};

/// The search telegram of SICK devices (UDP 30718, as sick_scan_xd sends it; unverified on a device): 24
/// bytes.
std::array<std::uint8_t, 24> sick_search(std::uint32_t key, const IpAddress& own, const IpAddress& mask);
/// What a device answered to it; empty if the datagram is no such answer.
std::optional<FoundDevice> read_sick_answer(ByteView datagram, const IpAddress& sender);
/// What a Hokuyo answered to VV; empty while the answer is not complete.
std::optional<FoundDevice> read_hokuyo_answer(ByteView stream, const IpAddress& sender);

/// `lidard discover`: which devices answer, as a table or JSON. Changes nothing in them. Returns the exit
/// code: 1 if none answered.
int run_discover(const DiscoverOptions& options, std::ostream& out, std::ostream& err);

}  // namespace lidard
