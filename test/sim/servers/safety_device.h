// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "test/sim/devices/safety_settings.h"
#include "test/sim/servers/device_server.h"

namespace lidard::sim {

/// A safety scanner as its CoLa 2 port shows it.
class SafetyDevice final : public TcpDevice {
 public:
  explicit SafetyDevice(SafetySettings shown = {}) : TcpDevice({}), settings(std::move(shown)) {}
  void connected(Stamp) override { settings.connect(); }
  void receive(std::string_view bytes, Stamp now) override {
    const auto answer = settings.answer(ByteView(bytes));
    if (!answer.empty()) send(std::string(answer.begin(), answer.end()), now);
  }

  SafetySettings settings;

 protected:
  void produce(Stamp) override {}
};

/// A safety scanner of a scene in front of real sockets: its datagrams go where its settings send them.
class LiveSafetyScanner {
 public:
  LiveSafetyScanner(const Endpoint& listen, SafetySettings settings)
      : server_(listen, std::make_unique<SafetyDevice>(std::move(settings))) {}

  /// Where this datagram of the scene's scanner goes; empty: nowhere.
  std::optional<Endpoint> destination(ByteView datagram);
  const DeviceServer& server() const { return server_; }

 private:
  void collect(ByteView datagram, SafetySettings::Bytes& latest);

  DeviceServer server_;
  SafetySettings::Bytes collected_;
};

}  // namespace lidard::sim
