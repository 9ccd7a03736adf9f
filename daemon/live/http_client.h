// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/time.h"

namespace lidard {

/// One request; the connection is closed after it.
struct HttpRequest {
  std::string host;  ///< name or address
  std::uint16_t port = 80;
  std::string path;
  std::string content_type;  ///< empty: GET, else POST of `body`
  std::string body;
};

/// What came back. A small device's server may break off in the middle: then there is a status, some of the
/// body and an error, and the caller knows whether that is enough.
struct HttpAnswer {
  unsigned status = 0;        ///< 0: no header came
  std::string body;           ///< as much as came
  std::string error;          ///< why the answer is not whole; empty: it is
  bool connected = false;     ///< somebody took the connection
  std::string local_address;  ///< ours on this connection

  /// A whole answer with this status.
  bool is(unsigned wanted) const { return error.empty() && status == wanted; }
};

/// Makes requests one after the other and waits for each no longer than its limit. Speaks HTTP/1.1 and
/// accepts HTTP/1.0, answers without a length, and lengths that are too large.
class HttpClient {
 public:
  HttpClient();
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  HttpAnswer request(const HttpRequest& request, Span limit);
  /// Ends a request that is under way, and all later ones, at once. May be called from any thread.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lidard
