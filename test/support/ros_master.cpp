// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/ros_master.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <utility>

#include "daemon/ros/master/master_client.h"

namespace lidard::test {
namespace {

pid_t fork_child() {
  std::cout.flush();
  std::fflush(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid != 0) return pid;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  return 0;
}

[[noreturn]] void leave(int status) {
  std::cout.flush();
  std::fflush(nullptr);
  _exit(status);
}

}  // namespace

void in_own_process(const std::function<void()>& body) {
  const pid_t pid = fork_child();
  ASSERT_GE(pid, 0);
  if (pid == 0) {
    body();
    leave(testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(pid, &status, 0), pid);
  EXPECT_TRUE(WIFEXITED(status)) << "the process ended by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0) << "expectations failed in the process, see above";
}

std::uint16_t free_port() {
  const int socket_fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  bind(socket_fd, reinterpret_cast<sockaddr*>(&address), sizeof address);
  socklen_t size = sizeof address;
  getsockname(socket_fd, reinterpret_cast<sockaddr*>(&address), &size);
  close(socket_fd);
  return ntohs(address.sin_port);
}

Child::Child(const std::vector<std::string>& command) : pid_(fork_child()) {
  if (pid_ != 0) return;
  std::vector<char*> arguments;
  for (const auto& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  _exit(127);
}

Child::Child(const std::function<void()>& body) : pid_(fork_child()) {
  if (pid_ != 0) return;
  body();
  leave(0);
}

Child& Child::operator=(Child&& other) noexcept {
  std::swap(pid_, other.pid_);
  return *this;
}

void Child::pause() { ::kill(pid_, SIGSTOP); }
void Child::resume() { ::kill(pid_, SIGCONT); }

void Child::kill() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = 0;
}

RosMaster::RosMaster() : port_(free_port()) {
  char folder[] = "/tmp/lidard-ros-XXXXXX";
  logs_ = mkdtemp(folder);
  setenv("ROS_MASTER_URI", uri().c_str(), 1);
  setenv("ROS_IP", "127.0.0.1", 1);
  unsetenv("ROS_HOSTNAME");
  unsetenv("ROS_NAMESPACE");
  setenv("ROS_LOG_DIR", logs_.c_str(), 1);
}

RosMaster::~RosMaster() {
  kill();
  std::error_code ignored;
  std::filesystem::remove_all(logs_, ignored);
}

void RosMaster::start() {
  process_ = Child(std::vector<std::string>{"/usr/bin/python3", "-c",
                                            "import sys, os\n"
                                            "os.dup2(os.open(os.devnull, os.O_WRONLY), 1)\n"
                                            "import rosmaster\nrosmaster.rosmaster_main()",
                                            "--core", "-p", std::to_string(port_)});
  MasterClient client({"127.0.0.1", port_}, "/test");
  for (int i = 0; i < 400; ++i) {
    if (client.pid()) return;
    usleep(50'000);
  }
  ADD_FAILURE() << "rosmaster does not answer on port " << port_ << ": " << client.error();
}

std::string output_of(const std::string& command, int seconds) {
  FILE* pipe = popen(("timeout -k 1 " + std::to_string(seconds) + " " + command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return {};
  std::string text;
  char buffer[4096];
  for (std::size_t n = 0; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, n);
  pclose(pipe);
  return text;
}

}  // namespace lidard::test
