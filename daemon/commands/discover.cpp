// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/discover.h"

#include <ifaddrs.h>
#include <net/if.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/write.hpp>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <ostream>
#include <random>

#include "daemon/commands/commands.h"
#include "daemon/files/text_table.h"

namespace lidard {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using Error = boost::system::error_code;

constexpr std::size_t longest_answer = 8192;

IpAddress address_of(const asio::ip::address_v4& address) {
  const auto bytes = address.to_bytes();
  return IpAddress::v4(bytes[0], bytes[1], bytes[2], bytes[3]);
}

IpAddress address_of(const sockaddr* address) {
  sockaddr_in v4{};
  if (address != nullptr) std::memcpy(&v4, address, sizeof v4);
  return address_of(asio::ip::address_v4(ntohl(v4.sin_addr.s_addr)));
}

asio::ip::address_v4 to_asio(const IpAddress& address) {
  return asio::ip::address_v4({address.bytes[0], address.bytes[1], address.bytes[2], address.bytes[3]});
}

/// A socket that waits for the answers to one question.
struct Listener {
  const Discovery& how;
  udp::socket socket;
  udp::endpoint from{};
  std::array<std::uint8_t, longest_answer> datagram{};
};

/// A TCP connection to a possible device.
struct Asked {
  DiscoverTarget target;
  std::string question;
  tcp::socket socket;
  std::array<char, 2048> chunk{};
  std::string stream{};
};

class Search {
 public:
  explicit Search(const DiscoverOptions& options) : options_(options) {
    std::random_device random;
    key_ = random();
  }

  std::vector<FoundDevice> run() {
    for (const DiscoverTarget& target : options_.targets) {
      if (target.how->transport == Transport::tcp)
        ask(target);
      else if (target.to.address == IpAddress())
        broadcast(target);
      else
        send(target, IpAddress(), IpAddress());
    }
    io_.run_for(std::chrono::milliseconds(std::llround(options_.wait * 1000)));
    std::sort(found_.begin(), found_.end(),
              [](const FoundDevice& a, const FoundDevice& b) { return a.address < b.address; });
    return std::move(found_);
  }
  const std::vector<std::string>& asked() const { return asked_; }

 private:
  /// Sends a datagram from the address of every interface, so that answers return to it.
  void broadcast(DiscoverTarget target) {
    ifaddrs* all = nullptr;
    if (::getifaddrs(&all) != 0) return;
    for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
      const bool usable = each->ifa_addr != nullptr && each->ifa_addr->sa_family == AF_INET &&
                          (each->ifa_flags & IFF_UP) != 0 && (each->ifa_flags & IFF_BROADCAST) != 0;
      if (!usable) continue;
      target.to.address = address_of(each->ifa_broadaddr);
      send(target, address_of(each->ifa_addr), address_of(each->ifa_netmask));
    }
    ::freeifaddrs(all);
  }

  void send(const DiscoverTarget& target, const IpAddress& own, const IpAddress& mask) {
    const auto listener = std::make_shared<Listener>(Listener{*target.how, udp::socket(io_)});
    udp::socket& socket = listener->socket;
    Error error;
    socket.open(udp::v4(), error);
    socket.set_option(asio::socket_base::broadcast(true), error);
    socket.bind({to_asio(own), 0}, error);
    socket.send_to(asio::buffer(target.how->question(key_, own, mask)),
                   {to_asio(target.to.address), target.to.port}, 0, error);
    if (error) return;
    asked_.push_back(target.to.to_string());
    listen(listener);
  }

  void listen(const std::shared_ptr<Listener>& listener) {
    listener->socket.async_receive_from(asio::buffer(listener->datagram), listener->from,
                                        [this, listener](const Error& error, std::size_t size) {
                                          if (error) return;
                                          keep(listener->how, ByteView(listener->datagram.data(), size),
                                               address_of(listener->from.address().to_v4()));
                                          listen(listener);
                                        });
  }

  void ask(const DiscoverTarget& target) {
    const auto asked = std::make_shared<Asked>(
        Asked{target, target.how->question(key_, IpAddress(), IpAddress()), tcp::socket(io_)});
    asked_.push_back(target.to.to_string());
    asked->socket.async_connect({to_asio(target.to.address), target.to.port}, [this,
                                                                               asked](const Error& error) {
      if (error == asio::error::network_unreachable)
        asked_.erase(std::remove(asked_.begin(), asked_.end(), asked->target.to.to_string()), asked_.end());
      if (error) return;
      asio::async_write(asked->socket, asio::buffer(asked->question),
                        [this, asked](const Error& failed, std::size_t) {
                          if (!failed) read(asked);
                        });
    });
  }

  void read(const std::shared_ptr<Asked>& asked) {
    asked->socket.async_read_some(
        asio::buffer(asked->chunk), [this, asked](const Error& error, std::size_t size) {
          if (error) return;
          asked->stream.append(asked->chunk.data(), size);
          const bool is_whole = keep(*asked->target.how, ByteView(asked->stream), asked->target.to.address);
          if (!is_whole && asked->stream.size() <= longest_answer) read(asked);
        });
  }

  bool keep(const Discovery& how, ByteView answer, const IpAddress& sender) {
    auto device = how.read_answer(answer, sender);
    if (!device) return false;
    device->vendor = how.vendor;
    const bool is_known = std::any_of(found_.begin(), found_.end(), [&](const FoundDevice& other) {
      return other.address == device->address && other.serial == device->serial;
    });
    if (!is_known) found_.push_back(*std::move(device));
    return true;
  }

  const DiscoverOptions& options_;
  std::uint32_t key_ = 0;
  asio::io_context io_;
  std::vector<std::string> asked_;
  std::vector<FoundDevice> found_;
};

void print(const std::vector<FoundDevice>& found, bool json, std::ostream& out) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const FoundDevice& device : found)
    list.push_back({{"address", device.address.to_string()},
                    {"vendor", device.vendor},
                    {"product", device.product},
                    {"serial", device.serial},
                    {"firmware", device.firmware},
                    {"model", device.model}});
  if (json)
    out << list.dump(2) << '\n';
  else if (!list.empty())
    print_columns(table_of(list, {"address", "vendor", "product", "serial", "firmware", "model"}), out);
}

}  // namespace

int run_discover(const DiscoverOptions& options, std::ostream& out, std::ostream& err) {
  Search search(options);
  const std::vector<FoundDevice> found = search.run();
  print(found, options.json, out);
  if (!found.empty()) return 0;
  err << "nothing answered within " << options.wait << " s from";
  for (const std::string& target : search.asked()) err << ' ' << target;
  err << (search.asked().empty() ? " anywhere: no interface is up" : "")
      << "; check power and cable, give this computer an address in the device's network, or name the "
         "device's address";
  for (const DiscoverTarget& target : options.targets) {
    if (!target.how->usual_address.empty()) err << " with --" << target.how->name;
  }
  err << '\n';
  return 1;
}

}  // namespace lidard
