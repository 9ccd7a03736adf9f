// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/pipeline/pipeline.h"
#include "drivers/registry/registry.h"
#include "test/support/recording_sink.h"

namespace lidard::test {

/// Speaks a protocol of text lines: "hello" is its request; "scan" is answered with a frame, "refused" with a
/// new connection, "done" with the end of the dialogue. Keeps what it was told in `journal`.
class LineDriver final : public Driver {
 public:
  explicit LineDriver(const DriverConfig& config) : config_(config) {}
  Verdict receive(const Packet& packet, FrameReceiver& out) override {
    ++counters_.packets;
    if (packet.stream_start) text_.clear();
    if (packet.transport == Transport::udp) {
      if (packet.payload.text() == "ask") out.connect();
      return {true, Reject::none};
    }
    text_ += packet.payload.text();
    for (std::size_t end = 0; (end = text_.find('\n')) != std::string::npos; text_.erase(0, end + 1))
      line(text_.substr(0, end), out);
    return {true, Reject::none};
  }
  void connected(Stamp, FrameReceiver& out) override {
    ++dialogues;
    out.request(ByteView("hello\n"));
  }
  void disconnected() override {
    ++ends;
    text_.clear();
  }
  void restart() override { text_.clear(); }
  const Counters& counters() const override { return counters_; }
  const DeviceInfo& info() const override { return info_; }

  std::vector<std::string> lines;
  int dialogues = 0, ends = 0;

 private:
  void line(const std::string& text, FrameReceiver& out) {
    lines.push_back(text);
    if (text == "refused") out.disconnect(true);
    if (text == "done") out.disconnect(false);
    if (text != "scan") return;
    ++counters_.frames;
    scan_.reset(10);
    scan_.range_max = 10;
    scan_.set_angles(0, 0.1F);
    out.scan(scan_);
  }

  DriverConfig config_;
  Counters counters_;
  DeviceInfo info_;
  std::string text_;
  PlanarScan scan_;
};

/// The last one made, for a test to look into.
inline LineDriver*& last_line_driver() {
  static LineDriver* driver = nullptr;
  return driver;
}

/// A model of that protocol: over TCP, or over UDP with a dialogue.
inline Model line_model(Transport transport, std::uint16_t port, std::uint16_t dialogue_port = 0) {
  Model model = *find_model("sick_microscan3");
  model.name = "line_device";
  model.transport = transport;
  model.port = port;
  model.dialogue_port = dialogue_port;
  model.frame_period = 0.02;
  model.messages = {}, model.extra_scans = {};
  model.make = [](const DriverConfig& config) -> std::unique_ptr<Driver> {
    auto driver = std::make_unique<LineDriver>(config);
    last_line_driver() = driver.get();
    return driver;
  };
  return model;
}

inline SensorConfig line_sensor(const Model& model, const std::string& name, const IpAddress& address) {
  SensorConfig sensor;
  sensor.name = sensor.frame_id = name;
  sensor.model = sensor.driver.model = &model;
  sensor.ip_address = address;
  sensor.ip_port = model.port;
  return sensor;
}

}  // namespace lidard::test
