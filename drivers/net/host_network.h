// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "drivers/address.h"

namespace lidard {

/// An IPv4 address of this host and its interface; an interface without an address has an entry, too.
struct HostInterface {
  std::string name;
  IpAddress address;      ///< 0.0.0.0: none
  unsigned prefix = 0;    ///< bits of the address that name its network
  bool up = false;        ///< somebody switched it on
  bool has_link = false;  ///< there is somebody at the other end of the cable
  bool loopback = false;
  std::uint32_t packets = 0;  ///< that came in; wraps

  /// True if that address belongs to the network of this one.
  bool reaches(const IpAddress& other) const;
  /// "lidar0 (192.168.1.100/24)".
  std::string to_string() const;
};

/// What the kernel tells everybody of the network of this host, without a privilege, and in a service that
/// sees nothing of /proc but its own process (ProcSubset=pid).
struct HostNetwork {
  std::vector<HostInterface> interfaces;
  std::uint64_t dropped_by_path = 0;  ///< packets that the reverse path filter (rp_filter) dropped
  std::uint64_t without_port = 0;     ///< datagrams that came to a port where nobody listened
  std::uint64_t for_others = 0;       ///< packets that came in for an address that this host does not have
};
HostNetwork read_network();

/// The hardware addresses of this host's neighbours as the kernel heard them last (ARP).
std::map<IpAddress, std::string> read_neighbours();

/// True if the kernel knows a way to that address, be it through a gateway.
bool has_route_to(const IpAddress& address);

/// Who has a UDP port of this host: "velodyne_node (process 4711)", or "a program of user 1000" where another
/// user's programs cannot be looked at; empty: not known. Takes milliseconds.
std::string holder_of_udp_port(std::uint16_t port);

}  // namespace lidard
