// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <utility>

#include "daemon/live/http_client.h"
#include "daemon/ros/ros_master.h"

namespace lidard {
namespace {

std::string request_body(const std::string& method, const XmlRpc::XmlRpcValue& arguments) {
  std::string body = "<?xml version=\"1.0\"?><methodCall><methodName>" + method + "</methodName><params>";
  for (int i = 0; i < arguments.size(); ++i) body += "<param>" + arguments[i].toXml() + "</param>";
  return body + "</params></methodCall>";
}

std::optional<XmlRpc::XmlRpcValue> answer(const std::string& body, std::string& error) {
  const auto begin = body.find("<value>");
  if (begin == std::string::npos || body.find("<fault>") != std::string::npos) {
    error = "the answer is a fault";
    return std::nullopt;
  }
  int offset = static_cast<int>(begin);
  XmlRpc::XmlRpcValue value(body, &offset);
  if (!value.valid()) {
    error = "the answer is not XML-RPC";
    return std::nullopt;
  }
  return value;
}

}  // namespace

std::optional<XmlRpcServer> parse_server_uri(const std::string& uri) {
  const std::string scheme = "http://";
  if (uri.compare(0, scheme.size(), scheme) != 0) return std::nullopt;
  std::string rest = uri.substr(scheme.size());
  if (!rest.empty() && rest.back() == '/') rest.pop_back();
  const auto colon = rest.rfind(':');
  if (colon == std::string::npos || colon == 0) return std::nullopt;
  XmlRpcServer server{rest.substr(0, colon), 0};
  const char* end = rest.data() + rest.size();
  const auto parsed = std::from_chars(rest.data() + colon + 1, end, server.port);
  if (parsed.ec != std::errc() || parsed.ptr != end || server.port == 0) return std::nullopt;
  return server;
}

std::optional<XmlRpc::XmlRpcValue> xmlrpc_call(const XmlRpcServer& server, const std::string& method,
                                               const XmlRpc::XmlRpcValue& arguments, Span limit,
                                               std::string& error) {
  error.clear();
  const std::string got = http_post(
      {server.host, server.port, "/RPC2", "text/xml", request_body(method, arguments)}, limit, error);
  if (!error.empty()) return std::nullopt;
  return answer(got, error);
}

}  // namespace lidard
