// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/master/node_name.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <random>
#include <utility>

#include "daemon/live/runtime_socket.h"
#include "daemon/log/log.h"

namespace lidard {
namespace {

/// A daemon that is stopping ends within this time.
constexpr auto patience = std::chrono::seconds(3);
constexpr auto stop_window = std::chrono::seconds(10);
constexpr std::size_t many_stops = 3;
constexpr Span longest_pause = std::chrono::seconds(1);

/// The file of the lock, in a folder where nobody else may write.
std::string lock_file(const std::string& node, const std::string& master_uri) {
  constexpr std::size_t longest_name = 250;  // NAME_MAX is 255
  std::string name = "node" + node + "@" + master_uri;
  for (std::size_t at = 0; (at = name.find('/', at)) != std::string::npos;) name.replace(at, 1, "%2F");
  return runtime_folder() + "/" + name.substr(0, longest_name) + ".lock";
}

/// Opens the file and locks it; -1 with errno: EWOULDBLOCK if another process has the lock. A process that
/// may open a file can hold its lock: a link, and a file that others made or may open, decide nothing
/// (EPERM).
int lock_of(const std::string& file) {
  std::error_code ignored;
  std::filesystem::create_directories(std::filesystem::path(file).parent_path(), ignored);
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600);
  struct stat is {};
  if (fd < 0 || fstat(fd, &is) != 0) return -1;
  constexpr mode_t others = S_IRWXG | S_IRWXO;
  const bool is_ours = S_ISREG(is.st_mode) && is.st_uid == geteuid() && (is.st_mode & others) == 0;
  if (is_ours && flock(fd, LOCK_EX | LOCK_NB) == 0) return fd;
  const int error = is_ours ? errno : EPERM;
  close(fd);
  errno = error;
  return -1;
}

}  // namespace

NodeName::NodeName(std::string node, std::string master_uri)
    : node_(std::move(node)), master_uri_(std::move(master_uri)) {}

NodeName::~NodeName() {
  if (lock_ >= 0) close(lock_);
}

bool NodeName::lock() {
  if (lock_ >= 0 || lockless_) return true;
  const std::string file = lock_file(node_, master_uri_);
  lock_ = lock_of(file);
  const int error = lock_ < 0 ? errno : 0;
  if (error == EWOULDBLOCK) return refuse("another daemon on this computer");
  lacks_files_ = error == EMFILE || error == ENFILE;
  if (lacks_files_) return false;
  if (error != 0)
    log_warn("{}: {}; without this file the ROS master alone shows another daemon of the name {}", file,
             std::strerror(error), node_);
  lockless_ = error != 0;
  refused_since_.reset();
  return true;
}

bool NodeName::is_free(MasterClient& master) {
  if (ours_) return true;
  const std::string other = other_node(master);
  if (!other.empty()) return refuse(other);
  refused_since_.reset();
  return true;
}

Span NodeName::after_foreign_stop(MasterClient& master) {
  const auto now = Clock::now();
  foreign_stops_.push_back(now);
  while (now - foreign_stops_.front() > stop_window) foreign_stops_.pop_front();
  if (foreign_stops_.size() < many_stops) return Span(0);
  if (const std::string other = other_node(master); !other.empty()) give_up(other);
  std::random_device chance;
  return Span(std::uniform_int_distribution<Span::rep>(0, longest_pause.count())(chance));
}

std::string NodeName::conflict() const {
  const std::lock_guard lock(mutex_);
  return conflict_;
}

/// A node that answers at the registered address of the name (Slave API, getPid); empty: none.
std::string NodeName::other_node(MasterClient& master) const {
  const auto uri = master.node_uri(node_);
  const auto server = uri ? parse_server_uri(*uri) : std::nullopt;
  if (!server) return {};
  XmlRpc::XmlRpcValue arguments;
  arguments[0] = node_;
  std::string error;
  const bool answers =
      xmlrpc_call(*server, "getPid", arguments, std::chrono::milliseconds(500), error).has_value();
  return answers ? "another node at " + *uri : "";
}

/// Returns false.
bool NodeName::refuse(const std::string& by) {
  if (!refused_since_) {
    log_warn("{} has the node name {}; waiting for its end", by, node_);
    refused_since_ = Clock::now();
  }
  if (Clock::now() - *refused_since_ >= patience) give_up(by);
  return false;
}

void NodeName::give_up(const std::string& by) {
  const std::lock_guard lock(mutex_);
  conflict_ = by + " has the node name " + node_ +
              "; two nodes of one name shut each other down. Stop the other one, or give this one another "
              "name: __name:=" +
              node_.substr(node_.rfind('/') + 1) + "_2";
}

}  // namespace lidard
