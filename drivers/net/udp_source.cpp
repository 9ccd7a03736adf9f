// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/net/udp_source.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>

#include "drivers/net/host_network.h"
#include "drivers/net/udp_socket.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

constexpr auto first_retry = std::chrono::milliseconds(100);
constexpr auto last_retry = std::chrono::milliseconds(1000);
/// A membership is lost without an error when its interface is removed and comes back (USB adapters, VLANs).
/// This check is needed where InterfaceWatch does not work.
constexpr auto membership_check = std::chrono::seconds(1);
/// Limits the time until other sockets of the thread are read.
constexpr int batches_per_wakeup = 8;
/// Datagrams/s above which a port is busy, and below which it is quiet again.
constexpr double busy_from = 2000, quiet_below = 1500;
constexpr auto rate_window = std::chrono::milliseconds(100);
constexpr auto busy_period = std::chrono::milliseconds(1);

}  // namespace

class UdpSource::Impl : public std::enable_shared_from_this<Impl> {
 public:
  Impl(boost::asio::io_context& io, UdpOptions options, Handler handler)
      : options_(std::move(options)),
        handler_(std::move(handler)),
        descriptor_(io),
        timer_(io),
        busy_timer_(io),
        batch_(options_.max_datagram) {}

  void start() {
    if (state_.phase != UdpState::Phase::stopped) return;
    retry_ = first_retry;
    open();
  }

  void stop() {
    close();
    boost::system::error_code ignored;
    timer_.cancel(ignored);
    state_ = {};
  }

  void configure(UdpOptions options) {
    const UdpOptions before = std::exchange(options_, std::move(options));
    if (port_ == 0) return;  // applied by the next attempt to open
    const int fd = socket_.get();
    note(limit_socket(fd, options_));
    for (const MulticastGroup& group : before.groups) {
      const auto& now = options_.groups;
      if (std::find(now.begin(), now.end(), group) == now.end()) leave_group(fd, group);
    }
    boost::system::error_code ignored;
    timer_.cancel(ignored);
    join_groups();
  }

  void catch_up() {
    for (int n = 0; busy_ && n < batches_per_wakeup && read_batch();) ++n;
  }

  void interfaces_changed() {
    if (state_.phase == UdpState::Phase::waiting) {
      close();
      open();
    } else if (state_.phase != UdpState::Phase::stopped && !options_.groups.empty()) {
      join_groups();
    }
  }

  const UdpState& state() const { return state_; }
  const UdpStats& stats() const { return stats_; }
  std::uint16_t local_port() const { return port_; }

 private:
  void open() {
    UdpSocket socket = open_udp_socket(options_);
    if (socket.fault) {
      // Not at each attempt: the search reads files of every process.
      if (attempts_++ % 16 == 0) holder_ = holder_of_udp_port(options_.port);
      socket.fault.holder = holder_;
      return fail(std::move(socket.fault));
    }
    attempts_ = 0;
    socket_ = std::move(socket.fd);
    port_ = socket.port;
    drops_ = 0;
    filling_seen_.reset();
    note(socket.limits);
    retry_ = first_retry;
    join_groups(true);
    wait();
  }

  void note(const UdpLimits& limits) {
    filtered_ = limits.filtered;
    stats_.receive_buffer_asked = limits.buffer_asked;
    stats_.receive_buffer_got = limits.buffer_got;
    stats_.receive_buffer_lasts = limits.buffer_lasts;
  }

  void close() {
    ++generation_;
    boost::system::error_code ignored;
    busy_timer_.cancel(ignored);
    if (descriptor_.is_open()) descriptor_.release();
    socket_ = FileDescriptor();
    busy_ = false;
    port_ = 0;
  }

  void join_groups(bool new_socket = false) {
    state_ = {UdpState::Phase::receiving};
    for (const MulticastGroup& group : options_.groups) {
      const int error = join_group(socket_.get(), group);
      if (error == 0) continue;
      UdpFault fault{error, group};
      // Only a new socket is free of the memberships of removed interfaces.
      if (error == ENOBUFS && !new_socket) return fail(std::move(fault));
      state_ = {UdpState::Phase::partial, std::move(fault)};
    }
    if (options_.groups.empty()) return;
    const bool joined = state_.phase == UdpState::Phase::receiving;
    if (joined) retry_ = first_retry;
    after(joined ? membership_check : next_retry(), [](Impl& self) { self.join_groups(); });
  }

  void fail(UdpFault fault) {
    close();
    state_ = {UdpState::Phase::waiting, std::move(fault)};
    after(next_retry(), [](Impl& self) { self.open(); });
  }

  template <class Duration, class Action>
  void after(Duration delay, Action action) {
    timer_.expires_after(delay);
    timer_.async_wait([self = shared_from_this(), generation = generation_, action](const auto& error) {
      if (!error && generation == self->generation_) action(*self);
    });
  }

