// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <boost/beast/http.hpp>
#include <sstream>
#include <utility>

#include "drivers/velodyne/web/web_dialogue.h"

namespace lidard::velodyne {
namespace {

namespace http = boost::beast::http;

// A snapshot has some 80 values.
constexpr std::uint32_t longest_header = 8192;
constexpr std::uint64_t longest_body = 65'536;

}  // namespace

std::string http_request(const std::string& host, const std::string& path, const std::string& form) {
  http::request<http::string_body> request(form.empty() ? http::verb::get : http::verb::post, path, 11, form);
  request.set(http::field::host, host);
  request.keep_alive(false);
  if (!form.empty()) request.set(http::field::content_type, "application/x-www-form-urlencoded");
  request.prepare_payload();
  std::ostringstream text;
  text << request;
  return text.str();
}

HttpAnswer read_http_answer(std::string_view bytes, bool ended) {
  http::response_parser<http::string_body> parser;
  parser.header_limit(longest_header);
  parser.body_limit(longest_body);
  boost::beast::error_code error;
  // The header is parsed first: otherwise the parser does not report a length beyond its limit.
  const std::size_t header =
      bytes.empty() ? 0 : parser.put(boost::asio::buffer(bytes.data(), bytes.size()), error);
  parser.eager(true);
  if (!error && header < bytes.size())
    parser.put(boost::asio::buffer(bytes.data() + header, bytes.size() - header), error);
  if (error == http::error::need_more) error = {};
  // put_eof() asserts that the parser was given bytes.
  if (!error && ended && !bytes.empty() && !parser.is_done()) parser.put_eof(error);
  HttpAnswer answer;
  if (parser.is_header_done()) {
    answer.status = parser.get().result_int();
    answer.body = std::move(parser.get().body());
  }
  answer.complete = error || ended || parser.is_done();
  if (error == http::error::partial_message)
    answer.error = "the answer is incomplete";
  else if (error == http::error::end_of_stream || (ended && bytes.empty()))
    answer.error = "the connection was closed without an answer";
  else if (error)
    answer.error = error.message();
  return answer;
}

}  // namespace lidard::velodyne
