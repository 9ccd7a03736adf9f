// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "test/support/ros_master.h"

namespace lidard {
namespace {

using namespace std::chrono_literals;
using test::in_own_process;

/// The service manager's end of $NOTIFY_SOCKET.
class NotifySocket {
 public:
  NotifySocket() : fd_(socket(AF_UNIX, SOCK_DGRAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = "lidard-test-" + std::to_string(getpid());
    name.copy(address.sun_path + 1, name.size());  // a leading zero byte: an abstract address, no file
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    if (bind(fd_, reinterpret_cast<sockaddr*>(&address), size) != 0) std::abort();
    setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
  }
  ~NotifySocket() { close(fd_); }
  std::string next() const {
    char buffer[512];
    const auto n = recv(fd_, buffer, sizeof buffer, MSG_DONTWAIT);
    return n > 0 ? std::string(buffer, static_cast<std::size_t>(n)) : std::string();
  }

 private:
  int fd_;
};

TEST(ServiceHistory, SaysWhenTheWatchdogKilledTheDaemonLast) {
  in_own_process([] {
    unsetenv("STATE_DIRECTORY");
    EXPECT_EQ(service_history(), "") << "no service";
    const auto folder =
        std::filesystem::temp_directory_path() / ("lidard-history-" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    setenv("STATE_DIRECTORY", folder.c_str(), 1);
    setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nowhere", 1);
    EXPECT_EQ(service_history(), "");
    std::ofstream(folder / "watchdog") << "2026-11-23T14:03:22Z\n";
    EXPECT_EQ(service_history(), "last killed by its watchdog at 2026-11-23T14:03:22Z");
    std::filesystem::remove_all(folder);
  });
}

TEST(ServiceManager, HearsWhenTheDaemonIsReadyAliveAndStopping) {
  in_own_process([] {
    const NotifySocket socket;
    ServiceManager manager;
    manager.ready("2 of 3 sensors");
    EXPECT_EQ(socket.next(), "READY=1\nSTATUS=2 of 3 sensors");
    manager.status("3 of 3 sensors");
    EXPECT_EQ(socket.next(), "STATUS=3 of 3 sensors");
    manager.alive();
    EXPECT_EQ(socket.next(), "WATCHDOG=1");
    manager.stopping();
    EXPECT_EQ(socket.next(), "STOPPING=1");
  });
}

TEST(ServiceManager, IsNotWaitedForWhereItDoesNotRead) {
  in_own_process([] {
    const NotifySocket socket;
    ServiceManager manager;
    for (int i = 0; i < 5000; ++i) {
      manager.alive();
      manager.status("3 of 3 sensors");
    }
    EXPECT_EQ(socket.next(), "WATCHDOG=1");
  });
}

TEST(ServiceManager, HearsOfTheDaemonOnceThereIsADescriptor) {
  in_own_process([] {
    const NotifySocket socket;
    rlimit limit{};
    getrlimit(RLIMIT_NOFILE, &limit);
    const rlimit none{0, limit.rlim_max};
    setrlimit(RLIMIT_NOFILE, &none);
    ServiceManager manager;
    manager.alive();
    EXPECT_EQ(socket.next(), "");
    setrlimit(RLIMIT_NOFILE, &limit);
    manager.alive();
    EXPECT_EQ(socket.next(), "WATCHDOG=1");
  });
}

TEST(ServiceManager, DoesNotMindBeingAbsent) {
  in_own_process([] {
    unsetenv("NOTIFY_SOCKET");
    ServiceManager manager;
    manager.ready("");
    manager.alive();
  });
}

/// What the log writes to stderr; `as_journal` announces stderr as the journal's stream.
std::string logged(bool as_journal) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const test::Child child([&] {
    dup2(ends[1], STDERR_FILENO);
    struct stat is {};
    fstat(STDERR_FILENO, &is);
    const auto stream = std::to_string(is.st_dev) + ":" + std::to_string(is.st_ino);
    setenv("JOURNAL_STREAM", as_journal ? stream.c_str() : "1:1", 1);
    set_up_logging("info");
    spdlog::debug("hidden");
    spdlog::info("hello");
    spdlog::warn("careful");
    spdlog::error("broken");
  });
  close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  return text;
}

TEST(Log, HasLevelPrefixesForTheJournal) { EXPECT_EQ(logged(true), "<6>hello\n<4>careful\n<3>broken\n"); }

TEST(Log, HasTimeAndLevelElsewhereAndNoColoursInAPipe) {
  EXPECT_THAT(logged(false),
              testing::MatchesRegex("..:..:..\\.... info: hello\n..:..:..\\.... warning: careful\n"
                                    "..:..:..\\.... error: broken\n"));
}

}  // namespace
}  // namespace lidard
