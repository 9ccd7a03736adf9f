// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/http_client.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <utility>

namespace lidard {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

/// RFC 3986, section 3.2.2: an IPv6 address stands in brackets.
std::string host_field(const HttpPost& post) {
  const std::string host = post.host.find(':') == std::string::npos ? post.host : "[" + post.host + "]";
  return post.port == 80 ? host : host + ":" + std::to_string(post.port);
}

/// One request. Each step starts the next; the stream's time limit ends whatever takes too long.
class Exchange {
 public:
  Exchange(asio::io_context& io, const HttpPost& post, Span limit)
      : resolver_(io), stream_(io), limit_(limit), request_(http::verb::post, post.path, 11, post.body) {
    request_.set(http::field::host, host_field(post));
    request_.set(http::field::content_type, post.content_type);
    request_.keep_alive(false);
    request_.prepare_payload();
    // A literal address needs no resolver, whose thread cannot be interrupted.
    beast::error_code no_address;
    const auto address = asio::ip::make_address(post.host, no_address);
    if (!no_address) {
      connect(tcp::resolver::results_type::create({address, post.port}, "", ""));
      return;
    }
    resolver_.async_resolve(post.host, std::to_string(post.port),
                            [this](beast::error_code error, const tcp::resolver::results_type& found) {
                              if (!failed(error)) connect(found);
                            });
  }
  std::string answer(std::string& error) {
    if (error_)
      error = error_ == beast::error::timeout ? "no answer in time" : error_.message();
    else if (response_.result() != http::status::ok)
      error = "HTTP status " + std::to_string(response_.result_int());
    else
      return std::move(response_.body());
    return {};
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

  tcp::resolver resolver_;
  beast::tcp_stream stream_;
  Span limit_;
  http::request<http::string_body> request_;
  http::response<http::string_body> response_;
  beast::flat_buffer buffer_;
  beast::error_code error_;
};

}  // namespace

std::string http_post(const HttpPost& post, Span limit, std::string& error) {
  asio::io_context io{1};
  Exchange exchange(io, post, limit);
  io.run();
  return exchange.answer(error);
}

}  // namespace lidard
