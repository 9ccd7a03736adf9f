// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/runtime_socket.h"

#include <sys/un.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <cstdlib>
#include <filesystem>
#include <istream>
#include <memory>
#include <stdexcept>
#include <vector>

namespace lidard {
namespace {

namespace asio = boost::asio;
using Local = asio::local::stream_protocol;

constexpr const char* service_folder = "/run/lidard";
constexpr std::size_t longest_question = 64;
/// Time limit of a connection.
constexpr auto patience = std::chrono::seconds(2);

constexpr const char* too_long =
    ": the path of a socket has at most 107 bytes; set LIDARD_SOCKET to a shorter one";
bool is_too_long(const std::string& path) { return path.size() >= sizeof sockaddr_un().sun_path; }

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

std::string runtime_folder() {
  // Several folders are separated by colons (systemd.exec(5)).
  const std::string runtime = environment("RUNTIME_DIRECTORY");
  if (!runtime.empty()) return runtime.substr(0, runtime.find(':'));
  const std::string user = environment("XDG_RUNTIME_DIR");
  return user.empty() ? service_folder : user + "/lidard";
}

std::string runtime_socket_path() {
  const std::string path = environment("LIDARD_SOCKET");
  return path.empty() ? runtime_folder() + "/control" : path;
}

std::string running_socket_path() {
  std::string own = runtime_socket_path();
  if (!environment("LIDARD_SOCKET").empty() || access(own.c_str(), F_OK) == 0) return own;
  // A drop-in's socket has the name of its node; only one alone is found without it.
  std::vector<std::string> named;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(runtime_folder(), ignored)) {
    if (entry.path().extension() == ".control") named.push_back(entry.path());
  }
  if (named.size() == 1) return named.front();
  // A user's session has XDG_RUNTIME_DIR, the service has not.
  return std::string(service_folder) + "/control";
}

/// One request and its answer. The object keeps itself alive until the answer is sent or the time limit
/// passes.
class RuntimeSocket::Talk : public std::enable_shared_from_this<Talk> {
 public:
  Talk(Local::socket socket, const Answers& answers)
      : socket_(std::move(socket)), limit_(socket_.get_executor()), answers_(answers) {}

  void begin() {
    limit_patience();
    asio::async_read_until(socket_, question_, '\n',
                           [self = shared_from_this()](const boost::system::error_code& error, std::size_t) {
                             error ? self->end() : self->answer();
                           });
  }

 private:
  void limit_patience() {
    limit_.expires_after(patience);
    limit_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
      boost::system::error_code ignored;
      if (!error) self->socket_.close(ignored);
    });
  }
  void answer() {
    limit_.cancel();
    std::string word;
    std::istream in(&question_);
    std::getline(in, word);
    const auto found = answers_.find(word);
    if (found == answers_.end()) return reply("unknown request\n");
    try {
      found->second([self = shared_from_this()](std::string text) { self->reply(std::move(text)); });
    } catch (const std::exception& error) {
      reply(std::string("no answer: ") + error.what() + "\n");  // an exception must not end the daemon
    }
  }
  void reply(std::string text) {
    text_ = std::move(text);
    limit_patience();
    asio::async_write(
        socket_, asio::buffer(text_),
        [self = shared_from_this()](const boost::system::error_code&, std::size_t) { self->end(); });
  }
  void end() {
    boost::system::error_code ignored;
    limit_.cancel();
    socket_.close(ignored);
  }

  Local::socket socket_;
  asio::steady_timer limit_;
  const Answers& answers_;
  asio::streambuf question_{longest_question};
  std::string text_;
};

RuntimeSocket::RuntimeSocket(asio::io_context& io, Answers answers)
    : acceptor_(io), pause_(io), answers_(std::move(answers)) {}
// cancel() does not fail for a timer that one thread uses.
// NOLINTNEXTLINE(bugprone-exception-escape)
RuntimeSocket::~RuntimeSocket() { stop(); }

std::string RuntimeSocket::start(const std::string& path) {
  namespace fs = std::filesystem;
  if (is_too_long(path)) return path + too_long;
  std::error_code ignored;
  fs::create_directories(fs::path(path).parent_path(), ignored);
  boost::system::error_code error;
  Local::socket other(acceptor_.get_executor());
  other.connect(path, error);
  if (!error) return path + ": another daemon answers there; set LIDARD_SOCKET to a path of this one's own";
  if (fs::is_socket(path, ignored)) fs::remove(path, ignored);  // the socket of a killed daemon
  acceptor_.open(Local(), error);
  if (!error) acceptor_.bind(path, error);
  if (!error) acceptor_.listen(8, error);
  if (error) {
    boost::system::error_code closing;
    acceptor_.close(closing);
    return path + ": " + error.message() + "; set LIDARD_SOCKET to a path that can be written to";
  }
  path_ = path;
  accept();
  return {};
}

void RuntimeSocket::accept() {
  acceptor_.async_accept([this](const boost::system::error_code& error, Local::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) {
      std::make_shared<Talk>(std::move(socket), answers_)->begin();
      return accept();
    }
    // Too many open files, for instance: an immediate retry would occupy the processor.
    pause_.expires_after(std::chrono::milliseconds(100));
    pause_.async_wait([this](const boost::system::error_code& aborted) {
      if (!aborted) accept();
    });
  });
}

void RuntimeSocket::stop() {
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  pause_.cancel();
  std::error_code also_ignored;
  if (!path_.empty()) std::filesystem::remove(path_, also_ignored);
  path_.clear();
}

std::string ask_daemon(const std::string& path, const std::string& word, std::chrono::milliseconds limit) {
  if (is_too_long(path)) throw std::runtime_error(path + too_long);
  asio::io_context io;
  Local::socket socket(io);
  // Stays if the daemon hangs. The queue of one that hangs may be full: then connecting fails at once.
  boost::system::error_code error = asio::error::try_again;
  const std::string question = word + "\n";
  std::string answer;
  socket.async_connect(Local::endpoint(path), [&](const boost::system::error_code& refused) {
    if (refused) return void(error = refused);
    asio::async_write(
        socket, asio::buffer(question), [&](const boost::system::error_code& unsent, std::size_t) {
          if (unsent) return void(error = unsent);
          asio::async_read(socket, asio::dynamic_buffer(answer),
                           [&](const boost::system::error_code& ended, std::size_t) { error = ended; });
        });
  });
  io.run_for(limit);
  if (error == asio::error::eof) return answer;
  if (error == asio::error::try_again)
    throw std::runtime_error(path +
                             ": the daemon does not answer; `journalctl -u lidard` may say why it hangs");
  if (error == asio::error::access_denied)
    throw std::runtime_error(path + ": this user may not ask the daemon; ask with sudo");
  throw std::runtime_error(path + ": no daemon answers (" + error.message() +
                           "); start it, or name its socket with --socket");
}

}  // namespace lidard
