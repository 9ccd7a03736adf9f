// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/bytes.h"
#include "drivers/address.h"
#include "drivers/driver.h"

namespace lidard {

/// A device that answered.
struct FoundDevice {
  std::string vendor, product, serial, firmware;
  IpAddress address;
  std::string model;  ///< name in the configuration; empty: not in the answer
};

/// Search for the devices of one vendor in a network. The question changes no setting.
struct Discovery {
  std::string_view name;  ///< of the command's option: "hokuyo"
  std::string_view vendor;
  /// UDP: one datagram, and each datagram that comes back may be an answer. TCP: the question goes to one
  /// device, whose answer may come in pieces.
  Transport transport = Transport::udp;
  std::uint16_t port = 0;
  /// The factory address of devices; empty: the question is broadcast on every interface.
  std::string_view usual_address;
  /// `key`: an arbitrary number that answers may repeat; `own` and `mask`: of the sending interface.
  std::string (*question)(std::uint32_t key, const IpAddress& own, const IpAddress& mask) = nullptr;
  /// Parses all that `sender` has sent so far; empty: no answer, or an incomplete one.
  std::optional<FoundDevice> (*read_answer)(ByteView answer, const IpAddress& sender) = nullptr;
};

}  // namespace lidard
