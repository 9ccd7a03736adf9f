// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/http_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "test/support/ros_master.h"
#include "test/support/tcp_peer.h"

namespace lidard::test {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// Takes one request and answers it.
class Server {
 public:
  explicit Server(std::string answer) : answer_(std::move(answer)), thread_([this] { serve(); }) {}
  ~Server() {
    ended_ = true;
    thread_.join();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  std::uint16_t port() const { return peer_.port(); }
  const std::string& request() const { return request_; }

 private:
  void serve() {
    const auto rest = [] { std::this_thread::sleep_for(std::chrono::milliseconds(2)); };
    while (!ended_ && !peer_.accept()) rest();
    while (!ended_ && request_.find("the body") == std::string::npos) {
      request_ += peer_.read();
      rest();
    }
    if (answer_.empty()) {
      while (!ended_) rest();
    } else {
      peer_.send(answer_);
    }
    peer_.close_client();
  }

  TcpPeer peer_;
  std::string answer_, request_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

HttpPost post_to(std::uint16_t port) { return {"127.0.0.1", port, "/RPC2", "text/xml", "the body"}; }

constexpr Span patience = std::chrono::seconds(20);

TEST(HttpPost, SendsTheBodyAndReturnsThatOfTheAnswer) {
  std::string error, answer, request;
  std::uint16_t port = 0;
  {
    Server server("HTTP/1.0 200 OK\r\nContent-Length: 5\r\n\r\nfine!");
    port = server.port();
    answer = http_post(post_to(port), patience, error);
    request = server.request();
  }
  EXPECT_EQ(answer, "fine!");
  EXPECT_EQ(error, "");
  EXPECT_THAT(request, AllOf(StartsWith("POST /RPC2 HTTP/1.1\r\n"), EndsWith("\r\n\r\nthe body"),
                             HasSubstr("Host: 127.0.0.1:" + std::to_string(port) + "\r\n"),
                             HasSubstr("Content-Type: text/xml\r\n"), HasSubstr("Content-Length: 8\r\n"),
                             HasSubstr("Connection: close\r\n")));
}

TEST(HttpPost, ResolvesAName) {
  std::string error;
  const Server server("HTTP/1.0 200 OK\r\nContent-Length: 2\r\n\r\nok");
  HttpPost post = post_to(server.port());
  post.host = "localhost";
  EXPECT_EQ(http_post(post, patience, error), "ok") << error;
}

TEST(HttpPost, TellsAStatusThatIsNot200) {
  std::string error;
  const Server server("HTTP/1.0 404 Not Found\r\nContent-Length: 4\r\n\r\nnone");
  EXPECT_EQ(http_post(post_to(server.port()), patience, error), "");
  EXPECT_EQ(error, "HTTP status 404");
}

TEST(HttpPost, GivesUpAfterItsLimit) {
  std::string error;
  const Server server("");
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(http_post(post_to(server.port()), std::chrono::milliseconds(200), error), "");
  EXPECT_EQ(error, "no answer in time");
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(190));
}

TEST(HttpPost, SaysThatNobodyListensOrThatTheAnswerIsNone) {
  std::string error;
  EXPECT_EQ(http_post(post_to(free_port()), patience, error), "");
  EXPECT_THAT(error, HasSubstr("refused"));
  const Server server("nonsense\r\n\r\n");
  error.clear();
  EXPECT_EQ(http_post(post_to(server.port()), patience, error), "");
  EXPECT_NE(error, "");
}

}  // namespace
}  // namespace lidard::test
