// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <charconv>
#include <utility>

#include "daemon/ros_master.h"

namespace lidard {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

/// One POST. Each step starts the next; the stream's time limit ends whatever takes too long.
class Post {
 public:
  Post(const XmlRpcServer& server, std::string body, Span limit)
      : resolver_(io_), stream_(io_), limit_(limit) {
    request_.method(http::verb::post);
    request_.target("/RPC2");
    request_.set(http::field::host, server.host);
    request_.set(http::field::content_type, "text/xml");
    request_.keep_alive(false);
    request_.body() = std::move(body);
    request_.prepare_payload();
    resolver_.async_resolve(server.host, std::to_string(server.port),
                            [this](beast::error_code error, const tcp::resolver::results_type& found) {
                              if (!failed(error)) connect(found);
                            });
  }

  /// The body of the answer, or nothing.
  std::optional<std::string> run(std::string& error) {
    io_.run();
    if (error_) {
      error = error_ == beast::error::timeout ? "no answer in time" : error_.message();
      return std::nullopt;
    }
    if (response_.result() != http::status::ok) {
      error = "HTTP status " + std::to_string(response_.result_int());
      return std::nullopt;
    }
    return std::move(response_.body());
  }

 private:
  void connect(const tcp::resolver::results_type& found) {
    stream_.expires_after(limit_);
    stream_.async_connect(found, [this](beast::error_code error, const tcp::endpoint&) {
      if (!failed(error)) write();
    });
  }
  void write() {
    http::async_write(stream_, request_, [this](beast::error_code error, std::size_t) {
      if (!failed(error)) read();
    });
  }
  void read() {
    http::async_read(stream_, buffer_, response_,
                     [this](beast::error_code error, std::size_t) { failed(error); });
  }
  bool failed(beast::error_code error) {
    error_ = error;
    return static_cast<bool>(error);
  }

  asio::io_context io_;
  tcp::resolver resolver_;
  beast::tcp_stream stream_;
  Span limit_;
  http::request<http::string_body> request_;
  beast::flat_buffer buffer_;
  http::response<http::string_body> response_;
  beast::error_code error_;
};

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
  Post post(server, request_body(method, arguments), limit);
  const auto body = post.run(error);
  return body ? answer(*body, error) : std::nullopt;
}

}  // namespace lidard
