// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/net/udp_socket.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace lidard {
namespace {

/// Buffer space of a datagram of up to 1500 bytes (measured). SO_RCVBUF counts half of it, since the kernel
/// doubles the number.
constexpr double buffer_bytes_per_packet = 2304.0 / 2;
constexpr int most_filtered_senders = 200;  // jump distances of classic BPF end at 255

template <class T>
bool set_option(int fd, int level, int name, const T& value) {
  return setsockopt(fd, level, name, &value, sizeof value) == 0;
}

int get_option(int fd, int level, int name) {
  int value = 0;
  socklen_t size = sizeof value;
  return getsockopt(fd, level, name, &value, &size) == 0 ? value : 0;
}

in_addr to_in_addr(const IpAddress& address) {
  in_addr raw{};
  std::memcpy(&raw, address.bytes.data(), sizeof raw);
  return raw;
}

IpAddress from_in_addr(const in_addr& raw) {
  IpAddress address;
  std::memcpy(address.bytes.data(), &raw, sizeof raw);
  return address;
}

sock_filter statement(unsigned code, std::uint32_t k) { return {static_cast<std::uint16_t>(code), 0, 0, k}; }

/// Accepts the listed senders, and 1 of 64 datagrams of all others so that they can be reported.
bool attach_sender_filter(int fd, const std::vector<IpAddress>& senders) {
  constexpr std::uint32_t source_in_ip_header = 12;
  constexpr std::uint32_t accept_whole = 0xffffffffU;
  std::vector<sock_filter> program;
  program.push_back(
      statement(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(SKF_NET_OFF) + source_in_ip_header));
  const std::size_t n = senders.size();
  for (std::size_t i = 0; i < n; ++i) {
    const auto to_accept = static_cast<std::uint8_t>(n - i - 1 + 4);
    program.push_back({BPF_JMP | BPF_JEQ | BPF_K, to_accept, 0, ntohl(to_in_addr(senders[i]).s_addr)});
  }
  program.push_back(
      statement(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(SKF_AD_OFF + SKF_AD_RANDOM)));
  program.push_back(statement(BPF_ALU | BPF_AND | BPF_K, 63));
  program.push_back({BPF_JMP | BPF_JEQ | BPF_K, 1, 0, 0});
  program.push_back(statement(BPF_RET | BPF_K, 0));
  program.push_back(statement(BPF_RET | BPF_K, accept_whole));
  const sock_fprog code = {static_cast<unsigned short>(program.size()), program.data()};
  return set_option(fd, SOL_SOCKET, SO_ATTACH_FILTER, code);
}

void size_receive_buffer(int fd, const UdpOptions& options, UdpLimits& limits) {
  const auto current = static_cast<std::size_t>(get_option(fd, SOL_SOCKET, SO_RCVBUF)) / 2;
  limits.buffer_asked = options.receive_buffer;
  if (limits.buffer_asked == 0) {
    const double wanted = options.packets_per_s * seconds(options.tolerated_stall) * buffer_bytes_per_packet;
    limits.buffer_asked = static_cast<std::size_t>(std::clamp(wanted, 0.0, 1e9));
  }
  if (options.receive_buffer != 0 || limits.buffer_asked > current)
    set_option(fd, SOL_SOCKET, SO_RCVBUF, static_cast<int>(limits.buffer_asked));
  limits.buffer_got = static_cast<std::size_t>(get_option(fd, SOL_SOCKET, SO_RCVBUF)) / 2;
  const double packets = static_cast<double>(limits.buffer_got) / buffer_bytes_per_packet;
  limits.buffer_lasts = span_from_seconds(packets / std::max(1.0, options.packets_per_s));
}

ip_mreqn membership_of(const MulticastGroup& group) {
  ip_mreqn request{};
  request.imr_multiaddr = to_in_addr(group.group);
  if (group.interface.empty()) return request;
  if (const auto address = IpAddress::parse(group.interface))
    request.imr_address = to_in_addr(*address);
  else
    request.imr_ifindex = static_cast<int>(if_nametoindex(group.interface.c_str()));
  return request;
}

}  // namespace

UdpLimits limit_socket(int fd, const UdpOptions& options) {
  UdpLimits limits;
  if (!options.senders.empty() && options.senders.size() <= most_filtered_senders)
    limits.filtered = attach_sender_filter(fd, options.senders);
  else
    set_option(fd, SOL_SOCKET, SO_DETACH_FILTER, 0);
  size_receive_buffer(fd, options, limits);
  return limits;
}

