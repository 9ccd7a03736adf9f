// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/log/log.h"

#include <spdlog/spdlog.h>

namespace lidard {
namespace {

void (*log_receiver)(LogLevel level, const std::string& text) = nullptr;

}  // namespace

void set_log_receiver(void (*receiver)(LogLevel level, const std::string& text)) { log_receiver = receiver; }

void log_line(LogLevel level, const std::string& text) {
  if (log_receiver != nullptr) return log_receiver(level, text);
  const auto as = level == LogLevel::info   ? spdlog::level::info
                  : level == LogLevel::warn ? spdlog::level::warn
                                            : spdlog::level::err;
  spdlog::default_logger_raw()->log(as, text);
}

}  // namespace lidard