  /// Waits for the next datagram in the reactor, or for the timer of a busy port.
  void wait() {
    if (busy_) return wait_for(busy_period);
    boost::system::error_code error;
    if (!descriptor_.is_open()) descriptor_.assign(socket_.get(), error);
    if (error) return fail({error.value()});
    descriptor_.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                           [self = shared_from_this(), generation = generation_](const auto& failure) {
                             if (generation != self->generation_) return;
                             failure ? self->fail({failure.value()}) : self->readable();
                           });
  }

  void wait_for(Span delay) {
    busy_timer_.expires_after(delay);
    busy_timer_.async_wait([self = shared_from_this(), generation = generation_](const auto& error) {
      if (!error && generation == self->generation_) self->readable();
    });
  }

  void readable() {
    ++stats_.wakeups;
    const std::uint64_t generation = generation_;
    int batches = 0;
    while (batches < batches_per_wakeup && read_batch()) ++batches;
    if (generation != generation_) return;  // the handler stopped the source, or it failed
    note_rate();
    busy_&& batches == batches_per_wakeup ? wait_for(Span(0)) : wait();
  }

  /// Reads one batch; true if there may be more.
  bool read_batch() {
    const int fd = socket_.get();
    const std::uint64_t generation = generation_;
    if (filtered_ && receive_buffer_is_filling(fd)) filling_seen_ = wall_clock();
    const int count = batch_.receive(fd);
    if (count < 0 && errno != EAGAIN && errno != EINTR) fail({errno});
    packets_.clear();
    for (int i = 0; i < count; ++i) add(batch_[static_cast<std::size_t>(i)]);
    if (!packets_.empty()) handler_(packets_);
    return generation == generation_ && count == static_cast<int>(DatagramBatch::capacity);
  }

  /// Decides from the rate whether the port is busy.
  void note_rate() {
    const auto now = std::chrono::steady_clock::now();
    const Span passed = now - rate_begin_;
    if (passed < rate_window) return;
    const auto datagrams = static_cast<double>(stats_.datagrams - rate_datagrams_);
    busy_ = datagrams > (busy_ ? quiet_below : busy_from) * seconds(passed);
    rate_begin_ = now;
    rate_datagrams_ = stats_.datagrams;
    if (busy_ && descriptor_.is_open()) descriptor_.release();
  }

  void add(const DatagramBatch::Datagram& datagram) {
    count_drops(datagram);
    if (datagram.truncated) {
      ++stats_.truncated;
      return;
    }
    const bool unknown = is_unknown(datagram.from.address);
    ++stats_.datagrams;
    stats_.bytes += datagram.payload.size();
    Packet& packet = packets_.emplace_back();
    packet.payload = datagram.payload;
    packet.received = datagram.kernel_stamp ? *datagram.kernel_stamp : wall_clock();
    packet.from = datagram.from;
    packet.to = {datagram.to, port_};
    if (!unknown) return;
    ++stats_.unknown_sampled;
    packet.stands_for += stats_.unknown_filtered - std::exchange(attributed_, stats_.unknown_filtered);
  }

  /// The kernel counts filtered datagrams and losses of a full buffer in one number and reports it with the
  /// next datagram. A full buffer stays full until it is read: drops count as losses only up to the first
  /// datagram that came after the buffer was last found filling.
  void count_drops(const DatagramBatch::Datagram& datagram) {
    const std::uint32_t more = datagram.drops - drops_;  // unsigned: it may wrap
    drops_ = datagram.drops;
    (filtered_ && !filling_seen_ ? stats_.unknown_filtered : stats_.kernel_drops) += more;
    if (filling_seen_ && (!datagram.kernel_stamp || *datagram.kernel_stamp > *filling_seen_))
      filling_seen_.reset();
  }

  bool is_unknown(const IpAddress& sender) const {
    const auto& known = options_.senders;
    return !known.empty() && std::find(known.begin(), known.end(), sender) == known.end();
  }

  std::chrono::milliseconds next_retry() {
    return std::exchange(retry_, std::min<std::chrono::milliseconds>(2 * retry_, last_retry));
  }

  UdpOptions options_;
  Handler handler_;
  FileDescriptor socket_;
  boost::asio::posix::stream_descriptor descriptor_;  // socket_ in the reactor, not owned
  boost::asio::steady_timer timer_;                   // for retries
  boost::asio::steady_timer busy_timer_;
  DatagramBatch batch_;
  std::vector<Packet> packets_;  // of a batch
  UdpState state_;
  UdpStats stats_;
  std::uint16_t port_ = 0;
  std::chrono::milliseconds retry_ = first_retry;
  unsigned attempts_ = 0;  // to open the port, that failed in a row
  PortHolder holder_;      // of the port
  // Identifies the socket, so that queued handlers of a closed socket return.
  std::uint64_t generation_ = 0;
  bool filtered_ = false;
  std::optional<HostStamp> filling_seen_;
  std::uint32_t drops_ = 0;
  std::uint64_t attributed_ = 0;  // of stats_.unknown_filtered, to the packet of an unknown sender after them
  bool busy_ = false;             // read by busy_timer_ instead of the reactor
  std::chrono::steady_clock::time_point rate_begin_;
  std::uint64_t rate_datagrams_ = 0;  // at rate_begin_
};

UdpSource::UdpSource(boost::asio::io_context& io, UdpOptions options, Handler handler)
    : impl_(std::make_shared<Impl>(io, std::move(options), std::move(handler))) {}
UdpSource::~UdpSource() { impl_->stop(); }
void UdpSource::start() { impl_->start(); }
void UdpSource::stop() { impl_->stop(); }
void UdpSource::catch_up() { impl_->catch_up(); }
void UdpSource::interfaces_changed() { impl_->interfaces_changed(); }
void UdpSource::configure(UdpOptions options) { impl_->configure(std::move(options)); }
const UdpState& UdpSource::state() const { return impl_->state(); }
const UdpStats& UdpSource::stats() const { return impl_->stats(); }
std::uint16_t UdpSource::local_port() const { return impl_->local_port(); }

}  // namespace lidard
