// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace lidard {

/// An IPv4 or IPv6 address. IPv4 stands in the first four bytes.
struct IpAddress {
  std::array<std::uint8_t, 16> bytes{};
  bool v6 = false;

  static IpAddress v4(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
    return {{a, b, c, d}, false};
  }
  /// Empty if `text` is not an address in the usual notation.
  static std::optional<IpAddress> parse(const std::string& text);
  std::string to_string() const;
  bool is_multicast() const { return v6 ? bytes[0] == 0xff : (bytes[0] & 0xf0U) == 0xe0U; }

  friend bool operator==(const IpAddress& a, const IpAddress& b) {
    return a.v6 == b.v6 && a.bytes == b.bytes;
  }
  friend bool operator!=(const IpAddress& a, const IpAddress& b) { return !(a == b); }
  friend bool operator<(const IpAddress& a, const IpAddress& b) {
    return a.v6 != b.v6 ? a.v6 < b.v6 : a.bytes < b.bytes;
  }
};

/// An address and a port.
struct Endpoint {
  IpAddress address;
  std::uint16_t port = 0;

  /// "192.168.0.1:2368", "[fe80::1]:2368".
  std::string to_string() const;
  friend bool operator==(const Endpoint& a, const Endpoint& b) {
    return a.address == b.address && a.port == b.port;
  }
  friend bool operator<(const Endpoint& a, const Endpoint& b) {
    return a.address == b.address ? a.port < b.port : a.address < b.address;
  }
};

}  // namespace lidard
