// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/dialogue.h"
#include "drivers/sick/cola/cola_command.h"
#include "drivers/sick/cola/cola_stream.h"

namespace lidard::sick {

/// Where a picoScan100 or multiScan100 sends its datagrams (ScanDataEthSettings, ImuDataEthSettings).
struct SopasTarget {
  std::uint8_t protocol = 0;  ///< 1 UDP, 2 TCP
  std::array<std::uint8_t, 4> host{};
  std::uint16_t port = 0;

  std::string describe() const;
  friend bool operator==(const SopasTarget& a, const SopasTarget& b) {
    return a.protocol == b.protocol && a.host == b.host && a.port == b.port;
  }
};

/// The talk with a picoScan100 or multiScan100 in SICK's command language, dialect A (TCP 2111). It takes
/// place only where the configuration has a host address and not `listen_only`: reads where the device sends,
/// in which format and whether, and compares. A stream that is only switched off is started; settings that
/// differ are written if `allow_write` is set, each with a note old -> new, and stay until the device is
/// switched off, after which the dialogue takes place again. Then it hangs up.
class SopasDialogue final : public SideDialogue {
 public:
  explicit SopasDialogue(const DriverConfig& config);

  /// Bytes from the device.
  void receive(const Packet& packet, DriverOutput& out);

  /// What is wrong and the remedy; empty when all is as wanted.
  const std::string& warning() const { return warning_; }
  /// Where the device sends, as read; empty while unknown.
  const std::string& data_output() const { return data_output_; }

 private:
  /// One command of the second half, after the comparison.
  struct Step {
    std::vector<std::uint8_t> telegram;
    std::string what;     ///< for people: "ScanDataFormat: 1 -> 2"
    bool method = false;  ///< answers 1 where it was done
    bool may_fail = false;
    bool is_write = false;
  };

  void begin() override;
  void script(DriverOutput& out) override;
  void silent(DriverOutput& out) override;
  void question(const std::vector<std::uint8_t>& telegram, const std::string& what, DriverOutput& out);
  void read(std::string_view variable, DriverOutput& out);
  bool is_refused() const { return answer_.kind() == "sFA"; }
  bool take(std::string_view variable, DriverOutput& out);
  bool plan(DriverOutput& out);
  void add_write(std::string_view variable, std::string_view arguments, std::string what, bool may_fail);
  void add_login();
  void add_method(std::string_view name);
  void plan_targets();
  void plan_start();
  bool take_step(DriverOutput& out);
  void fail(std::string why, DriverOutput& out);

  DeviceRequests requests_;
  SopasTarget scan_wanted_, imu_wanted_;
  Counters stream_counters_;
  ColaStream stream_{stream_counters_};
  ColaTelegram answer_;
  std::string asked_;          // for people
  std::string_view expected_;  // the variable that is read; empty: a step is taken
  std::size_t variable_ = 0;
  std::optional<SopasTarget> scan_target_, imu_target_;
  std::optional<std::uint32_t> scan_format_, scan_enable_, imu_enable_;
  std::vector<Step> steps_;
  std::size_t step_ = 0;
  std::string warning_;
  std::string data_output_;
};

}  // namespace lidard::sick
