// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/address.h"
#include "drivers/net/wall_clock.h"
#include "test/sim/devices/tcp_device.h"

namespace lidard::sim {

/// The time of devices: the host's clock, which no test here sets.
inline Stamp now_of_host() { return {wall_clock().ns}; }

/// Puts a device behind a real TCP socket, on a thread of its own. Serves one client at a time, as such
/// sensors do: a second one waits in the queue.
class DeviceServer {
 public:
  /// Port 0: any. Throws std::runtime_error if the address cannot be had.
  DeviceServer(const Endpoint& listen, std::unique_ptr<TcpDevice> device);
  ~DeviceServer();
  DeviceServer(const DeviceServer&) = delete;
  DeviceServer& operator=(const DeviceServer&) = delete;

  std::uint16_t port() const { return port_; }
  /// Connections so far, and whether one stands.
  std::uint64_t connections() const { return connections_; }
  bool has_client() const { return has_client_; }
  std::uint64_t bytes_sent() const { return bytes_sent_; }

  /// Ends the connection: in good order, or with a reset.
  void drop(bool reset);
  /// The connection stands, but nothing is sent or read any more.
  void hang(bool active) { hangs_ = active; }
  /// No power: no connection, nobody listens.
  void switch_off();
  void switch_on();
  /// Looks at or changes the device while the server waits.
  template <class Device>
  void with(const std::function<void(Device&)>& use) {
    const std::lock_guard lock(mutex_);
    use(dynamic_cast<Device&>(*device_));
  }

 private:
  void run();
  void listen();
  void accept_client();
  void read_client();
  void write_client();
  void close_client(bool reset);

  Endpoint address_;
  std::mutex mutex_;
  std::unique_ptr<TcpDevice> device_;
  int listener_ = -1, client_ = -1;
  std::string pending_;
  std::uint16_t port_ = 0;
  std::atomic<bool> stop_{false}, hangs_{false}, has_client_{false};
  std::atomic<std::uint64_t> connections_{0}, bytes_sent_{0};
  std::thread thread_;
};

}  // namespace lidard::sim
