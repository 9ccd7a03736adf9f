// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/net/tcp_source.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <vector>

#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

constexpr int keep_alive_after_s = 1;
constexpr int keep_alive_every_s = 1;
/// A peer that left a keep-alive unanswered for this time is gone. The kernel counts whole seconds and needs
/// two.
constexpr std::uint32_t gone_after_ms = 1700;
constexpr auto peer_check = std::chrono::milliseconds(100);

template <class T>
void set(int fd, int level, int option, T value) {
  // The options are refinements: the connection works without them.
  static_cast<void>(::setsockopt(fd, level, option, &value, sizeof value));
}

/// Sets the options of a new socket: no Nagle delay, arrival stamps and keep-alives.
void prepare_tcp_socket(int fd) {
  set(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  set(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(fd, IPPROTO_TCP, TCP_KEEPIDLE, keep_alive_after_s);
  set(fd, IPPROTO_TCP, TCP_KEEPINTVL, keep_alive_every_s);
  set(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, gone_after_ms);
  set(fd, SOL_SOCKET, SO_TIMESTAMPNS, 1);
}

/// True if neither bytes nor acknowledgements came for long while a keep-alive or sent bytes are
/// unacknowledged.
bool peer_is_gone(int fd) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (::getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return false;
  const bool asked = info.tcpi_probes > 0 || info.tcpi_retransmits > 0;
  return asked && std::min(info.tcpi_last_data_recv, info.tcpi_last_ack_recv) >= gone_after_ms;
}

/// Reads without waiting, as recv(2); `stamp` is the arrival of the last byte.
ssize_t receive_bytes(int fd, std::uint8_t* to, std::size_t room, HostStamp& stamp) {
  struct alignas(cmsghdr) Control {
    std::array<char, CMSG_SPACE(sizeof(timespec))> bytes;
  } control{};
  iovec vector{to, room};
  msghdr header{};
  header.msg_iov = &vector;
  header.msg_iovlen = 1;
  header.msg_control = control.bytes.data();
  header.msg_controllen = control.bytes.size();
  const ssize_t got = ::recvmsg(fd, &header, MSG_DONTWAIT);
  if (got <= 0) return got;
  for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec time{};
    std::memcpy(&time, CMSG_DATA(c), sizeof time);
    stamp = HostStamp{time.tv_sec * 1'000'000'000 + time.tv_nsec};
    if (stamp.ns != 0) return got;
  }
  stamp = wall_clock();
  return got;
}

using boost::asio::ip::tcp;
using Clock = std::chrono::steady_clock;

constexpr std::size_t read_buffer = 64 * 1024UL;
/// Limits the time until other sockets of the thread are read.
constexpr int reads_per_wakeup = 8;
/// After a connection that lasted this long, the delay of retries starts again.
constexpr auto steady_after = std::chrono::seconds(2);

tcp::endpoint to_asio(const Endpoint& endpoint) {
  return {boost::asio::ip::make_address(endpoint.address.to_string()), endpoint.port};
}

Endpoint from_asio(const tcp::endpoint& endpoint) {
  return {IpAddress::parse(endpoint.address().to_string()).value_or(IpAddress()), endpoint.port()};
}

}  // namespace

class TcpSource::Impl : public std::enable_shared_from_this<Impl> {
 public:
  Impl(boost::asio::io_context& io, TcpOptions options, TcpHandlers handlers)
      : options_(options),
        handlers_(std::move(handlers)),
        socket_(io),
        timer_(io),
        retry_(options.first_retry),
        buffer_(read_buffer) {}

  void start() {
    if (state_.phase != TcpState::Phase::stopped) return;
    retry_ = options_.first_retry;
    connect();
  }

  void stop() {
    close();
    state_ = {};
  }

  void disconnect(bool again) {
    if (state_.phase != TcpState::Phase::connected) {
      if (!again) stop();
      return;
    }
    if (again) return abandon({TcpFault::Kind::dialogue_failed});
    stop();
    handlers_.disconnected();
  }

  bool send(ByteView bytes) {
    if (state_.phase != TcpState::Phase::connected || unsent_.size() + bytes.size() > options_.send_limit) {
      ++stats_.requests_dropped;
      return false;
    }
    unsent_.insert(unsent_.end(), bytes.begin(), bytes.end());
    if (!waits_to_write_) flush();
    return true;
  }

  void interfaces_changed() {
    if (state_.phase == TcpState::Phase::waiting) connect();
  }

  const TcpState& state() const { return state_; }
  const TcpStats& stats() const { return stats_; }

 private:
  void connect() {
    close();
    state_.phase = TcpState::Phase::connecting;  // the fault stays that of the last failure
    ++stats_.attempts;
    attempt_began_ = Clock::now();
    const tcp::endpoint device = to_asio(options_.device);
    boost::system::error_code error;
    socket_.open(device.protocol(), error);
    if (error) return fail({TcpFault::Kind::not_connected, error.value()});
    prepare_tcp_socket(socket_.native_handle());
    if (abandoned_port_ != 0) {
      socket_.set_option(tcp::socket::reuse_address(true), error);
      socket_.bind({device.protocol(), abandoned_port_}, error);
    }
    socket_.async_connect(device, [self = shared_from_this(),
                                   generation = generation_](const boost::system::error_code& failed) {
      if (generation != self->generation_) return;
      if (failed.value() == EADDRNOTAVAIL) self->abandoned_port_ = 0;
      const int why = failed ? failed.value() : self->why_no_peer();
      if (why != 0) return self->fail({TcpFault::Kind::not_connected, why});
      self->connected();
    });
    at(attempt_began_ + options_.connect_time_out, [](Impl& self) {
      self.fail({TcpFault::Kind::not_connected, ETIMEDOUT});
    });
  }

  /// 0 if the socket has a peer, else why it has none. On a loaded host async_connect has reported success
  /// while the kernel was still noting that the device did not answer (SYN_SENT, then EHOSTUNREACH); such a
  /// socket reads as one that the device closed.
  int why_no_peer() {
    boost::system::error_code none;
    socket_.remote_endpoint(none);
    if (!none) return 0;
    int error = 0;
    socklen_t size = sizeof error;
    static_cast<void>(::getsockopt(socket_.native_handle(), SOL_SOCKET, SO_ERROR, &error, &size));
    return error != 0 ? error : ETIMEDOUT;
  }

  void connected() {
    boost::system::error_code error;
    socket_.non_blocking(true, error);
    local_ = from_asio(socket_.local_endpoint(error));
    abandoned_port_ = 0;
    ++stats_.connects;
    state_ = {TcpState::Phase::connected};
    connected_since_ = last_byte_ = Clock::now();
    fresh_ = true;
    timer_.cancel(error);
    const std::uint64_t generation = generation_;
    handlers_.connected(wall_clock());
    if (generation != generation_) return;  // the handler ended the connection
    watch_silence();
    wait_to_read();
  }

  void close() {
    ++generation_;
    boost::system::error_code ignored;
    timer_.cancel(ignored);
    socket_.close(ignored);
    if (state_.phase == TcpState::Phase::connected) ++stats_.disconnects;
    unsent_.clear();
    waits_to_write_ = false;
  }

  /// Ends the connection or attempt; with keep_up schedules the next one.
  void fail(const TcpFault& fault) {
    const bool was_connected = state_.phase == TcpState::Phase::connected;
    close();
    state_ = {options_.keep_up ? TcpState::Phase::waiting : TcpState::Phase::stopped, fault};
    if (options_.keep_up) plan_retry();
    if (was_connected || !options_.keep_up) handlers_.disconnected();
  }

  /// Ends a connection that the device may keep for minutes while it refuses others. The next connection
  /// comes from the same port, which ends the old one (RFC 9293 3.5.1, half-open connections).
  void abandon(const TcpFault& fault) {
    boost::system::error_code ignored;
    socket_.set_option(tcp::socket::linger(true, 0), ignored);
    abandoned_port_ = local_.port;
    fail(fault);
  }

  void plan_retry() {
    const auto now = Clock::now();
    if (!fresh_ && now - connected_since_ > steady_after) retry_ = options_.first_retry;
    fresh_ = true;
    const auto pause = std::max(attempt_began_ + retry_, now + options_.first_retry);
    retry_ = std::min(2 * retry_, options_.last_retry);
    at(pause, [](Impl& self) { self.connect(); });
  }

  template <class Action>
  void at(Clock::time_point time, Action action) {
    timer_.expires_at(time);
    timer_.async_wait([self = shared_from_this(), generation = generation_, action](const auto& error) {
      if (!error && generation == self->generation_) action(*self);
    });
  }

  void wait_to_read() {
    socket_.async_wait(tcp::socket::wait_read,
                       [self = shared_from_this(), generation = generation_](const auto& error) {
                         if (generation != self->generation_) return;
                         if (error) return self->fail({TcpFault::Kind::ended, error.value()});
                         if (self->read(reads_per_wakeup)) self->wait_to_read();
                       });
  }

  void wait_to_write() {
    waits_to_write_ = true;
    socket_.async_wait(tcp::socket::wait_write,
                       [self = shared_from_this(), generation = generation_](const auto& error) {
                         if (error || generation != self->generation_) return;
                         self->waits_to_write_ = false;
                         self->flush();
                       });
  }

  /// Reads up to `rounds` times; false if the connection ended.
  bool read(int rounds) {
    const std::uint64_t generation = generation_;
    for (int round = 0; round < rounds; ++round) {
      Packet packet;
      const ssize_t got =
          receive_bytes(socket_.native_handle(), buffer_.data(), buffer_.size(), packet.received);
      if (got < 0 && (errno == EAGAIN || errno == EINTR)) return true;
      if (got <= 0) {
        TcpFault fault{TcpFault::Kind::ended, got == 0 ? 0 : errno};
        // Without keep_up it is no error that the device closes the connection.
        if (got == 0 && !options_.keep_up) fault = {};
        fault.error == ETIMEDOUT ? abandon(fault) : fail(fault);
        return false;
      }
      last_byte_ = Clock::now();
      stats_.received += static_cast<std::uint64_t>(got);
      packet.payload = ByteView(buffer_.data(), static_cast<std::size_t>(got));
      packet.from = options_.device;
      packet.to = local_;
      packet.transport = Transport::tcp;
      packet.stream_start = std::exchange(fresh_, false);
      handlers_.receive(packet);
      if (generation != generation_) return false;
      if (static_cast<std::size_t>(got) < buffer_.size()) return true;
    }
    return true;
  }

  /// Sends queued bytes. Errors are reported by the next read.
  void flush() {
    while (!unsent_.empty()) {
      const ssize_t written =
          ::send(socket_.native_handle(), unsent_.data(), unsent_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0 && errno == EAGAIN) return wait_to_write();
      if (written < 0) return unsent_.clear();
      stats_.sent += static_cast<std::uint64_t>(written);
      unsent_.erase(unsent_.begin(), unsent_.begin() + written);
    }
  }

  void watch_silence() {
    const auto next = Clock::now() + peer_check;
    const bool limited = options_.read_time_out > Span(0);
    at(limited ? std::min(next, last_byte_ + options_.read_time_out) : next,
       [](Impl& self) { self.check_silence(); });
  }

  void check_silence() {
    // This process may have been delayed: the bytes may be in the buffer.
    if (!read(1)) return;
    if (peer_is_gone(socket_.native_handle())) return abandon({TcpFault::Kind::ended, ETIMEDOUT});
    const auto quiet = Clock::now() - last_byte_;
    if (options_.read_time_out <= Span(0) || quiet < options_.read_time_out) return watch_silence();
    ++stats_.silences;
    abandon({TcpFault::Kind::silent, 0, options_.read_time_out});
  }

  TcpOptions options_;
  TcpHandlers handlers_;
  tcp::socket socket_;
  boost::asio::steady_timer timer_;
  TcpState state_;
  TcpStats stats_;
  Span retry_;
  Clock::time_point attempt_began_{};
  Clock::time_point connected_since_{};
  Clock::time_point last_byte_{};
  Endpoint local_;
  std::uint16_t abandoned_port_ = 0;  // local port of a connection that the device may still keep
  bool fresh_ = true;                 // nothing was received on this connection yet
  bool waits_to_write_ = false;
  std::vector<std::uint8_t> buffer_;
  std::vector<std::uint8_t> unsent_;
  // Identifies the socket, so that queued handlers of a closed socket return.
  std::uint64_t generation_ = 0;
};

TcpSource::TcpSource(boost::asio::io_context& io, TcpOptions options, TcpHandlers handlers)
    : impl_(std::make_shared<Impl>(io, options, std::move(handlers))) {}
TcpSource::~TcpSource() { impl_->stop(); }
void TcpSource::start() { impl_->start(); }
void TcpSource::stop() { impl_->stop(); }
bool TcpSource::send(ByteView bytes) { return impl_->send(bytes); }
void TcpSource::disconnect(bool again) { impl_->disconnect(again); }
void TcpSource::interfaces_changed() { impl_->interfaces_changed(); }
const TcpState& TcpSource::state() const { return impl_->state(); }
const TcpStats& TcpSource::stats() const { return impl_->stats(); }

}  // namespace lidard
