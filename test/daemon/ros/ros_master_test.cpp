// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>

#include "daemon/ros/master/environment.h"
#include "daemon/ros/master/master_client.h"
#include "test/support/ros_listener.h"
#include "test/support/starved.h"
#include "test/support/tcp_peer.h"

namespace lidard {
namespace {

using namespace std::chrono_literals;
using test::in_own_process;
using test::RosMaster;
using SteadyClock = std::chrono::steady_clock;

/// Far above what a call takes on a crowded machine, far below what roscpp takes when the master hangs (15 s
/// and more).
constexpr auto surely_not_hanging = 3s;

TEST(RosLogFolder, IsChosenWhereTheHomeCannotBeWritten) {
  in_own_process([] {
    unsetenv("ROS_LOG_DIR");
    unsetenv("ROS_HOME");
    setenv("HOME", "/nonexistent", 1);
    setenv("RUNTIME_DIRECTORY", "/run/lidard", 1);
    choose_ros_log_folder();
    ASSERT_NE(std::getenv("ROS_LOG_DIR"), nullptr);
    EXPECT_STREQ(std::getenv("ROS_LOG_DIR"), "/run/lidard");
    unsetenv("ROS_LOG_DIR");
    setenv("HOME", "/tmp", 1);
    choose_ros_log_folder();
    EXPECT_EQ(std::getenv("ROS_LOG_DIR"), nullptr);
  });
}

TEST(MasterClient, GivesUpAfterItsLimit) {
  in_own_process([] {
    RosMaster master;
    MasterClient client({"127.0.0.1", master.port()}, "/test");
    const test::Starved starved;
    auto begin = SteadyClock::now();
    EXPECT_FALSE(client.pid());
    EXPECT_LT(SteadyClock::now() - begin, surely_not_hanging + starved.time()) << "nobody listens";
    master.start();
    EXPECT_TRUE(client.pid());
    master.pause();
    begin = SteadyClock::now();
    EXPECT_FALSE(client.pid());
    EXPECT_EQ(client.error(), "no answer in time");
    EXPECT_LT(SteadyClock::now() - begin, surely_not_hanging + starved.time());
  });
}

/// Answers one request with these bytes and closes the connection.
class OneAnswer {
 public:
  explicit OneAnswer(std::string bytes) : thread_([this, bytes = std::move(bytes)] { serve(bytes); }) {}
  ~OneAnswer() { thread_.join(); }
  OneAnswer(const OneAnswer&) = delete;
  OneAnswer& operator=(const OneAnswer&) = delete;
  std::uint16_t port() const { return peer_.port(); }

 private:
  void serve(const std::string& bytes) {
    const auto limit = SteadyClock::now() + 20s;
    while (!peer_.accept() && SteadyClock::now() < limit) std::this_thread::sleep_for(1ms);
    std::string request;
    while (request.find("</methodCall>") == std::string::npos && SteadyClock::now() < limit) {
      request += peer_.read();
      std::this_thread::sleep_for(1ms);
    }
    peer_.send(bytes);
    peer_.close_client();
  }

  test::TcpPeer peer_;
  std::thread thread_;
};

std::string http_answer(const std::string& body, const std::string& status = "200 OK") {
  return "HTTP/1.1 " + status +
         "\r\nContent-Type: text/xml\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

std::string xml_answer(const std::string& value) {
  return "<?xml version=\"1.0\"?><methodResponse><params><param><value>" + value +
         "</value></param></params></methodResponse>";
}

std::string master_answer(const std::string& code, const std::string& value) {
  return xml_answer("<array><data><value><int>" + code + "</int></value><value>told</value><value>" + value +
                    "</value></data></array>");
}

/// What a client makes of an answer: the process number, or the error.
std::string pid_from(const std::string& bytes, Span limit = 10s) {
  OneAnswer master(bytes);
  MasterClient client({"127.0.0.1", master.port()}, "/test", limit);
  const auto pid = client.pid();
  return pid ? std::to_string(*pid) : "error: " + client.error();
}

TEST(MasterClient, TakesTheAnswerOfAMasterAndNothingElse) {
  EXPECT_EQ(pid_from(http_answer(master_answer("1", "<int>4711</int>"))), "4711");
  EXPECT_EQ(pid_from(http_answer(master_answer("0", "<int>4711</int>"))),
            "error: getPid: the master refused");
  EXPECT_EQ(pid_from(http_answer(master_answer("-1", "<int>0</int>"))), "error: getPid: the master refused");
  EXPECT_EQ(pid_from(http_answer(xml_answer("<int>1</int>"))), "error: getPid: the master refused");
  EXPECT_EQ(
      pid_from(http_answer("<methodResponse><fault><value><int>1</int></value></fault></methodResponse>")),
      "error: the answer is a fault");
  for (const char* other : {"<html>welcome</html>", "<methodResponse></methodResponse>"})
    EXPECT_EQ(pid_from(http_answer(other)), "error: nobody answers there in XML-RPC") << other;
  for (const char* other : {"", "SSH-2.0-OpenSSH_9.2\r\n", "HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\n<?"})
    EXPECT_EQ(pid_from(other, 500ms).substr(0, 7), "error: ") << other;
}

TEST(MasterClient, ASubscriptionThatTheMasterRefusesIsNone) {
  OneAnswer master(http_answer(master_answer("0", "<int>0</int>")));
  MasterClient client({"127.0.0.1", master.port()}, "/test", 10s);
  EXPECT_FALSE(client.register_subscriber("scan"));
}

TEST(MasterUri, IsTakenApart) {
  const auto uri = parse_server_uri("http://robot.local:11311/");
  ASSERT_TRUE(uri);
  EXPECT_EQ(uri->host, "robot.local");
  EXPECT_EQ(uri->port, 11311);
  for (const char* wrong : {"", "robot:11311", "http://robot", "http://:11311", "http://robot:0",
                            "http://robot:99999", "http://robot:11311x"})
    EXPECT_FALSE(parse_server_uri(wrong)) << wrong;
}

}  // namespace
}  // namespace lidard
