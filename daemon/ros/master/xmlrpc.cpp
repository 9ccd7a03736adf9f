// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/master/xmlrpc.h"

#include <netdb.h>
#include <xmlrpcpp/XmlRpcClient.h>
#include <xmlrpcpp/XmlRpcUtil.h>

#include <atomic>
#include <charconv>
#include <chrono>
#include <future>
#include <memory>
#include <system_error>
#include <thread>

namespace lidard {
namespace {

using Clock = std::chrono::steady_clock;

std::vector<std::string> addresses_of(const std::string& host, int flags) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = flags;
  addrinfo* found = nullptr;
  std::vector<std::string> addresses;
  if (getaddrinfo(host.c_str(), nullptr, &wanted, &found) != 0) return addresses;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    char text[NI_MAXHOST];
    if (getnameinfo(one->ai_addr, one->ai_addrlen, text, sizeof text, nullptr, 0, NI_NUMERICHOST) == 0)
      addresses.emplace_back(text);
  }
  freeaddrinfo(found);
  return addresses;
}

/// The library would print errors of its parts. Its handler is one for the process, set once: other threads
/// use it.
class Silence final : public XmlRpc::XmlRpcErrorHandler {
 public:
  Silence() { setErrorHandler(this); }

 private:
  void error(const char*) override {}
};

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

std::vector<std::string> resolve(const std::string& host, Span limit) {
  // A literal address needs no name server.
  if (auto literal = addresses_of(host, AI_NUMERICHOST); !literal.empty()) return literal;
  // Resolving cannot be interrupted: a thread that hangs there is left behind, but not more than a few.
  constexpr int most_waiting = 16;
  static std::atomic<int> waiting_threads{0};
  if (waiting_threads >= most_waiting) return {};
  ++waiting_threads;
  const auto answer = std::make_shared<std::promise<std::vector<std::string>>>();
  auto waiting = answer->get_future();
  try {
    std::thread([host, answer] {
      answer->set_value(addresses_of(host, 0));
      --waiting_threads;
    }).detach();
  } catch (const std::system_error&) {  // too many threads
    --waiting_threads;
    return {};
  }
  if (waiting.wait_for(limit) != std::future_status::ready) return {};
  return waiting.get();
}

std::optional<XmlRpc::XmlRpcValue> xmlrpc_call(const XmlRpcServer& server, const std::string& method,
                                               const XmlRpc::XmlRpcValue& arguments, Span limit,
                                               std::string& error) {
  static const Silence silence;
  const auto end = Clock::now() + limit;
  error = "no name server knows " + server.host;
  for (const std::string& address : resolve(server.host, limit)) {
    XmlRpc::XmlRpcClient client(address.c_str(), server.port, "/RPC2");
    if (client.executeNonBlock(method.c_str(), arguments))
      client._disp.work(std::max(0.0, seconds(end - Clock::now())));
    XmlRpc::XmlRpcValue value;
    const bool done = client.executeCheckDone(value);
    if (done && value.valid() && !client.isFault()) return value;
    error = client.isFault()               ? "the answer is a fault"
            : !done && Clock::now() >= end ? "no answer in time"
                                           : "nobody answers there in XML-RPC";
  }
  return std::nullopt;
}

}  // namespace lidard
