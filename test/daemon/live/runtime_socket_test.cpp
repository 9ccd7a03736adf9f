// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/runtime_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <fstream>
#include <thread>

namespace lidard {
namespace {

using ::testing::HasSubstr;

class RuntimeSocketTest : public ::testing::Test {
 protected:
  RuntimeSocketTest()
      : folder_(std::filesystem::temp_directory_path() / ("lidard-socket-" + std::to_string(getpid()))),
        socket_(io_, {{"status", [](const auto& reply) { reply("fine\n"); }},
                      {"events", [](const auto& reply) { reply(std::string(5'000'000, 'e')); }},
                      {"dump", [this](const auto& reply) { later_ = reply; }}}) {}
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    ASSERT_EQ(socket_.start(path()), "");
    thread_ = std::thread([this] { io_.run(); });
  }
  void TearDown() override {
    io_.stop();
    if (thread_.joinable()) thread_.join();
    later_ = {};
    socket_.stop();
    EXPECT_FALSE(std::filesystem::exists(path())) << "a daemon that ended leaves no socket";
    std::filesystem::remove_all(folder_);
  }
  std::string path() const { return (folder_ / "below" / "control").string(); }

  std::filesystem::path folder_;
  boost::asio::io_context io_;
  RuntimeSocket::Reply later_;
  RuntimeSocket socket_;
  std::thread thread_;
};

TEST_F(RuntimeSocketTest, AnswersAWordWithAText) {
  EXPECT_EQ(ask_daemon(path(), "status"), "fine\n");
  EXPECT_EQ(ask_daemon(path(), "status"), "fine\n");
  EXPECT_EQ(ask_daemon(path(), "events").size(), 5'000'000U);
  EXPECT_EQ(ask_daemon(path(), "halt"), "unknown request\n");
}

TEST_F(RuntimeSocketTest, AnswersLaterWhereTheAnswerTakesItsTime) {
  boost::asio::steady_timer timer(io_,
                                  std::chrono::milliseconds(2500));  // longer than its patience with askers
  timer.async_wait([this](const boost::system::error_code&) { later_("written\n"); });
  EXPECT_EQ(ask_daemon(path(), "dump"), "written\n");
}

TEST_F(RuntimeSocketTest, IsNotStoppedByThoseWhoSayNothingOrTooMuch) {
  const auto connected = [&] {
    const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return fd;
  };
  const int silent = connected();
  const int talkative = connected();
  const std::string words(1000, 'x');
  EXPECT_GT(::send(talkative, words.data(), words.size(), MSG_NOSIGNAL), 0);
  EXPECT_EQ(ask_daemon(path(), "status"), "fine\n");
  char byte = 0;
  EXPECT_LE(::recv(talkative, &byte, 1, 0), 0) << "the connection is ended";
  EXPECT_LE(::recv(silent, &byte, 1, 0), 0) << "this one too, when patience is over";
  ::close(silent);
  ::close(talkative);
}

TEST_F(RuntimeSocketTest, LeavesTheSocketOfALivingDaemonAlone) {
  RuntimeSocket second(io_, {});
  EXPECT_THAT(second.start(path()), HasSubstr("another daemon answers there"));
  EXPECT_EQ(ask_daemon(path(), "status"), "fine\n");
}

TEST_F(RuntimeSocketTest, TakesThePlaceOfADaemonThatWasKilled) {
  const std::string left = (folder_ / "left").string();
  {
    boost::asio::io_context io;
    boost::asio::local::stream_protocol::acceptor dead(io, left);
  }
  ASSERT_TRUE(std::filesystem::exists(left));
  RuntimeSocket next(io_, {});
  EXPECT_EQ(next.start(left), "");
}

TEST_F(RuntimeSocketTest, SaysWhyNobodyCanAsk) {
  RuntimeSocket other(io_, {});
  EXPECT_THAT(other.start("/proc/none/control"), HasSubstr("LIDARD_SOCKET"));
  const std::string file = (folder_ / "file").string();
  std::ofstream(file) << "mine";
  EXPECT_THAT(other.start(file), HasSubstr("LIDARD_SOCKET"));
  EXPECT_TRUE(std::filesystem::exists(file)) << "what is no socket is left alone";
  EXPECT_THAT(other.start("/tmp/" + std::string(120, 'a')),
              HasSubstr("at most 107 bytes; set LIDARD_SOCKET"));
}

TEST_F(RuntimeSocketTest, TellsWhoeverAsksWhereNobodyIs) {
  try {
    ask_daemon((folder_ / "nobody").string(), "status");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no daemon answers"));
    EXPECT_THAT(error.what(), HasSubstr("--socket"));
  }
}

TEST_F(RuntimeSocketTest, DoesNotWaitForADaemonThatHangs) {
  io_.stop();
  thread_.join();
  try {
    ask_daemon(path(), "status", std::chrono::milliseconds(100));
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("the daemon does not answer"));
  }
}

TEST(RuntimeSocketPath, IsWhereTheEnvironmentSays) {
  const auto with = [](const char* lidard, const char* systemd, const char* user) {
    for (const auto& [name, value] :
         {std::pair{"LIDARD_SOCKET", lidard}, {"RUNTIME_DIRECTORY", systemd}, {"XDG_RUNTIME_DIR", user}})
      value == nullptr ? unsetenv(name) : setenv(name, value, 1);
    return runtime_socket_path();
  };
  EXPECT_EQ(with("/a/b", "/run/lidard", "/run/user/1"), "/a/b");
  EXPECT_EQ(with(nullptr, "/run/lidard:/run/more", "/run/user/1"), "/run/lidard/control");
  EXPECT_EQ(with(nullptr, nullptr, "/run/user/1"), "/run/user/1/lidard/control");
  EXPECT_EQ(with(nullptr, nullptr, nullptr), "/run/lidard/control");
  // Of a drop-in, which is found where it is alone.
  const std::string folder = ::testing::TempDir() + "lidard-named-" + std::to_string(getpid());
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "/urg_node.control");
  with(nullptr, folder.c_str(), nullptr);
  EXPECT_EQ(running_socket_path(), folder + "/urg_node.control");
  std::ofstream(folder + "/control");
  EXPECT_EQ(running_socket_path(), folder + "/control");
  std::filesystem::remove_all(folder);
  with(nullptr, nullptr, nullptr);
}

}  // namespace
}  // namespace lidard
