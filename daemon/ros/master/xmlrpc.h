// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace lidard {

/// Address of an XML-RPC server.
struct XmlRpcServer {
  std::string host;
  std::uint16_t port = 0;
};
/// Parses "http://host:port/"; empty if the text is something else.
std::optional<XmlRpcServer> parse_server_uri(const std::string& uri);

/// The addresses of a host, as numbers; empty if no name server knows the host within `limit`.
std::vector<std::string> resolve(const std::string& host, Span limit);

/// Calls a method of an XML-RPC server and waits about `limit` at most: XmlRpcClient::execute() waits for
/// ever when the master hangs. Returns the value, or nothing and the reason in `error`.
std::optional<XmlRpc::XmlRpcValue> xmlrpc_call(const XmlRpcServer& server, const std::string& method,
                                               const XmlRpc::XmlRpcValue& arguments, Span limit,
                                               std::string& error);

}  // namespace lidard
