// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/driver.h"
#include "drivers/sick/safety/cola2_frame.h"
#include "drivers/sick/safety/safety_variables.h"

namespace lidard::sick {

/// The talk with a safety scanner over CoLa 2 (TCP 2122): reads who it is and where it sends, compares that
/// with what is wanted and, if allowed, changes and reads again. Then it hangs up: some firmware stalls the
/// stream while it is talked to (SICKAG/sick_safetyscanners issue 15).
///
/// It takes place only if the configuration asks for something (`DeviceRequests::host_address`, `skip` or
/// `allow_write`). What is written is volatile; it is written again when the stream stopped, as it does when
/// the scanner was switched off (same project, issue 98).
class SafetyDialogue {
 public:
  explicit SafetyDialogue(const DriverConfig& config);

  void connected(Stamp now, DriverOutput& out);
  void disconnected();
  /// Bytes from the scanner.
  void receive(const Packet& packet, DriverOutput& out);
  /// `last_data`: when the scanner last sent a datagram of its data output; empty: never.
  void tick(Stamp now, std::optional<Stamp> last_data, DriverOutput& out);

  /// Key and text of what was read, for diagnostics.
  const std::vector<std::pair<std::string, std::string>>& details() const { return details_; }
  /// What is wrong and the remedy; empty when all is as wanted.
  const std::vector<std::string>& warnings() const { return warnings_; }
  const std::string& serial() const { return serial_; }
  /// Changes whenever details or warnings did.
  unsigned version() const { return version_; }

 private:
  enum class Phase : std::uint8_t {
    idle,
    dialling,
    opening,
    reading,
    changing,
    verifying,
    browsing,
    closing
  };

  void ask(char type, char mode, ByteView data, DriverOutput& out);
  void ask_index(char type, std::uint16_t index, ByteView arguments, DriverOutput& out);
  void answer(const Cola2Telegram& telegram, DriverOutput& out);
  void read_next(DriverOutput& out);
  void take_variable(std::uint16_t index, ByteView value);
  void compare(DriverOutput& out);
  void changed(ByteView result, DriverOutput& out);
  void verify(ByteView value, DriverOutput& out);
  void browse(ByteView value, DriverOutput& out);
  void hang_up(DriverOutput& out);
  void fail(const std::string& why, DriverOutput& out);
  void set_detail(const std::string& key, const std::string& text);
  void warn(const std::string& text);
  SafetyOutput wanted_output(const SafetyOutput& present) const;

  DeviceRequests requests_;
  bool wanted_;
  std::string product_;
  double range_max_;
  Cola2Stream stream_;
  Phase phase_ = Phase::idle;
  Stamp now_{};
  Stamp phase_since_{};
  Stamp last_dial_{};
  bool dialled_ = false;
  bool complete_ = false;  // one dialogue came to its end
  std::uint32_t session_ = 0;
  std::uint16_t request_ = 0;
  std::uint16_t index_ = 0;  // asked for last
  std::size_t step_ = 0;
  std::string type_code_;
  std::string serial_;
  SafetyOutput present_, target_;
  std::string fields_, cases_;
  std::vector<std::pair<std::string, std::string>> details_;
  std::vector<std::string> warnings_;
  unsigned version_ = 0;
};

}  // namespace lidard::sick
