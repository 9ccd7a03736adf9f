// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/log.h"

#include <spdlog/spdlog.h>

namespace lidard {

void log_line(LogLevel level, const std::string& text) {
  const auto as = level == LogLevel::info   ? spdlog::level::info
                  : level == LogLevel::warn ? spdlog::level::warn
                                            : spdlog::level::err;
  spdlog::default_logger_raw()->log(as, text);
}

}  // namespace lidard
