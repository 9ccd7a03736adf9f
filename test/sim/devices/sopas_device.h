// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace lidard::sim {

/// The settings of a picoScan100 or multiScan100 as its TCP port 2111 serves them: dialect A of SICK's
/// command language. Owns no socket. As SICK's developer guide and sick_scan_xd describe them; unverified
/// against a device: that `Run` ends the login, and that an unknown variable is refused with 3.
class SopasDevice {
 public:
  SopasDevice();

  /// What the client sent; the answers.
  std::string receive(std::string_view bytes);
  void disconnected();
  /// Off and on: what was written is lost.
  void power_cycle();

  /// Arguments as an answer has them, by the variable's name.
  std::map<std::string, std::string> variables;
  /// Refuse what begins so ("sWN ScanDataEthSettings") with that code.
  std::map<std::string, int> refusals;
  std::string password = "F4724744";  ///< of level 3
  bool measuring = false;             ///< LMCstartmeas was called since it was switched on
  std::vector<std::string> commands;  ///< all that came, without their frames

 private:
  std::string answer(const std::string& command);

  std::map<std::string, std::string> at_start_;
  std::string buffer_;
  bool logged_in_ = false;
};

}  // namespace lidard::sim
