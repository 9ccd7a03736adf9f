// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/discover.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <tinyxml2.h>

#include <algorithm>
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
#include "drivers/hokuyo/models.h"
#include "drivers/hokuyo/scip_message.h"

namespace lidard {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using Error = boost::system::error_code;

constexpr std::uint16_t sick_port = 30718;
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

/// A socket that waits for the answers to one search.
struct Listener {
  udp::socket socket;
  udp::endpoint from{};
  std::array<std::uint8_t, longest_answer> datagram{};
};

/// A TCP connection to what may be a Hokuyo.
struct Asked {
  tcp::socket socket;
  Endpoint to;
  std::array<char, 2048> chunk{};
  std::string stream{};
};

class Search {
 public:
  explicit Search(const DiscoverOptions& options) : options_(options) {}

  std::vector<FoundDevice> run() {
    search_sicks();
    for (const Endpoint& endpoint : options_.hokuyos) ask(endpoint);
    io_.run_for(std::chrono::milliseconds(std::llround(options_.wait * 1000)));
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
    const auto listener = std::make_shared<Listener>(Listener{udp::socket(io_)});
    udp::socket& socket = listener->socket;
    Error error;
    socket.open(udp::v4(), error);
    socket.set_option(asio::socket_base::broadcast(true), error);
    socket.bind({to_asio(own), 0}, error);
    socket.send_to(asio::buffer(sick_search(key, own, mask)), {to_asio(to.address), to.port}, 0, error);
    if (error) return;
    places_.push_back(to.to_string());
    listen(listener);
  }

  void listen(const std::shared_ptr<Listener>& listener) {
    listener->socket.async_receive_from(asio::buffer(listener->datagram), listener->from,
                                        [this, listener](const Error& error, std::size_t size) {
                                          if (error) return;
                                          const ByteView datagram(listener->datagram.data(), size);
                                          const auto device = read_sick_answer(
                                              datagram, address_of(listener->from.address().to_v4()));
                                          if (device) keep(*device);
                                          listen(listener);
                                        });
  }

  void ask(const Endpoint& to) {
    const auto asked = std::make_shared<Asked>(Asked{tcp::socket(io_), to});
    places_.push_back(to.to_string());
    asked->socket.async_connect({to_asio(to.address), to.port}, [this, asked](const Error& error) {
      if (error == asio::error::network_unreachable)
        places_.erase(std::remove(places_.begin(), places_.end(), asked->to.to_string()), places_.end());
      if (error) return;
      asio::async_write(asked->socket, asio::buffer("VV\n", 3),
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
          const auto device = read_hokuyo_answer(ByteView(asked->stream), asked->to.address);
          if (device) keep(*device);
          if (!device && asked->stream.size() <= longest_answer) read(asked);
        });
  }

  void keep(const FoundDevice& device) {
    for (const FoundDevice& other : found_) {
      if (other.address == device.address && other.serial == device.serial) return;
    }
    found_.push_back(device);
  }

  const DiscoverOptions& options_;
  asio::io_context io_;
  std::vector<std::string> places_;
  std::vector<FoundDevice> found_;
};

void print_table(const std::vector<FoundDevice>& found, std::ostream& out) {
  TextTable rows{{"address", "vendor", "product", "serial", "firmware", "model"}};
  for (const FoundDevice& device : found)
    rows.push_back({device.address.to_string(), device.vendor, device.product, device.serial, device.firmware,
                    device.model.empty() ? "see `lidard models`" : device.model});
  print_columns(rows, out);
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

/// The value of `key` in an answer: <Item key="K" value="V"/>, <K>V</K> or an attribute of the root.
std::string value_of(const tinyxml2::XMLElement& root, const char* key) {
  for (const auto* item = root.FirstChildElement(); item != nullptr; item = item->NextSiblingElement()) {
    const char* name = item->Attribute("key");
    const char* value = item->Attribute("value");
    if (name != nullptr && value != nullptr && std::string_view(name) == key) return value;
    if (std::string_view(item->Name()) == key && item->GetText() != nullptr) return item->GetText();
  }
  const char* attribute = root.Attribute(key);
  return attribute == nullptr ? "" : attribute;
}

}  // namespace

std::array<std::uint8_t, 24> sick_search(std::uint32_t key, const IpAddress& own, const IpAddress& mask) {
  std::array<std::uint8_t, 24> bytes{0x10, 0, 0, 0x08, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff};
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[10 + i] = static_cast<std::uint8_t>(key >> (24 - 8 * i) & 0xffU);
    bytes[16 + i] = own.bytes[i];
    bytes[20 + i] = mask.bytes[i];
  }
  bytes[14] = 0x01;
  bytes[15] = 0x02;
  return bytes;
}

std::optional<FoundDevice> read_sick_answer(ByteView datagram, const IpAddress& sender) {
  const std::string_view text = datagram.text();
  const std::size_t begin = std::min(text.find("<?xml"), text.find("<NetScanResult"));
  if (begin == std::string_view::npos) return std::nullopt;
  const std::size_t end = text.rfind('>');
  if (end == std::string_view::npos || end < begin) return std::nullopt;
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data() + begin, end - begin + 1) != tinyxml2::XML_SUCCESS) return std::nullopt;
  const auto* root = document.FirstChildElement("NetScanResult");
  if (root == nullptr) return std::nullopt;
  FoundDevice device;
  device.vendor = "SICK";
  device.product = value_of(*root, "DeviceType");
  device.serial = value_of(*root, "SerialNumber");
  device.firmware = value_of(*root, "FirmwareVersion");
  // A device in another subnet answers, too: its own address counts, not the router's.
  device.address = IpAddress::parse(value_of(*root, "IPAddress")).value_or(sender);
  return device;
}

std::optional<FoundDevice> read_hokuyo_answer(ByteView stream, const IpAddress& sender) {
  Counters ignored;
  hokuyo::ScipReader reader(ignored);
  reader.add(stream);
  for (hokuyo::ScipMessage message; reader.next(message);) {
    if (message.echo != "VV" || message.status != "00") continue;
    FoundDevice device;
    device.vendor = "Hokuyo";
    device.address = sender;
    hokuyo::for_each_entry(message.body, [&](std::string_view key, std::string_view value, bool) {
      if (key == "PROD") device.product = value;
      if (key == "FIRM") device.firmware = value;
      if (key == "SERI") device.serial = value;
    });
    device.model = hokuyo::scip_name_of(device.product);
    return device;
  }
  return std::nullopt;
}

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
