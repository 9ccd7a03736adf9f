// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/discover.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <ostream>
#include <random>

#include "daemon/config/exit_codes.h"

namespace lidard {
namespace {

constexpr std::uint16_t sick_port = 30718;
constexpr std::size_t longest_answer = 8192;

sockaddr_in to_sockaddr(const Endpoint& endpoint) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(endpoint.port);
  std::memcpy(&address.sin_addr, endpoint.address.bytes.data(), 4);
  return address;
}

IpAddress address_of(const sockaddr* address) {
  IpAddress ip;
  if (address == nullptr) return ip;
  sockaddr_in v4{};
  std::memcpy(&v4, address, sizeof v4);
  std::memcpy(ip.bytes.data(), &v4.sin_addr, 4);
  return ip;
}

/// A socket that closes itself.
class Socket {
 public:
  explicit Socket(int type) : fd_(::socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {}
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(Socket&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  Socket& operator=(Socket&&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

/// A TCP connection to what may be a Hokuyo.
struct Asked {
  Socket socket{SOCK_STREAM};
  Endpoint to;
  bool sent = false, done = false;
  std::string stream;
};

class Search {
 public:
  explicit Search(const DiscoverOptions& options) : options_(options) {}

  std::vector<FoundDevice> run() {
    search_sicks();
    for (const Endpoint& endpoint : options_.hokuyos) ask(endpoint);
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options_.wait);
    while (std::chrono::steady_clock::now() < end && anything_open()) wait();
    std::sort(found_.begin(), found_.end(),
              [](const FoundDevice& a, const FoundDevice& b) { return a.address < b.address; });
    return std::move(found_);
  }
  const std::vector<std::string>& places() const { return places_; }

 private:
  /// One datagram from each interface's own address, so that its answers come back to it.
  void search_sicks() {
    std::random_device random;
    const std::uint32_t key = random();
    if (!options_.sicks.empty()) {
      for (const Endpoint& to : options_.sicks) send_search(key, IpAddress(), IpAddress(), to);
      return;
    }
    ifaddrs* all = nullptr;
    if (::getifaddrs(&all) != 0) return;
    for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
      const bool usable = each->ifa_addr != nullptr && each->ifa_addr->sa_family == AF_INET &&
                          (each->ifa_flags & IFF_UP) != 0 && (each->ifa_flags & IFF_BROADCAST) != 0;
      if (!usable) continue;
      const IpAddress own = address_of(each->ifa_addr);
      send_search(key, own, address_of(each->ifa_netmask), {address_of(each->ifa_broadaddr), sick_port});
    }
    ::freeifaddrs(all);
  }

  void send_search(std::uint32_t key, const IpAddress& own, const IpAddress& mask, const Endpoint& to) {
    Socket socket(SOCK_DGRAM);
    const int on = 1;
    ::setsockopt(socket.fd(), SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
    const sockaddr_in from = to_sockaddr({own, 0});
    ::bind(socket.fd(), reinterpret_cast<const sockaddr*>(&from), sizeof from);
    const auto request = sick_search(key, own, mask);
    const sockaddr_in address = to_sockaddr(to);
    const auto sent = ::sendto(socket.fd(), request.data(), request.size(), 0,
                               reinterpret_cast<const sockaddr*>(&address), sizeof address);
    if (sent < 0) return;
    places_.push_back(to.to_string());
    searches_.push_back(std::move(socket));
  }

  void ask(const Endpoint& to) {
    Asked asked;
    asked.to = to;
    const sockaddr_in address = to_sockaddr(to);
    const int result =
        ::connect(asked.socket.fd(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
    if (result != 0 && errno != EINPROGRESS) return;
    places_.push_back(to.to_string());
    asked_.push_back(std::move(asked));
  }

  bool anything_open() const {
    return !searches_.empty() ||
           std::any_of(asked_.begin(), asked_.end(), [](const Asked& asked) { return !asked.done; });
  }

  void wait() {
    std::vector<pollfd> waiting;
    for (const Socket& socket : searches_) waiting.push_back({socket.fd(), POLLIN, 0});
    for (const Asked& asked : asked_) {
      const auto events = static_cast<short>(asked.sent ? POLLIN : POLLOUT);
      waiting.push_back({asked.done ? -1 : asked.socket.fd(), events, 0});
    }
    constexpr int slice_ms = 50;
    ::poll(waiting.data(), waiting.size(), slice_ms);
    for (std::size_t i = 0; i < searches_.size(); ++i) {
      if (waiting[i].revents != 0) read_search(searches_[i]);
    }
    for (std::size_t i = 0; i < asked_.size(); ++i) {
      if (waiting[searches_.size() + i].revents != 0) go_on(asked_[i]);
    }
  }

  void read_search(const Socket& socket) {
    std::array<std::uint8_t, longest_answer> buffer{};
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const auto got =
        ::recvfrom(socket.fd(), buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (got <= 0) return;
    const ByteView datagram(buffer.data(), static_cast<std::size_t>(got));
    const auto device = read_sick_answer(datagram, address_of(reinterpret_cast<sockaddr*>(&from)));
    if (device) keep(*device);
  }

  void go_on(Asked& asked) {
    if (!asked.sent) {
      constexpr std::string_view who = "VV\n";
      asked.sent = true;
      if (::send(asked.socket.fd(), who.data(), who.size(), MSG_NOSIGNAL) < 0) asked.done = true;
      return;
    }
    std::array<char, 2048> buffer{};
    const auto got = ::recv(asked.socket.fd(), buffer.data(), buffer.size(), 0);
    if (got > 0) asked.stream.append(buffer.data(), static_cast<std::size_t>(got));
    const auto device = read_hokuyo_answer(ByteView(asked.stream), asked.to.address);
    if (device) keep(*device);
    asked.done = device || got <= 0 || asked.stream.size() > longest_answer;
  }

  void keep(const FoundDevice& device) {
    for (const FoundDevice& other : found_) {
      if (other.address == device.address && other.serial == device.serial) return;
    }
    found_.push_back(device);
  }

  const DiscoverOptions& options_;
  std::vector<Socket> searches_;
  std::vector<Asked> asked_;
  std::vector<std::string> places_;
  std::vector<FoundDevice> found_;
};

using Row = std::array<std::string, 6>;

void print_table(const std::vector<FoundDevice>& found, std::ostream& out) {
  std::vector<Row> rows{{"address", "vendor", "product", "serial", "firmware", "model"}};
  for (const FoundDevice& device : found)
    rows.push_back({device.address.to_string(), device.vendor, device.product, device.serial, device.firmware,
                    device.model.empty() ? "see `lidard models`" : device.model});
  std::array<std::size_t, 6> widths{};
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const Row& row : rows) {
    for (std::size_t i = 0; i + 1 < row.size(); ++i)
      out << row[i] << std::string(widths[i] - row[i].size() + 2, ' ');
    out << row.back() << '\n';
  }
}

void print_json(const std::vector<FoundDevice>& found, std::ostream& out) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const FoundDevice& device : found)
    list.push_back({{"address", device.address.to_string()},
                    {"vendor", device.vendor},
                    {"product", device.product},
                    {"serial", device.serial},
                    {"firmware", device.firmware},
                    {"model", device.model}});
  out << list.dump(2) << '\n';
}

}  // namespace

int run_discover(const DiscoverOptions& options, std::ostream& out, std::ostream& err) {
  Search search(options);
  const std::vector<FoundDevice> found = search.run();
  if (options.json) {
    print_json(found, out);
  } else if (!found.empty()) {
    print_table(found, out);
  }
  if (!found.empty()) return 0;
  err << "nothing answered within " << options.wait << " s from";
  for (const std::string& place : search.places()) err << ' ' << place;
  err << (search.places().empty() ? " anywhere: no interface is up" : "")
      << "; check power and cable, give this computer an address in the device's network, or name a Hokuyo's "
         "address with --hokuyo\n";
  return 1;
}

}  // namespace lidard
