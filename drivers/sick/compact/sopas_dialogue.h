// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/driver.h"
#include "drivers/sick/cola/cola_command.h"
#include "drivers/sick/cola/cola_reader.h"

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
class SopasDialogue {
 public:
  explicit SopasDialogue(const DriverConfig& config);

  void connected(Stamp now, DriverOutput& out);
  void disconnected();
  /// Bytes from the device.
  void receive(const Packet& packet, DriverOutput& out);
  /// `last_data`: when the device last sent a scan telegram; empty: never.
  void tick(Stamp now, std::optional<Stamp> last_data, DriverOutput& out);

  /// What is wrong and the remedy; empty when all is as wanted.
  const std::string& warning() const { return warning_; }
  /// Where the device sends, as read; empty while unknown.
  const std::string& data_output() const { return data_output_; }

 private:
  enum class Variable : std::uint8_t {
    scan_target,
    scan_format,
    scan_enable,
    imu_target,
    imu_enable,
    count_
  };
  enum class Phase : std::uint8_t { idle, dialling, reading, working };
  /// One command of the second half, after the comparison.
  struct Step {
    std::vector<std::uint8_t> telegram;
    std::string what;     ///< for people: "ScanDataFormat: 1 -> 2"
    bool method = false;  ///< answers 1 where it was done
    bool may_fail = false;
    bool is_write = false;
  };

  static const char* name_of(Variable variable);
  void ask(const std::vector<std::uint8_t>& telegram, DriverOutput& out);
  /// What the device was asked last, for people.
  std::string asked_what() const;
  void read_next(DriverOutput& out);
  void answer(const ColaTelegram& telegram, DriverOutput& out);
  void take(Variable variable, const ColaTelegram& telegram);
  void compare(DriverOutput& out);
  void add_write(Variable variable, std::string_view arguments, std::string what, bool may_fail);
  void add_login();
  void add_method(std::string_view name);
  void plan_targets();
  void plan_start();
  void answer_step(const ColaTelegram& telegram, DriverOutput& out);
  void next_step(DriverOutput& out);
  void hang_up(DriverOutput& out);
  void fail(std::string why, DriverOutput& out);

  DeviceRequests requests_;
  bool wanted_;
  SopasTarget scan_wanted_, imu_wanted_;
  Counters stream_counters_;
  ColaStream stream_{stream_counters_};
  Phase phase_ = Phase::idle;
  Stamp now_{};
  Stamp asked_{};
  Stamp last_dial_{};
  bool dialled_ = false;
  bool complete_ = false;
  std::size_t reading_ = 0;
  std::optional<SopasTarget> scan_target_, imu_target_;
  std::optional<std::uint32_t> scan_format_, scan_enable_, imu_enable_;
  std::vector<Step> steps_;
  std::size_t step_ = 0;
  std::string warning_;
  std::string data_output_;
};

}  // namespace lidard::sick
