// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/master/xmlrpc.h"

#include <netdb.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <future>
#include <memory>
#include <thread>

namespace lidard {
namespace {

using XmlRpc::XmlRpcValue;

using Clock = std::chrono::steady_clock;

constexpr std::size_t longest_answer = 8UL * 1024 * 1024;
constexpr const char* end_of_answer = "</methodResponse>";

std::vector<SocketAddress> addresses_of(const std::string& host, std::uint16_t port, int flags) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = flags;
  addrinfo* found = nullptr;
  std::vector<SocketAddress> addresses;
  if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found) != 0) return addresses;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    auto& [address, length] = addresses.emplace_back();
    std::memcpy(&address, one->ai_addr, one->ai_addrlen);
    length = one->ai_addrlen;
  }
  freeaddrinfo(found);
  return addresses;
}

struct Socket {
  explicit Socket(int family) : fd(socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0)) {}
  ~Socket() {
    if (fd >= 0) close(fd);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  const int fd;
};

/// Limits the next call to `end`; false, with errno, if `end` has passed.
bool set_limit(int fd, Clock::time_point end) {
  const auto left = std::chrono::duration_cast<std::chrono::microseconds>(end - Clock::now()).count();
  const timeval limit{left / 1'000'000, left % 1'000'000};
  errno = EAGAIN;
  return left > 0 && setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit) == 0 &&
         setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit) == 0;
}

/// Sends the request and returns the bytes up to the end of the answer or the connection; nothing, with
/// errno, if a call failed or `end` passed.
std::optional<std::string> exchange(const SocketAddress& to, const std::string& request,
                                    Clock::time_point end) {
  const Socket with(to.first.ss_family);
  const auto* const address = reinterpret_cast<const sockaddr*>(&to.first);
  if (!set_limit(with.fd, end) || connect(with.fd, address, to.second) != 0) return std::nullopt;
  for (std::size_t sent = 0; sent < request.size();) {
    if (!set_limit(with.fd, end)) return std::nullopt;
    const ssize_t n = send(with.fd, request.data() + sent, request.size() - sent, MSG_NOSIGNAL);
    if (n < 0) return std::nullopt;
    sent += static_cast<std::size_t>(n);
  }
  std::string answer;
  char buffer[16384];
  while (answer.size() < longest_answer && answer.find(end_of_answer) == std::string::npos) {
    if (!set_limit(with.fd, end)) return std::nullopt;
    const ssize_t n = recv(with.fd, buffer, sizeof buffer, 0);
    if (n < 0) return std::nullopt;
    if (n == 0) break;
    answer.append(buffer, static_cast<std::size_t>(n));
  }
  return answer;
}

std::string request_of(const XmlRpcServer& server, const std::string& method, const XmlRpcValue& arguments) {
  std::string body = "<?xml version=\"1.0\"?><methodCall><methodName>" + method + "</methodName><params>";
  for (int i = 0; i < arguments.size(); ++i) body += "<param>" + arguments[i].toXml() + "</param>";
  body += "</params></methodCall>";
  // RFC 3986, section 3.2.2: an IPv6 address stands in brackets.
  const bool v6 = server.host.find(':') != std::string::npos;
  return "POST /RPC2 HTTP/1.0\r\nHost: " + (v6 ? "[" + server.host + "]" : server.host) + ":" +
         std::to_string(server.port) +
         "\r\nContent-Type: text/xml\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

/// The fault of an HTTP answer; empty: it is complete, with status 200.
std::string trouble_with(const std::string& answer) {
  if (answer.empty()) return "the connection was closed without an answer";
  if (answer.compare(0, 7, "HTTP/1.") != 0 || answer.size() < 12) return "the answer is not HTTP";
  if (const std::string status = answer.substr(9, 3); status != "200") return "HTTP status " + status;
  if (answer.find(end_of_answer) == std::string::npos) return "the answer has no end";
  return answer.find("<fault>") == std::string::npos ? "" : "the answer is a fault";
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

std::vector<SocketAddress> resolve(const std::string& host, std::uint16_t port, Span limit) {
  // A literal address needs no name server.
  if (auto literal = addresses_of(host, port, AI_NUMERICHOST); !literal.empty()) return literal;
  // Resolving cannot be interrupted: a thread that hangs there is left behind.
  const auto answer = std::make_shared<std::promise<std::vector<SocketAddress>>>();
  auto waiting = answer->get_future();
  std::thread([host, port, answer] { answer->set_value(addresses_of(host, port, 0)); }).detach();
  if (waiting.wait_for(limit) != std::future_status::ready) return {};
  return waiting.get();
}

std::optional<XmlRpcValue> xmlrpc_call(const XmlRpcServer& server, const std::string& method,
                                       const XmlRpcValue& arguments, Span limit, std::string& error) {
  const auto end = Clock::now() + limit;
  const std::string request = request_of(server, method, arguments);
  error = "no name server knows " + server.host;
  std::optional<std::string> answer;
  for (const SocketAddress& address : resolve(server.host, server.port, limit)) {
    if ((answer = exchange(address, request, end))) break;
    const bool late = errno == EAGAIN || errno == EINPROGRESS;
    error = late ? "no answer in time" : std::strerror(errno);
  }
  if (!answer || !(error = trouble_with(*answer)).empty()) return std::nullopt;
  int begin = static_cast<int>(answer->find("<value>"));
  if (begin >= 0) {
    XmlRpcValue value(*answer, &begin);
    if (value.valid()) return value;
  }
  error = "the answer is not XML-RPC";
  return std::nullopt;
}

}  // namespace lidard