UdpSocket open_udp_socket(const UdpOptions& options) {
  UdpSocket s;
  const auto failed = [&s] {
    s.fault.error = errno;
    return std::move(s);
  };
  s.fd = FileDescriptor(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int fd = s.fd.get();
  if (fd < 0) return failed();
  if (!set_option(fd, SOL_SOCKET, SO_TIMESTAMPNS, 1) || !set_option(fd, SOL_SOCKET, SO_RXQ_OVFL, 1) ||
      !set_option(fd, IPPROTO_IP, IP_PKTINFO, 1))
    return failed();
  // Without this, datagrams of groups that other programs of this host joined are received too.
  set_option(fd, IPPROTO_IP, IP_MULTICAST_ALL, 0);
  if (options.share_port) set_option(fd, SOL_SOCKET, SO_REUSEADDR, 1);
  s.limits = limit_socket(fd, options);
  sockaddr_in local{};
  local.sin_family = AF_INET;
  local.sin_port = htons(options.port);
  local.sin_addr = to_in_addr(options.address);
  socklen_t size = sizeof local;
  if (bind(fd, reinterpret_cast<const sockaddr*>(&local), size) != 0) return failed();
  getsockname(fd, reinterpret_cast<sockaddr*>(&local), &size);
  s.port = ntohs(local.sin_port);
  return s;
}

void leave_group(int fd, const MulticastGroup& group) {
  set_option(fd, IPPROTO_IP, IP_DROP_MEMBERSHIP, membership_of(group));
}

int join_group(int fd, const MulticastGroup& group) {
  const ip_mreqn request = membership_of(group);
  if (!group.interface.empty() && request.imr_ifindex == 0 && request.imr_address.s_addr == 0) return ENXIO;
  return set_option(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, request) || errno == EADDRINUSE ? 0 : errno;
}

bool receive_buffer_is_filling(int fd) {
  std::array<std::uint32_t, SK_MEMINFO_VARS> info{};
  socklen_t size = sizeof info;
  if (getsockopt(fd, SOL_SOCKET, SO_MEMINFO, info.data(), &size) != 0) return true;
  return info[SK_MEMINFO_RMEM_ALLOC] > info[SK_MEMINFO_RCVBUF] / 2;
}

struct DatagramBatch::Storage {
  /// Room for a time stamp, the drop counter and the destination address.
  static constexpr std::size_t control_size =
      CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(std::uint32_t)) + CMSG_SPACE(sizeof(in_pktinfo));
  struct alignas(cmsghdr) Control {
    std::array<char, control_size> bytes;
  };
  std::unique_ptr<std::uint8_t[]> payloads;
  std::array<mmsghdr, capacity> messages{};
  std::array<iovec, capacity> vectors{};
  std::array<sockaddr_in, capacity> senders{};
  std::array<Control, capacity> controls{};
};

DatagramBatch::DatagramBatch(std::size_t max_datagram)
    : max_datagram_(max_datagram), storage_(std::make_unique<Storage>()) {
  // 2 MB, of which short datagrams touch a few pages: not to be filled with zeros.
  storage_->payloads.reset(new std::uint8_t[capacity * max_datagram]);
}
DatagramBatch::~DatagramBatch() = default;

int DatagramBatch::receive(int fd) {
  Storage& s = *storage_;
  for (std::size_t i = 0; i < capacity; ++i) {
    s.vectors[i] = {s.payloads.get() + i * max_datagram_, max_datagram_};
    msghdr& header = s.messages[i].msg_hdr;
    header = {};
    header.msg_name = &s.senders[i];
    header.msg_namelen = sizeof s.senders[i];
    header.msg_iov = &s.vectors[i];
    header.msg_iovlen = 1;
    header.msg_control = s.controls[i].bytes.data();
    header.msg_controllen = s.controls[i].bytes.size();
  }
  return recvmmsg(fd, s.messages.data(), capacity, MSG_DONTWAIT, nullptr);
}

DatagramBatch::Datagram DatagramBatch::operator[](std::size_t i) const {
  const Storage& s = *storage_;
  // The macros for control data need a writable header.
  auto* header = const_cast<msghdr*>(&s.messages[i].msg_hdr);
  Datagram d;
  d.payload = ByteView(s.payloads.get() + i * max_datagram_, s.messages[i].msg_len);
  d.truncated = (header->msg_flags & MSG_TRUNC) != 0;
  d.from = {from_in_addr(s.senders[i].sin_addr), ntohs(s.senders[i].sin_port)};
  for (cmsghdr* c = CMSG_FIRSTHDR(header); c != nullptr; c = CMSG_NXTHDR(header, c)) {
    if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_TIMESTAMPNS) {
      timespec time{};
      std::memcpy(&time, CMSG_DATA(c), sizeof time);
      d.kernel_stamp = HostStamp{time.tv_sec * 1'000'000'000 + time.tv_nsec};
    } else if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&d.drops, CMSG_DATA(c), sizeof d.drops);
    } else if (c->cmsg_level == IPPROTO_IP && c->cmsg_type == IP_PKTINFO) {
      in_pktinfo info{};
      std::memcpy(&info, CMSG_DATA(c), sizeof info);
      d.to = from_in_addr(info.ipi_addr);
    }
  }
  return d;
}

}  // namespace lidard
