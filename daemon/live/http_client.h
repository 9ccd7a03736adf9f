// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/base/time.h"

namespace lidard {

struct HttpPost {
  std::string host;  ///< name or address
  std::uint16_t port = 80;
  std::string path;
  std::string content_type;
  std::string body;
};

/// Makes one request on a connection of its own and returns the body of the answer. Empty with the reason in
/// `error` where there is no answer with status 200 within the limit.
std::string http_post(const HttpPost& post, Span limit, std::string& error);

}  // namespace lidard
