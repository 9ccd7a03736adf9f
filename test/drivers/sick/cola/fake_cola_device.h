// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "test/drivers/sick/cola/cola_bench.h"

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

/// A device that answers as asked of it; what it does not know it leaves unanswered.
class FakeDevice {
 public:
  explicit FakeDevice(ColaBench& bench, Cola dialect = Cola::binary) : bench_(bench), dialect_(dialect) {}

  /// Answers to commands that begin like this, instead of the usual ones.
  std::map<std::string, Bytes> answers;

  void connect() {
    bench_.driver->connected(bench_.now, bench_);
    run();
  }
  /// Lets time pass.
  void wait(double s) {
    bench_.now = bench_.now + span_from_seconds(s);
    bench_.driver->tick(bench_.now, bench_);
    run();
  }
  /// Answers what has been asked since, at most so often.
  void run(int most = 100) {
    while (most > 0 && answered_ < bench_.requests.size()) {
      const Bytes request = bench_.requests[answered_++];
      const Bytes answer = answer_to(request);
      if (answer.empty()) continue;
      bench_.send(answer);
      --most;
    }
  }
  /// The commands that came, without arguments.
  std::vector<std::string> commands() const {
    std::vector<std::string> all;
    for (const Bytes& request : bench_.requests) all.push_back(command_of(request));
    return all;
  }

 private:
  static std::string command_of(const Bytes& request) {
    const std::size_t head = request.at(1) == 2 ? 8 : 1;
    const std::string payload(request.begin() + static_cast<std::ptrdiff_t>(head), request.end() - 1);
    return payload.substr(0, payload.find(' ', 4));
  }
  Bytes answer_to(const Bytes& request) const {
    const bool is_binary = request.at(1) == 2;
    if (is_binary != (dialect_ == Cola::binary)) return {};
    const std::string command = command_of(request);
    if (const auto found = answers.find(command); found != answers.end()) return found->second;
    const std::string name = command.substr(4);
    if (name == "DeviceIdent")
      return ColaWords(dialect_, "sRA DeviceIdent").text("LMS1xx", 2).text("V1.80", 2).bytes();
    if (name == "LMPoutputRange") {
      return ColaWords(dialect_, "sRA LMPoutputRange")
          .number(1, 2)
          .number(5000, 4)
          .number(static_cast<std::uint32_t>(-450000), 4)
          .number(2250000, 4)
          .bytes();
    }
    if (command == "sRN LMDscandatacfg") return settings(dialect_, "sRA LMDscandatacfg");
    if (command[1] == 'W') return ColaWords(dialect_, "sWA " + name).bytes();
    if (command[1] == 'M') return ColaWords(dialect_, "sAN " + name).number(1, 1).bytes();
    return ColaWords(dialect_, "sEA " + name).number(1, 1).bytes();
  }

  ColaBench& bench_;
  Cola dialect_;
  std::size_t answered_ = 0;
};

}  // namespace lidard::test
