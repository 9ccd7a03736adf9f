// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/socket.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
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

/// A socket address and its length.
using SocketAddress = std::pair<sockaddr_storage, socklen_t>;
/// The TCP addresses of a host; empty if no name server knows the host within `limit`.
std::vector<SocketAddress> resolve(const std::string& host, std::uint16_t port, Span limit);

/// Calls a method of an XML-RPC server and waits `limit` at most: roscpp's own client waits for ever when the
/// master hangs. Returns the value, or nothing and the reason in `error`.
std::optional<XmlRpc::XmlRpcValue> xmlrpc_call(const XmlRpcServer& server, const std::string& method,
                                               const XmlRpc::XmlRpcValue& arguments, Span limit,
                                               std::string& error);

}  // namespace lidard
