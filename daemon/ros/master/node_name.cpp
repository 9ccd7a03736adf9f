// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/master/node_name.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <random>
#include <utility>

#include "daemon/pipeline/log.h"

namespace lidard {
namespace {

/// A daemon that is stopping ends within this time.
constexpr auto patience = std::chrono::seconds(3);
constexpr auto stop_window = std::chrono::seconds(10);
constexpr std::size_t many_stops = 3;
constexpr Span longest_pause = std::chrono::seconds(1);

/// Binds a socket to an address of the kernel's own namespace (unix(7), abstract), which no second socket of
/// this computer gets, and which the kernel frees when the process ends. -1: another process has it.
int bind_lock(const std::string& node, const std::string& master_uri) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::size_t length =
      ("lidard" + node + "@" + master_uri).copy(address.sun_path + 1, sizeof address.sun_path - 1);
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + length);
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0) return fd;
  close(fd);
  return -1;
}

}  // namespace

NodeName::NodeName(std::string node, std::string master_uri)
    : node_(std::move(node)), master_uri_(std::move(master_uri)) {}

NodeName::~NodeName() {
  if (lock_ >= 0) close(lock_);
}

bool NodeName::lock() {
  if (lock_ >= 0) return true;
  lock_ = bind_lock(node_, master_uri_);
  if (lock_ < 0) return refuse("another daemon on this computer");
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
