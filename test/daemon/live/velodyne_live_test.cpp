// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A Velodyne's web interface behind a real TCP socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/registry/registry.h"
#include "test/daemon/live/live_bench.h"
#include "test/support/fake_velodyne.h"
#include "test/support/tcp_peer.h"

namespace lidard::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Fault = FakeVelodyne::Fault;

/// True for a request whose body is as long as its header says.
bool is_whole(const std::string& request) {
  const std::size_t header = request.find("\r\n\r\n");
  if (header == std::string::npos) return false;
  const std::size_t length = request.find("Content-Length: ");
  return length == std::string::npos ||
         request.size() >= header + 4 + std::stoul(request.substr(length + 16));
}

/// The sensor: one connection at a time, as plain sockets have it.
struct WebServer {
  void serve() {
    if (peer.accept()) {
      ++connections;
      request.clear();
      waits = true;
    }
    if (!waits) return;
    request += peer.read();
    if (!is_whole(request)) return;
    waits = false;
    const FakeVelodyne::Reply reply = sensor.take(request);
    if (!reply.bytes.empty()) peer.send(reply.bytes);
    if (reply.closes) peer.close_client();
  }

  TcpPeer peer;
  FakeVelodyne sensor;
  std::size_t connections = 0;
  std::string request;
  bool waits = false;
};

Config config_of(const WebServer& server) {
  Config config;
  SensorConfig sensor;
  sensor.name = sensor.frame_id = sensor.driver.frame_id = "roof";
  sensor.model = sensor.driver.model = find_model("velodyne_vlp16");
  sensor.ip_address = IpAddress::v4(127, 0, 0, 1);
  sensor.control.allow_write = true;
  sensor.control.wanted.rpm = 1200;
  sensor.control.port = server.peer.port();
  sensor.control.address = *sensor.ip_address;
  sensor.control.data_port = 2368;
  sensor.driver.control = std::make_shared<VelodyneControl>(sensor.control);
  config.sensors.push_back(sensor);
  return config;
}

struct WebBench final : LiveBench {
  explicit WebBench(WebServer& web) : LiveBench(config_of(web)), server(web) {}
  void meanwhile() override { server.serve(); }
  DiagnosticItem item() { return items_of(pipeline, now_of_host()).front(); }
  DiagnosticItem link() {
    std::vector<DiagnosticItem> items;
    connections.add_diagnostics(items);
    return items.empty() ? DiagnosticItem() : items.front();
  }
  WebServer& server;
};

TEST(VelodyneLive, IsNotAskedUnlessItIsToBe) {
  for (const std::string keys : {"", ", allow_write: true"}) {
    WebServer server;
    const std::string port = std::to_string(server.peer.port());
    Config config = parse_config("sensors: {roof: {model: velodyne_vlp16, ip_address: 127.0.0.1" +
                                     (keys.empty() ? "" : ", control: {port: " + port + keys + "}") + "}}",
                                 "f");
    config.sensors.at(0).ip_port = 0;
    LiveBench bench(config);
    bench.run(std::chrono::milliseconds(100));
    EXPECT_FALSE(server.peer.accept()) << keys;
    EXPECT_TRUE(bench.items().empty()) << keys;
  }
}

TEST(VelodyneLive, IsAskedAndSetWithAConnectionForEachRequest) {
  WebServer server;
  WebBench bench(server);
  ASSERT_TRUE(bench.until([&] { return server.sensor.requests().size() == 3; }));
  EXPECT_THAT(server.sensor.requests(),
              ElementsAre("GET /cgi/snapshot.hdl", "POST /cgi/setting rpm=1200", "GET /cgi/snapshot.hdl"));
  EXPECT_EQ(server.connections, 3U);
  ASSERT_TRUE(bench.until([&] { return bench.item().hardware_id == "AG29999999"; }));
}

TEST(VelodyneLive, MayEndItsAnswersByClosing) {
  WebServer server;
  server.sensor.misbehave(Fault::http_1_0, 1'000'000);
  WebBench bench(server);
  ASSERT_TRUE(bench.until([&] { return server.sensor.requests().size() == 3; }));
  bench.run(std::chrono::milliseconds(300));
  EXPECT_EQ(bench.item().hardware_id, "AG29999999");
  EXPECT_EQ(bench.link().health, Health::ok);
  EXPECT_EQ(bench.link().message, "not needed now");
}

TEST(VelodyneLive, IsMissedWhereNobodyListens) {
  WebServer server;
  server.peer.stop_listening();
  WebBench bench(server);
  ASSERT_TRUE(bench.until([&] { return bench.link().health == Health::warn; })) << "data may come without it";
  EXPECT_THAT(bench.link().message, HasSubstr("refuses the connection"));
}

}  // namespace
}  // namespace lidard::test
