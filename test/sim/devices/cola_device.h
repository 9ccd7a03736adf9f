// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "test/sim/devices/cola_telegram.h"
#include "test/sim/devices/cola_variables.h"
#include "test/sim/devices/tcp_device.h"

namespace lidard::sim {

/// A scanner that speaks one dialect of CoLa, as its owner set it up.
struct ColaDeviceOptions {
  Cola dialect = Cola::binary;
  std::string type = "LMS1xx", version = "V1.80";
  std::uint32_t serial = 18090362;
  double hz = 50;                ///< telegrams per second
  int scans_per_turn = 1;        ///< telegrams for each turn of the mirror
  std::int32_t start = -450000;  ///< 1/10000 deg
  std::uint16_t step = 5000;     ///< 1/10000 deg, as told
  double exact_step_deg = 0.5;
  std::size_t beams = 541;
  std::vector<std::int16_t> layers = {0};  ///< of the telegrams in turn
  bool stamps_last_beam = true;            ///< the "time since start up" is that of the last beam
  std::uint32_t clock_us = 0;              ///< what the clock shows at power-up
  double clock_ppm = 0;                    ///< its crystal is that much fast
  Span boot{0};                            ///< after power-up it refuses (sFA 4) that long
  Span processing{3'000'000};              ///< from the last beam to the first byte of the telegram
  Span answer_time{1'000'000};
  Transit transit;
  std::uint8_t channels = 1, rssi = 0;  ///< LMDscandatacfg
  std::uint16_t interval = 1;
  std::uint32_t password = 0xF4724744;        ///< of level 3
  std::map<std::string, unsigned> refusals;   ///< sFA code by command ("sEN LMDscandata")
  bool measures = true;                       ///< false: takes subscriptions and sends nothing
  std::array<std::uint8_t, 2> status{};       ///< of every scan
  std::optional<std::uint8_t> contamination;  ///< answer to LCMstate; none: it does not know the word
  /// Answer to MCAngleCompSin (amplitude, phase, offset, 1/10000 deg); none: it does not know the word. A
  /// NAV2xx sends 32 bits each, a NAV3xx 16, 32 and 16.
  std::optional<std::array<std::int32_t, 3>> compensation;
  bool wide_compensation = false;
};

/// What a beam brings back: up to two distances (mm; 0: none, below 16: a code), and how bright the first is.
struct ColaBeam {
  std::array<std::uint16_t, 2> mm{};
  std::uint8_t rssi = 180;
};
/// What the device sees in a sweep whose first beam fires then.
using ColaScene = std::function<std::vector<ColaBeam>(Stamp first_beam, std::size_t beams)>;

/// The simulated scanner. A client logs in, reads and writes variables, calls methods and subscribes; what
/// the device does not know, does not allow or cannot parse it refuses with SICK's error code (sFA). The
/// scans follow LMDscandatacfg (not its encoder, position, name and comment), LMPoutputRange and
/// FREchoFilter; other variables are kept without effect. Like the real ones it sends no scans while somebody
/// is logged in.
class ColaDevice : public TcpDevice {
 public:
  ColaDevice(ColaDeviceOptions options, ColaScene scene, Stamp power_on);

  void connected(Stamp now) override;
  void disconnected() override;
  void receive(std::string_view bytes, Stamp now) override;

  /// Switched off and on again: clock and counters start anew, the client is gone; settings stay.
  void power_cycle(Stamp now);
  ColaDeviceOptions& options() { return options_; }
  /// Everything that clients wrote since power-up, and settings written.
  const std::string& received() const { return received_; }
  int writes() const { return writes_; }
  Span period() const;
  Span beam_period() const;

 protected:
  void produce(Stamp until) override;

 private:
  using Telegram = std::vector<std::uint8_t>;
  bool take_frame(std::string& payload);
  void answer(const std::string& payload, Stamp now);
  Telegram answer_to(const std::string& command, const std::string& arguments, Stamp now);
  Telegram read(const std::string& name, Stamp now);
  /// The answer of a variable that the measurement decides.
  std::optional<ColaWords> measured(const std::string& name) const;
  Telegram write(const std::string& name, const std::string& arguments);
  /// Empty, or why the device refuses.
  std::optional<unsigned> apply_outputs(const std::string& arguments);
  std::optional<unsigned> apply_range(const std::string& arguments);
  std::optional<unsigned> apply_echoes(const std::string& arguments);
  Telegram call(const std::string& name, const std::string& arguments);
  Telegram subscribe(const std::string& name, const std::string& arguments, Stamp now);
  Telegram refuse(unsigned code) const;
  ColaWords words(const std::string& command) const { return {options_.dialect, command}; }
  void set_up();
  void next_scan_after(Stamp now) { next_scan_ = (now - power_on_) / period() + 1; }
  std::uint32_t device_us(Stamp when) const;
  void send_scan(std::int64_t number, Stamp first_beam);

  ColaDeviceOptions options_;
  ColaScene scene_;
  Stamp power_on_;
  std::string buffer_, received_;
  int writes_ = 0;
  bool subscribed_ = false, polled_ = false, logged_in_ = false, stopped_ = false;
  std::map<std::string, ColaVariable> variables_;
  std::vector<std::uint32_t> outputs_;  ///< LMDscandatacfg as written
  std::uint32_t echo_filter_ = 1;       ///< first, all, last
  std::size_t first_ = 0, last_ = 0;    ///< beams of the output range
  std::int64_t next_scan_ = 0;
  std::uint16_t telegrams_ = 0;
};

}  // namespace lidard::sim
