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
  bool up = false;        ///< administratively up
  bool has_link = false;  ///< the cable is connected to a running peer
  bool loopback = false;
  std::uint32_t packets = 0;  ///< received; wraps

  /// True if that address belongs to the network of this one.
  bool reaches(const IpAddress& other) const;
  /// "lidar0 (192.168.1.100/24)".
  std::string to_string() const;
};

/// The network state of this host that the kernel reports without privileges, also to a service with
/// ProcSubset=pid.
struct HostNetwork {
  std::vector<HostInterface> interfaces;
  std::uint64_t dropped_by_path = 0;  ///< packets that the reverse path filter (rp_filter) dropped
  std::uint64_t without_port = 0;     ///< datagrams to a port without a listener
  std::uint64_t for_others = 0;       ///< received packets for an address that this host does not have
  /// Received packets that reached no program and are counted nowhere: those that a firewall drops, and those
  /// of multicast groups that nobody joined.
  std::uint64_t undelivered = 0;
};
HostNetwork read_network();

/// The hardware addresses of this host's neighbours (ARP).
std::map<IpAddress, std::string> read_neighbours();

/// True if the kernel has a route to the address, direct or through a gateway.
bool has_route_to(const IpAddress& address);

/// Who has bound a UDP port of this host, as far as known.
struct PortHolder {
  std::string user;              ///< its number; empty: not known
  std::string program, process;  ///< name and number; empty: not accessible
};
/// The call needs milliseconds.
PortHolder holder_of_udp_port(std::uint16_t port);

}  // namespace lidard
