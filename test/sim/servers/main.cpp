// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drivers/capture/pcap_source.h"
#include "test/sim/servers/capture.h"
#include "test/sim/servers/device_server.h"
#include "test/sim/servers/repeater.h"
#include "test/sim/servers/safety_device.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"
#include "test/sim/servers/udp_sender.h"

namespace {

using namespace lidard;
using namespace lidard::sim;

struct Arguments {
  std::string input;
  std::string output;
  std::string to;
  std::string rate = "1";
  std::vector<std::string> source_map;
  std::vector<std::string> port_map;
  double duration = 0;
  std::uint64_t repeat = 1;
  bool no_truth = false;
};

IpAddress parse_address(const std::string& text) {
  const auto address = IpAddress::parse(text);
  if (!address) throw CLI::ValidationError("'" + text + "' is not an IP address; expected e.g. 127.0.0.1");
  return *address;
}

Route parse_route(const Arguments& arguments) {
  Route route;
  if (!arguments.to.empty()) route.to = parse_address(arguments.to);
  for (const std::string& entry : arguments.source_map) {
    const std::size_t sign = entry.find('=');
    if (sign == std::string::npos) {
      throw CLI::ValidationError("'" + entry + "' has no '='; expected e.g. 192.168.0.21=127.0.0.21");
    }
    route.sources[parse_address(entry.substr(0, sign))] = parse_address(entry.substr(sign + 1));
  }
  for (const std::string& entry : arguments.port_map) {
    unsigned from = 0;
    unsigned to = 0;
    int used = 0;
    const bool read = std::sscanf(entry.c_str(), "%u=%u%n", &from, &to, &used) == 2;
    if (!read || static_cast<std::size_t>(used) != entry.size() || from > 65535 || to > 65535) {
      throw CLI::ValidationError("--port-map '" + entry + "'; expected e.g. 2368=12368");
    }
    route.ports[static_cast<std::uint16_t>(from)] = static_cast<std::uint16_t>(to);
  }
  return route;
}

double parse_rate(const std::string& text) {
  if (text == "max") return 0;
  char* end = nullptr;
  const double rate = std::strtod(text.c_str(), &end);
  if (*end != '\0' || !(rate > 0 && rate <= 1e6)) {
    throw CLI::ValidationError("--rate '" + text + "'; expected a number above 0, or max");
  }
  return rate;
}

int report(const UdpSender& sender, const Pacer& pacer) {
  int code = 0;
  for (const auto& entry : sender.flows()) {
    const UdpSender::Flow& flow = entry.second;
    std::printf("%s: %llu packets, %llu bytes\n", flow.route.c_str(),
                static_cast<unsigned long long>(flow.packets), static_cast<unsigned long long>(flow.bytes));
    if (flow.failed == 0) continue;
    code = 1;
    std::fprintf(stderr, "lidard-sim: %llu packets of %s could not be sent: %s\n",
                 static_cast<unsigned long long>(flow.failed), entry.first.first.to_string().c_str(),
                 flow.error.c_str());
  }
  std::printf("latest packet: %.3f ms behind its time\n", pacer.worst_delay() * 1e3);
  return code;
}

int make(const Arguments& arguments) {
  const CaptureSummary summary =
      make_capture(load_scene(arguments.input), arguments.output, !arguments.no_truth);
  std::printf("%s.pcap: %llu packets", arguments.output.c_str(),
              static_cast<unsigned long long>(summary.packets));
  if (!arguments.no_truth) {
    std::printf("; %s.truth: %llu packets and scans", arguments.output.c_str(),
                static_cast<unsigned long long>(summary.measurements));
  }
  std::printf("\n");
  return 0;
}

/// Where a client finds a TCP sensor of the scene.
Endpoint server_of(const SensorEntry& sensor, const Route& route) {
  const auto local = local_source(route, sensor.from.address, route.to.value_or(sensor.to.address));
  const auto port = route.ports.find(sensor.from.port);
  return {local.value_or(sensor.from.address), port == route.ports.end() ? sensor.from.port : port->second};
}

/// Puts the scene's TCP sensors behind sockets; takes them out of `scene`, which sends datagrams then.
std::vector<std::unique_ptr<DeviceServer>> serve(const Scene& all, const Route& route, Scene& scene) {
  std::vector<std::unique_ptr<DeviceServer>> servers;
  scene.sensors.clear();
  const Stamp now = now_of_host();
  for (std::size_t i = 0; i < all.sensors.size(); ++i) {
    const SensorEntry& sensor = all.sensors[i];
    if (!sensor.is_tcp()) {
      scene.sensors.push_back(sensor);
      continue;
    }
    const Endpoint address = server_of(sensor, route);
    servers.push_back(
        std::make_unique<DeviceServer>(address, sensor.make_device(all, i, now, all.start - now)));
    std::printf("%s: waits for a client at %s\n", sensor.name.c_str(), address.to_string().c_str());
  }
  std::fflush(stdout);
  return servers;
}

/// The settings ports of the scene's safety scanners, by the scanner. One whose address is not ours only
/// sends.
std::map<Endpoint, std::unique_ptr<LiveSafetyScanner>> serve_settings(const Scene& scene,
                                                                      const Route& route) {
  constexpr std::uint16_t cola2_port = 2122;  // SICK 8022708 p. 28
  std::map<Endpoint, std::unique_ptr<LiveSafetyScanner>> scanners;
  for (const SensorEntry& sensor : scene.sensors) {
    if (!sensor.settings) continue;
    SensorEntry port = sensor;
    port.from.port = cola2_port;
    const Endpoint address = server_of(port, route);
    try {
      scanners[sensor.from] = std::make_unique<LiveSafetyScanner>(address, *sensor.settings);
      std::printf("%s: shows its settings at %s\n", sensor.name.c_str(), address.to_string().c_str());
    } catch (const std::runtime_error& error) {
      std::printf("%s: shows no settings: %s\n", sensor.name.c_str(), error.what());
    }
  }
  std::fflush(stdout);
  return scanners;
}

int live(const Arguments& arguments) {
  Scene all = load_scene(arguments.input);
  if (arguments.duration > 0) all.duration = span_from_seconds(arguments.duration);
  Scene scene = all;
  const Route route = parse_route(arguments);
  const auto servers = serve(all, route, scene);
  const auto scanners = serve_settings(scene, route);
  UdpSender sender(route);
  Pacer pacer(parse_rate(arguments.rate));
  const Stamp begin = now_of_host();
  if (!scene.sensors.empty()) {
    simulate(scene, [&](const SimPacket& packet) {
      pacer.wait_until(packet.time);
      const auto scanner = scanners.find(packet.from);
      const auto to = scanner == scanners.end() ? packet.to : scanner->second->destination(packet.payload);
      if (to) sender.send(packet.from, *to, packet.payload);
      return true;
    });
  }
  if (!servers.empty()) std::this_thread::sleep_for(begin + scene.duration - now_of_host());
  for (const auto& server : servers) {
    std::printf("port %u: %llu connections, %llu bytes\n", server->port(),
                static_cast<unsigned long long>(server->connections()),
                static_cast<unsigned long long>(server->bytes_sent()));
  }
  return scene.sensors.empty() ? 0 : report(sender, pacer);
}

int send(const Arguments& arguments) {
  PcapSource capture(arguments.input);
  UdpSender sender(parse_route(arguments));
  Pacer pacer(parse_rate(arguments.rate));
  const auto use = [&](const Packet& packet) {
    if (packet.transport != Transport::udp) return;  // a connection is more than its bytes
    pacer.wait_until(packet.arrival);
    sender.send(packet.from, packet.to, packet.payload);
  };
  if (arguments.repeat > 1) {
    Repeater(capture).play(arguments.repeat, use);
  } else {
    for (Packet packet; capture.next(packet);) use(packet);
  }
  const int code = report(sender, pacer);
  if (capture.error().empty()) return code;
  std::fprintf(stderr, "lidard-sim: %s\n", capture.error().c_str());
  return 1;
}

void add_route_options(CLI::App& command, Arguments& arguments) {
  command.add_option("--to", arguments.to, "Send there, whatever the packet says")->type_name("ADDRESS");
  command.add_option("--port-map", arguments.port_map, "Send to port NEW what was sent to port OLD")
      ->type_name("OLD=NEW");
  command
      .add_option(
          "--source-map", arguments.source_map,
          "Send the packets of ORIGINAL from the local address LOCAL. Towards 127.x.x.x a sender a.b.c.d "
          "is 127.b.c.d by default")
      ->type_name("ORIGINAL=LOCAL");
  command.add_option("--rate", arguments.rate, "Times the pace of the recording, or max (default 1)")
      ->type_name("R|max");
}

int run(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Virtual vehicle: what lidars would send while driving through a scene", "lidard-sim");
  app.require_subcommand(1);
  CLI::App* make_command = app.add_subcommand("make", "Writes a scene's packets and the truth beside them");
  make_command->add_option("SCENE", arguments.input, "Scene file (see pcaps/README.md)")->required();
  make_command->add_option("-o,--output", arguments.output, "Writes PREFIX.pcap and PREFIX.truth")
      ->type_name("PREFIX")
      ->required();
  make_command->add_flag("--no-truth", arguments.no_truth,
                         "Without PREFIX.truth, which is larger than the packets");
  CLI::App* live_command = app.add_subcommand(
      "live", "Sends a scene's packets over UDP when they are due; TCP sensors wait for clients");
  live_command->add_option("SCENE", arguments.input, "Scene file (see pcaps/README.md)")->required();
  live_command->add_option("--duration", arguments.duration, "Stop after that time (default: the scene's)")
      ->type_name("S")
      ->check(CLI::PositiveNumber);
  add_route_options(*live_command, arguments);
  CLI::App* send_command =
      app.add_subcommand("send", "Sends the UDP datagrams of a capture at their own pace");
  send_command->add_option("CAPTURE", arguments.input, "pcap or pcapng file")->required();
  send_command
      ->add_option("--repeat", arguments.repeat,
                   "Send it N times without a break, the stamps of Velodynes going on")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  add_route_options(*send_command, arguments);
  try {
    app.parse(argc, argv);
    if (make_command->parsed()) return make(arguments);
    return live_command->parsed() ? live(arguments) : send(arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "lidard-sim: %s\n", error.what());
    return 1;
  }
}
