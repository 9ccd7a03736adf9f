// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace lidard::velodyne {

/// What came back on a request. A small device's server may break off in the middle: then there is a status,
/// some of the body and an error, and the caller knows whether that is enough.
struct HttpAnswer {
  unsigned status = 0;    ///< 0: no header came
  std::string body;       ///< as much as came
  bool complete = false;  ///< nothing more belongs to it
  std::string error;      ///< why it is not whole; empty: it is, or more may come
};

/// A request of HTTP/1.1 after which the connection is closed. `host` as Endpoint::to_string() has it. An
/// empty `form`: GET, else POST of that form.
std::string http_request(const std::string& host, const std::string& path, const std::string& form);

/// Reads what came on a connection so far; `ended`: the device closed it. Accepts HTTP/1.0, answers without a
/// length, and lengths that are too large.
HttpAnswer read_http_answer(std::string_view bytes, bool ended);

}  // namespace lidard::velodyne
