// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "drivers/velodyne/web/web_dialogue.h"

namespace lidard::velodyne {
namespace {

TEST(HttpMessage, AsksAndPostsOnAConnectionForItself) {
  EXPECT_EQ(http_request("192.168.1.201:80", "/cgi/diag.json", ""),
            "GET /cgi/diag.json HTTP/1.1\r\nHost: 192.168.1.201:80\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(http_request("[fe80::1]:80", "/cgi/setting", "rpm=600"),
            "POST /cgi/setting HTTP/1.1\r\nHost: [fe80::1]:80\r\nConnection: close\r\n"
            "Content-Type: application/x-www-form-urlencoded\r\nContent-Length: 7\r\n\r\nrpm=600");
}

TEST(HttpMessage, EndsWithItsLengthWhereverItIsCut) {
  const std::string whole = "HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\n{\"\":1";
  for (std::size_t n = 0; n < whole.size(); ++n) {
    const HttpAnswer part = read_http_answer(whole.substr(0, n), false);
    EXPECT_FALSE(part.complete) << n;
    const HttpAnswer broken = read_http_answer(whole.substr(0, n), true);
    EXPECT_TRUE(broken.complete) << n;
    EXPECT_NE(broken.error, "") << n;
  }
  const HttpAnswer answer = read_http_answer(whole, false);
  EXPECT_TRUE(answer.complete);
  EXPECT_EQ(answer.status, 200U);
  EXPECT_EQ(answer.body, "{\"\":1");
  EXPECT_EQ(answer.error, "");
}

TEST(HttpMessage, EndsWithTheConnectionWhereThereIsNoLength) {
  const std::string whole = "HTTP/1.0 200 OK\r\n\r\n{}";
  EXPECT_FALSE(read_http_answer(whole, false).complete);
  const HttpAnswer answer = read_http_answer(whole, true);
  EXPECT_EQ(answer.body, "{}");
  EXPECT_EQ(answer.error, "");
}

TEST(HttpMessage, KeepsWhatCameOfABodyThatIsTooShort) {
  const HttpAnswer answer = read_http_answer("HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\n{}", true);
  EXPECT_EQ(answer.status, 200U);
  EXPECT_EQ(answer.body, "{}");
  EXPECT_EQ(answer.error, "the answer is incomplete");
}

TEST(HttpMessage, IsRefusedWhereItIsNoHttpOrHasNoEnd) {
  for (const std::string& bytes :
       {std::string("SSH-2.0-OpenSSH_9\r\n\r\n"), std::string(100'000, 'x'),
        "HTTP/1.1 200 OK\r\nA: " + std::string(100'000, 'x'),
        "HTTP/1.1 200 OK\r\nContent-Length: 99999999\r\n\r\n" + std::string(100'000, ' '),
        "HTTP/1.0 200 OK\r\n\r\n" + std::string(100'000, ' ')}) {
    const HttpAnswer answer = read_http_answer(bytes, false);
    EXPECT_TRUE(answer.complete) << bytes.substr(0, 40);
    EXPECT_NE(answer.error, "") << bytes.substr(0, 40);
  }
}

}  // namespace
}  // namespace lidard::velodyne
