// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "test/drivers/sick/cola/cola_bench.h"
#include "test/sim/devices/cola_device.h"

namespace lidard::test {

using sim::Cola;
using sim::ColaWords;
using Bytes = std::vector<std::uint8_t>;

inline Bytes binary(const std::string& command) { return ColaWords(Cola::binary, command).bytes(); }
inline Bytes text(const std::string& payload) {
  const std::string frame = "\x02" + payload + "\x03";
  return {frame.begin(), frame.end()};
}

/// LMDscandatacfg as recorded: first echo, no intensity, with time, every scan.
inline Bytes settings(Cola dialect, const std::string& command, unsigned channels = 1, unsigned rssi = 0,
                      unsigned interval = 1) {
  ColaWords words(dialect, command);
  words.number(channels, 1).number(0, 1).number(rssi, 1).number(0, 1).number(0, 1).number(0, 1).number(0, 1);
  return words.number(0, 1).number(0, 1).number(0, 1).number(1, 1).number(interval, 2).bytes();
}
inline Bytes subscribe(Cola dialect) { return ColaWords(dialect, "sEN LMDscandata").number(1, 1).bytes(); }
inline Bytes refusal(Cola dialect, unsigned code) {
  if (dialect == Cola::text) return ColaWords(dialect, "sFA").number(code, 2).bytes();
  // Without a blank, as recorded.
  return binary(std::string("sFA") + '\0' + static_cast<char>(code));
}

/// The simulated scanner at the other end of the bench's cable: answers at once, and sends no scans.
class FakeDevice {
 public:
  explicit FakeDevice(ColaBench& bench, Cola dialect = Cola::binary)
      : answers{{"sRN LMDscandatacfg", settings(dialect, "sRA LMDscandatacfg")}},
        bench_(bench),
        device_(options_of(dialect), {}, bench.now - std::chrono::hours(1)) {}

  /// Answers to commands that begin like this, instead of the scanner's.
  std::map<std::string, Bytes> answers;

  void connect() {
    bench_.driver->connected(bench_.now, bench_);
    run();
  }
  /// Lets time pass.
  void wait(double s) {
    bench_.tick(s);
    run();
  }
  /// Answers what has been asked since, at most so often.
  void run(int most = 100) {
    while (most > 0 && answered_ < bench_.requests.size()) {
      const Bytes request = bench_.requests[answered_++];
      device_.receive({reinterpret_cast<const char*>(request.data()), request.size()}, bench_.now);
      const auto sent = device_.next(bench_.now + std::chrono::seconds(1));
      if (!sent) continue;
      const auto other = answers.find(command_of(request));
      bench_.send(other != answers.end() ? other->second : Bytes(sent->bytes.begin(), sent->bytes.end()));
      --most;
    }
  }
  /// The commands that came, without arguments.
  std::vector<std::string> commands() const {
    std::vector<std::string> all;
    for (const Bytes& request : bench_.requests) all.push_back(command_of(request));
    return all;
  }
  sim::ColaDeviceOptions& options() { return device_.options(); }

 private:
  static sim::ColaDeviceOptions options_of(Cola dialect) {
    sim::ColaDeviceOptions options;
    options.dialect = dialect;
    options.measures = false;
    options.contamination = 0;
    return options;
  }
  static std::string command_of(const Bytes& request) {
    const std::size_t head = request.at(1) == 2 ? 8 : 1;
    const std::string payload(request.begin() + static_cast<std::ptrdiff_t>(head), request.end() - 1);
    return payload.substr(0, payload.find(' ', 4));
  }

  ColaBench& bench_;
  sim::ColaDevice device_;
  std::size_t answered_ = 0;
};

}  // namespace lidard::test
