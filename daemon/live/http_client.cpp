// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/http_client.h"

#include <atomic>
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
std::string host_field(const HttpRequest& request) {
  const std::string host =
      request.host.find(':') == std::string::npos ? request.host : "[" + request.host + "]";
  return request.port == 80 ? host : host + ":" + std::to_string(request.port);
}

/// One request. Each step starts the next; the stream's time limit ends whatever takes too long.
class Exchange {
 public:
  Exchange(asio::io_context& io, const HttpRequest& request, Span limit)
      : resolver_(io), stream_(io), limit_(limit) {
    const bool post = !request.content_type.empty();
    request_.method(post ? http::verb::post : http::verb::get);
    request_.target(request.path);
    request_.set(http::field::host, host_field(request));
    request_.keep_alive(false);
    if (post) request_.set(http::field::content_type, request.content_type);
    request_.body() = request.body;
    request_.prepare_payload();
    find(request);
  }

  HttpAnswer answer() {
    HttpAnswer answer;
    answer.connected = connected_;
    answer.local_address = local_address_;
    if (parser_.is_header_done()) {
      answer.status = parser_.get().result_int();
      answer.body = std::move(parser_.get().body());
    }
    if (!finished_) answer.error = "stopped";
    if (error_) answer.error = reason();
    return answer;
  }

 private:
  std::string reason() const {
    if (error_ == beast::error::timeout) return "no answer in time";
    if (error_ == http::error::end_of_stream) return "the connection was closed without an answer";
    if (error_ == http::error::partial_message) return "the answer ends in its middle";
    return error_.message();
  }
  /// A literal address needs no resolver, whose thread cannot be interrupted.
  void find(const HttpRequest& request) {
    beast::error_code no_address;
    const auto address = asio::ip::make_address(request.host, no_address);
    if (!no_address) {
      stream_.expires_after(limit_);
      stream_.async_connect(tcp::endpoint(address, request.port),
                            [this](beast::error_code error) { on_connect(error); });
      return;
    }
    resolver_.async_resolve(request.host, std::to_string(request.port),
                            [this](beast::error_code error, const tcp::resolver::results_type& found) {
                              if (!failed(error)) connect(found);
                            });
  }
  void connect(const tcp::resolver::results_type& found) {
    stream_.expires_after(limit_);
    stream_.async_connect(found,
                          [this](beast::error_code error, const tcp::endpoint&) { on_connect(error); });
  }
  void on_connect(beast::error_code error) {
    if (failed(error)) return;
    connected_ = true;
    beast::error_code unknown;
    const auto local = stream_.socket().local_endpoint(unknown);
    if (!unknown) local_address_ = local.address().to_string();
    write();
  }
  void write() {
    http::async_write(stream_, request_, [this](beast::error_code error, std::size_t) {
      if (!failed(error)) read();
    });
  }
  void read() {
    http::async_read(stream_, buffer_, parser_, [this](beast::error_code error, std::size_t) {
      failed(error);
      finished_ = true;
    });
  }
  bool failed(beast::error_code error) {
    error_ = error;
    finished_ = finished_ || error_;
    return static_cast<bool>(error_);
  }

  tcp::resolver resolver_;
  beast::tcp_stream stream_;
  Span limit_;
  http::request<http::string_body> request_;
  beast::flat_buffer buffer_;
  http::response_parser<http::string_body> parser_;
  beast::error_code error_;
  bool connected_ = false;
  bool finished_ = false;
  std::string local_address_;
};

}  // namespace

struct HttpClient::Impl {
  std::atomic<bool> stopped{false};
  asio::io_context io{1};
};

HttpClient::HttpClient() : impl_(std::make_unique<Impl>()) {}
HttpClient::~HttpClient() = default;

HttpAnswer HttpClient::request(const HttpRequest& request, Span limit) {
  // A stop() after restart() ends run(); one before is seen in `stopped`.
  impl_->io.restart();
  if (impl_->stopped) {
    HttpAnswer nothing;
    nothing.error = "stopped";
    return nothing;
  }
  Exchange exchange(impl_->io, request, limit);
  impl_->io.run();
  HttpAnswer answer = exchange.answer();
  return answer;
}

void HttpClient::stop() {
  impl_->stopped = true;
  impl_->io.stop();
}

}  // namespace lidard
