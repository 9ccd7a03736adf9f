// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/driver.h"
#include "drivers/sick/cola/cola_stream.h"

namespace lidard::sick {

constexpr std::string_view sopas_login = "sMN SetAccessMode";
/// Applies the written settings, and logs out.
constexpr std::string_view sopas_run = "sMN Run";

/// The current question to a SICK device (SOPAS) and its refusal.
class SopasSession {
 public:
  /// `level`, `password` (its hash): of the login unless the configuration names others.
  SopasSession(ColaDialect spoken, const DeviceRequests& requests, std::uint8_t level, std::uint32_t password)
      : dialect(spoken), level_(level), password_(password) {
    const auto number = [](const std::string& text, int base) {
      return std::strtoul(text.c_str(), nullptr, base);
    };
    if (!requests.user_level.empty()) level_ = static_cast<std::uint8_t>(number(requests.user_level, 10));
    if (!requests.password_hash.empty())
      password_ = static_cast<std::uint32_t>(number(requests.password_hash, 16));
  }

  /// The next question; the arguments of `command` ("sRN DeviceIdent") follow, except those of a login.
  ColaWriter ask(std::string_view command) {
    command_ = command;
    refusal_.reset();
    ColaWriter question(dialect, command);
    if (command == sopas_login) question.u8(level_).hash(password_);
    return question;
  }
  /// True if the telegram answers the last question.
  bool accept(const ColaTelegram& answer) {
    const bool error = answer.kind() == "sFA";
    if (!error && answer.name() != std::string_view(command_).substr(4)) return false;
    if (error) refusal_ = cola_error_code(answer);
    return true;
  }
  /// The command of the last question.
  const std::string& command() const { return command_; }
  /// The error code of the last question; empty: it was not refused.
  std::optional<std::uint8_t> refusal() const { return refusal_; }
  unsigned level() const { return level_; }

  ColaDialect dialect;

 private:
  std::uint8_t level_;
  std::uint32_t password_;
  std::string command_;
  std::optional<std::uint8_t> refusal_;
};

}  // namespace lidard::sick
