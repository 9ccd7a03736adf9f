// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/time.h"
#include "test/sim/world/rng.h"

namespace lidard::sim {

/// The way from the device's send buffer to the receiver: later by `delay` and up to `jitter` more (evenly
/// distributed); nothing overtakes.
struct Transit {
  Span delay{50'000};
  Span jitter{0};
  std::uint64_t seed = 1;
};

/// Bytes that a device sends, when they arrive, and the time of the sweep's step 0 behind them.
struct Outgoing {
  Stamp time;
  std::string bytes;
  std::optional<Stamp> sweep;
};

/// A device that serves one TCP client. Owns no socket and no clock: a test, a server or a capture writer
/// brings both.
class TcpDevice {
 public:
  explicit TcpDevice(Transit transit) : transit_(transit), rng_(transit.seed) {}
  virtual ~TcpDevice() = default;

  /// A client came or went.
  virtual void connected(Stamp now) = 0;
  virtual void disconnected() {
    sent_.clear();
    last_ = Stamp();
  }
  /// What the client sent.
  virtual void receive(std::string_view bytes, Stamp now) = 0;
  /// The next bytes that arrive no later than `until`, in order; empty if there are none.
  std::optional<Outgoing> next(Stamp until) {
    produce(until);
    if (sent_.empty() || sent_.front().time > until) return std::nullopt;
    Outgoing first = std::move(sent_.front());
    sent_.pop_front();
    return first;
  }

 protected:
  /// Queues everything the device sends of its own accord until then.
  virtual void produce(Stamp until) = 0;
  void send(std::string bytes, Stamp leaves, std::optional<Stamp> sweep = std::nullopt) {
    Stamp arrives = leaves + transit_.delay;
    if (transit_.jitter.count() > 0)
      arrives =
          arrives +
          Span(static_cast<std::int64_t>(rng_.uniform() * static_cast<double>(transit_.jitter.count())));
    last_ = arrives > last_ ? arrives : last_ + Span(1);
    sent_.push_back({last_, std::move(bytes), sweep});
  }

 private:
  Transit transit_;
  Rng rng_;
  Stamp last_;
  std::deque<Outgoing> sent_;
};

}  // namespace lidard::sim
