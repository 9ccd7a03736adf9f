// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/net/host_network.h"

#include <arpa/inet.h>
#include <glob.h>
#include <ifaddrs.h>
#include <linux/if_link.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "drivers/file_descriptor.h"

namespace lidard {
namespace {

std::uint32_t bits(const IpAddress& address) {
  std::uint32_t raw = 0;
  std::memcpy(&raw, address.bytes.data(), sizeof raw);
  return ntohl(raw);
}

IpAddress address_in(const sockaddr* from) {
  sockaddr_in raw{};
  std::memcpy(&raw, from, sizeof raw);
  IpAddress address;
  std::memcpy(address.bytes.data(), &raw.sin_addr, sizeof raw.sin_addr);
  return address;
}

/// Reads the counters of /proc/net/netstat or snmp, which have a line of names before every line of numbers:
/// "Udp:NoPorts".
void read_counters(const char* file, std::map<std::string, std::uint64_t>& counters) {
  std::ifstream in(file);
  for (std::string line, numbers; std::getline(in, line) && std::getline(in, numbers);) {
    std::istringstream names(line), values(numbers);
    std::string table, name, value;
    names >> table, values >> value;
    while (names >> name && values >> value)
      counters[table + name] = std::strtoull(value.c_str(), nullptr, 10);
  }
}

/// What was received and not delivered to a protocol of this host, less what the kernel counts as dropped for
/// another reason (RFC 4293, ipSystemStatsTable; a firewall's drop has no counter of its own).
std::uint64_t undelivered(std::map<std::string, std::uint64_t>& counters) {
  std::uint64_t known = counters["Ip:InDelivers"] + counters["Ip:ReasmReqds"] - counters["Ip:ReasmOKs"];
  for (const char* reason : {"Ip:InHdrErrors", "Ip:InAddrErrors", "Ip:ForwDatagrams", "Ip:InUnknownProtos",
                             "Ip:InDiscards", "IpExt:InNoRoutes", "TcpExt:IPReversePathFilter"})
    known += counters[reason];
  return counters["Ip:InReceives"] - std::min(known, counters["Ip:InReceives"]);
}

}  // namespace

bool HostInterface::reaches(const IpAddress& other) const {
  if (prefix == 0 || prefix > 32 || other.v6) return false;
  return (bits(address) ^ bits(other)) >> (32 - prefix) == 0;
}

std::string HostInterface::to_string() const {
  if (prefix == 0) return name;
  return name + " (" + address.to_string() + "/" + std::to_string(prefix) + ")";
}

HostNetwork read_network() {
  HostNetwork network;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return network;
  std::map<std::string, std::uint32_t> packets;
  std::map<std::string, bool> has_address;
  // getifaddrs(3) names an address by its label, eth0:1.
  const auto name_of = [](const ifaddrs& entry) {
    const std::string label = entry.ifa_name;
    return label.substr(0, label.find(':'));
  };
  const auto add = [&](const ifaddrs& entry) -> HostInterface& {
    network.interfaces.push_back({name_of(entry),
                                  {},
                                  0,
                                  (entry.ifa_flags & IFF_UP) != 0,
                                  (entry.ifa_flags & IFF_RUNNING) != 0,
                                  (entry.ifa_flags & IFF_LOOPBACK) != 0,
                                  0});
    return network.interfaces.back();
  };
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr) continue;
    if (entry->ifa_addr->sa_family == AF_PACKET && entry->ifa_data != nullptr)
      packets[name_of(*entry)] = static_cast<const rtnl_link_stats*>(entry->ifa_data)->rx_packets;
    if (entry->ifa_addr->sa_family != AF_INET || entry->ifa_netmask == nullptr) continue;
    has_address[name_of(*entry)] = true;
    HostInterface& found = add(*entry);
    found.address = address_in(entry->ifa_addr);
    for (std::uint32_t mask = bits(address_in(entry->ifa_netmask)); mask != 0; mask <<= 1U) ++found.prefix;
  }
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    const bool is_link = entry->ifa_addr != nullptr && entry->ifa_addr->sa_family == AF_PACKET;
    if (is_link && !has_address[name_of(*entry)]) add(*entry);
  }
  freeifaddrs(list);
  for (HostInterface& each : network.interfaces) each.packets = packets[each.name];
  std::map<std::string, std::uint64_t> counters;
  read_counters("/proc/self/net/netstat", counters);
  read_counters("/proc/self/net/snmp", counters);
  network.dropped_by_path = counters["TcpExt:IPReversePathFilter"];
  network.without_port = counters["Udp:NoPorts"];
  network.for_others = counters["Ip:InAddrErrors"];
  network.undelivered = undelivered(counters);
  return network;
}

std::map<IpAddress, std::string> read_neighbours() {
  std::map<IpAddress, std::string> all;
  std::ifstream in("/proc/self/net/arp");
  std::string line;
  std::getline(in, line);  // the head
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    std::string address, type, flags, hardware;
    fields >> address >> type >> flags >> hardware;
    const auto parsed = IpAddress::parse(address);
    if (parsed && flags != "0x0") all[*parsed] = hardware;
  }
  return all;
}

bool has_route_to(const IpAddress& address) {
  const FileDescriptor fd(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (fd.get() < 0) return true;  // not known: the host is out of descriptors
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(9);  // connect(2) of a datagram socket sends nothing
  std::memcpy(&to.sin_addr, address.bytes.data(), sizeof to.sin_addr);
  return connect(fd.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
}

PortHolder holder_of_udp_port(std::uint16_t port) {
  std::ifstream in("/proc/self/net/udp");  // proc(5)
  PortHolder holder;
  std::string line, inode;
  while (inode.empty() && std::getline(in, line)) {
    std::istringstream fields(line);
    std::string skipped, local, user;
    fields >> skipped >> local >> skipped >> skipped >> skipped >> skipped >> skipped >> user >> skipped;
    const std::size_t colon = local.find(':');
    if (colon != std::string::npos && std::strtoul(local.c_str() + colon + 1, nullptr, 16) == port)
      fields >> inode, holder.user = user;
  }
  if (inode.empty()) return {};
  glob_t files{};
  glob("/proc/[0-9]*/fd/*", GLOB_NOSORT, nullptr, &files);
  for (std::size_t i = 0; i < files.gl_pathc; ++i) {
    const std::filesystem::path file = files.gl_pathv[i], process = file.parent_path().parent_path();
    std::error_code gone;
    if (std::filesystem::read_symlink(file, gone) != "socket:[" + inode + "]") continue;
    std::getline(std::ifstream(process / "comm"), holder.program);
    holder.process = process.filename().string();
    break;
  }
  globfree(&files);
  return holder;
}

}  // namespace lidard
