// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "test/sim/devices/tcp_device.h"

namespace lidard::sim {

/// What a UAM-05LP reports beside its distances; fields as they stand in a frame.
struct UamReport {
  unsigned operating_mode = 0, area = 0, error_state = 0, error_code = 0, lockout = 0;
  unsigned ossd1 = 1, ossd2 = 1, ossd3 = 1, ossd4 = 1, warning1 = 0, warning2 = 0;
  unsigned muting1 = 0, muting2 = 0, reset1 = 0, reset2 = 0, encoder_speed = 0;
  unsigned laser_off = 0, contaminated = 0;
};

struct UamDeviceOptions {
  std::string product = "UAM-05LP-T301", firmware = "2.1.0", serial = "H7001234";
  double clock_ppm = 0;
  std::uint32_t counter_ms = 0;  ///< at power-up
  Span boot{0};                  ///< refuses to stream that long
  Span processing{500'000};
  Transit transit;
  UamReport report;
};

/// One beam: 16 bits each.
struct UamBeam {
  std::uint16_t distance = 0, intensity = 0;
};
using UamScene = std::function<std::vector<UamBeam>(Stamp begin, std::size_t beams)>;

/// CRC-16/KERMIT, bit by bit.
std::uint16_t uam_checksum(const std::string& text);
/// STX, length, the text, checksum, ETX.
std::string uam_frame(const std::string& text);

/// A UAM-05LP that speaks the AR protocol.
class UamDevice : public TcpDevice {
 public:
  UamDevice(UamDeviceOptions options, UamScene scene, Stamp power_on)
      : TcpDevice(options.transit),
        options_(std::move(options)),
        scene_(std::move(scene)),
        power_on_(power_on) {}

  void connected(Stamp now) override { static_cast<void>(now), line_.clear(); }
  void disconnected() override;
  void receive(std::string_view bytes, Stamp now) override;
  UamDeviceOptions& options() { return options_; }
  const std::string& received() const { return received_; }

 protected:
  void produce(Stamp until) override;

 private:
  void answer(const std::string& command, Stamp now);
  std::string scan(Stamp begin) const;

  UamDeviceOptions options_;
  UamScene scene_;
  Stamp power_on_;
  std::string line_, received_;
  std::string stream_;  ///< sub-header of the frames that are sent; empty: none
  std::int64_t next_turn_ = 0;
};

}  // namespace lidard::sim
