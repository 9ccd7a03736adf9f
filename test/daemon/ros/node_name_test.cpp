// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/master/node_name.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <optional>
#include <thread>

namespace lidard {
namespace {

using namespace std::chrono_literals;

TEST(NodeName, IsOfOneDaemonOfAComputerAndFreeAtOnceWhenThatEnds) {
  const std::string node = "/name_test_" + std::to_string(getpid());
  const std::string master = "http://localhost:11311";
  std::optional<NodeName> first(std::in_place, node, master);
  NodeName second(node, master);
  EXPECT_TRUE(first->lock());
  EXPECT_TRUE(first->lock());
  EXPECT_FALSE(second.lock());
  EXPECT_EQ(second.conflict(), "") << "the first may just be ending";
  EXPECT_TRUE(NodeName(node + "_2", master).lock());
  EXPECT_TRUE(NodeName(node, "http://localhost:11312").lock()) << "they do not meet";
  first.reset();
  EXPECT_TRUE(second.lock());
  EXPECT_EQ(second.conflict(), "");
}

TEST(NodeName, ThatIsTakenForThreeSecondsIsAConflictThatNamesTheRemedy) {
  const std::string node = "/space/conflict_test_" + std::to_string(getpid());
  NodeName first(node, "http://localhost:11311");
  NodeName second(node, "http://localhost:11311");
  EXPECT_TRUE(first.lock());
  EXPECT_FALSE(second.lock());
  std::this_thread::sleep_for(3100ms);
  EXPECT_FALSE(second.lock());
  EXPECT_THAT(second.conflict(),
              testing::HasSubstr("another daemon on this computer has the node name " + node));
  EXPECT_THAT(second.conflict(),
              testing::HasSubstr("__name:=conflict_test_" + std::to_string(getpid()) + "_2"));
}

/// A runtime folder of this test.
struct RuntimeFolder {
  RuntimeFolder()
      : path(std::filesystem::temp_directory_path() / ("lidard-run-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path);
    setenv("RUNTIME_DIRECTORY", path.c_str(), 1);
  }
  ~RuntimeFolder() {
    unsetenv("RUNTIME_DIRECTORY");
    std::filesystem::remove_all(path);
  }
  std::filesystem::path only_file() const { return std::filesystem::directory_iterator(path)->path(); }
  std::filesystem::path path;
};

/// Runs `act` as another user; its result.
template <class Act>
bool as_nobody(Act act) {
  const pid_t child = fork();
  if (child == 0) _exit(setgid(65534) == 0 && setuid(65534) == 0 && act() ? 0 : 1);
  int status = 1;
  waitpid(child, &status, 0);
  return status == 0;
}

TEST(NodeName, CannotBeTakenByAUserWithoutRights) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to be another user";
  const RuntimeFolder folder;
  NodeName("/robot", "http://localhost:11311").lock();
  const std::string file = folder.only_file();
  EXPECT_THAT(file, testing::EndsWith("/node%2Frobot@http:%2F%2Flocalhost:11311.lock"));
  EXPECT_FALSE(as_nobody([&] { return open(file.c_str(), O_RDONLY) >= 0; }));
  EXPECT_FALSE(as_nobody([&] { return open((folder.path / "more").c_str(), O_RDWR | O_CREAT, 0600) >= 0; }));
  EXPECT_TRUE(NodeName("/robot", "http://localhost:11311").lock()) << "the file is left, not its lock";
}

TEST(NodeName, AFileOrLinkOfOthersDecidesNothing) {
  const RuntimeFolder folder;
  NodeName("/robot", "http://localhost:11311").lock();
  const std::filesystem::path file = folder.only_file();
  // Whoever may open the file can hold its lock.
  std::filesystem::permissions(file, std::filesystem::perms(0666));
  const int held = open(file.c_str(), O_RDONLY);
  ASSERT_EQ(flock(held, LOCK_EX | LOCK_NB), 0);
  EXPECT_TRUE(NodeName("/robot", "http://localhost:11311").lock());
  close(held);
  std::filesystem::remove(file);
  std::filesystem::create_symlink(folder.path / "target", file);
  EXPECT_TRUE(NodeName("/robot", "http://localhost:11311").lock());
  EXPECT_FALSE(std::filesystem::exists(folder.path / "target")) << "no link is followed";
  std::filesystem::remove(file);
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  EXPECT_TRUE(NodeName("/robot", "http://localhost:11311").lock());
  setenv("RUNTIME_DIRECTORY", "/proc/none", 1);
  EXPECT_TRUE(NodeName("/robot", "http://localhost:11311").lock()) << "without a folder the master decides";
}

TEST(NodeName, TooManyOpenFilesAreNoOtherDaemon) {
  const RuntimeFolder folder;
  NodeName name("/robot", "http://localhost:11311");
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &none);
  EXPECT_FALSE(name.lock());
  EXPECT_TRUE(name.lacks_files());
  std::this_thread::sleep_for(3100ms);
  EXPECT_FALSE(name.lock());
  setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(name.conflict(), "");
  EXPECT_TRUE(name.lock());
  EXPECT_FALSE(name.lacks_files());
}

}  // namespace
}  // namespace lidard
