// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "drivers/dialogue.h"
#include "drivers/sick/safety/cola2_frame.h"

namespace lidard::sick {

/// The talk with a safety scanner over CoLa 2 (TCP 2122): reads who it is and where it sends, compares that
/// with what is wanted and, if allowed, changes and reads again. Then it hangs up: some firmware stalls the
/// stream while it is talked to (SICKAG/sick_safetyscanners issue 15).
///
/// It takes place only if the configuration asks for something (`DeviceRequests::host_address`, `skip` or
/// `allow_write`). What is written is volatile; it is written again when the stream stopped, as it does when
/// the scanner was switched off (same project, issue 98).
class SafetyDialogue final : public SideDialogue {
 public:
  explicit SafetyDialogue(const DriverConfig& config);

  /// Bytes from the scanner.
  void receive(const Packet& packet, DriverOutput& out);

  /// What was read, and what is wrong with it.
  const DeviceInfo& info() const { return info_; }
  /// Changes whenever info() did.
  unsigned version() const { return version_; }

 private:
  void begin() override;
  void script(DriverOutput& out) override;
  void silent(DriverOutput& out) override { fail("does not answer on its TCP port", out); }
  void ask_in_mode(char type, char mode, ByteView data, DriverOutput& out);
  void open(DriverOutput& out);
  void read(std::uint16_t index, DriverOutput& out) { ask_index('R', index, {}, out); }
  void ask_index(char type, std::uint16_t index, ByteView arguments, DriverOutput& out);
  void change_output(DriverOutput& out);
  void take_variable(std::uint16_t index);
  bool is_to_be_changed();
  bool was_changed(DriverOutput& out);
  void verify();
  bool take_field();
  bool take_case();
  void fail(const std::string& why, DriverOutput& out);
  void detail(const std::string& key, const std::string& text);
  void warn(const std::string& text);
  SafetyOutput wanted_output(const SafetyOutput& present) const;

  DeviceRequests requests_;
  std::string product_;
  double range_max_;
  Cola2Stream stream_;
  Cola2Telegram answer_;
  ByteView value_;  // of the answer
  std::uint32_t session_ = 0;
  std::uint16_t request_ = 0;
  std::uint16_t index_ = 0;  // of fields and cases
  std::size_t variable_ = 0;
  bool refused_ = false;
  std::string type_code_;
  SafetyOutput present_, target_;
  std::string fields_, cases_;
  DeviceInfo info_;
  unsigned version_ = 0;
};

}  // namespace lidard::sick
