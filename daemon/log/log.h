// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/core.h>

#include <string>
#include <utility>

namespace lidard {

enum class LogLevel { info, warn, error };

/// From now on lines go to `receiver` instead of the log of set_up_logging(). Call it before other threads
/// start.
void set_log_receiver(void (*receiver)(LogLevel level, const std::string& text));
/// Writes a line to the log.
void log_line(LogLevel level, const std::string& text);

// Formats here and logs in log.cpp, since spdlog's templates cost 2 s of compile time per unit.
template <class... Values>
void log_info(fmt::format_string<Values...> form, Values&&... values) {
  log_line(LogLevel::info, fmt::format(form, std::forward<Values>(values)...));
}
template <class... Values>
void log_warn(fmt::format_string<Values...> form, Values&&... values) {
  log_line(LogLevel::warn, fmt::format(form, std::forward<Values>(values)...));
}
template <class... Values>
void log_error(fmt::format_string<Values...> form, Values&&... values) {
  log_line(LogLevel::error, fmt::format(form, std::forward<Values>(values)...));
}

}  // namespace lidard
