// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/counters.h"
#include "core/base/time.h"
#include "drivers/driver.h"

namespace lidard::sick {

/// One datagram of the safety scanners' data output: where its bytes belong in the instance.
struct Ms3Datagram {
  std::uint32_t total = 0;           ///< bytes of the whole instance
  std::uint32_t identification = 0;  ///< equal in all datagrams of an instance
  std::uint32_t offset = 0;          ///< of `data` in the instance, bytes
  ByteView data;
};

/// Reads and checks a datagram's header; `datagram` is valid if the answer is Reject::none.
Reject read_ms3_datagram(ByteView payload, Ms3Datagram& datagram);

/// Puts the instances of the data output together from datagrams that may come in any order, twice or not at
/// all. Memory is bounded: four unfinished instances of at most 64 KiB.
class Ms3Reassembler {
 public:
  /// A complete instance; the bytes stay valid until the next call of `add()`.
  struct Instance {
    ByteView bytes;
    Stamp first_arrival;  ///< of the datagram that came first
  };
  static constexpr std::size_t max_open = 4;
  /// Blocks are addressed by 16-bit offsets (SICK 8022708 p. 20): nothing beyond could be reached.
  static constexpr std::uint32_t max_instance = 65536;

  /// Instances given up are counted in `counters.incomplete`.
  explicit Ms3Reassembler(Counters& counters) : counters_(counters) {}

  /// Takes a datagram. `complete.bytes` is empty unless it was the last one missing.
  Reject add(const Packet& packet, Instance& complete);
  /// An instance unfinished for so long is given up; two scan times are right.
  void set_patience(Span patience) { patience_ = patience; }
  /// Gives up what waited too long at `now` (arrival time scale).
  void expire(Stamp now);
  /// Gives up everything unfinished.
  void give_up_all();
  /// Forgets everything, without counting.
  void clear();
  /// Number of unfinished instances.
  std::size_t open() const;

 private:
  struct Key {
    Endpoint from;
    std::uint16_t to_port = 0;
    std::uint32_t identification = 0;
    friend bool operator==(const Key& a, const Key& b) {
      return a.from == b.from && a.to_port == b.to_port && a.identification == b.identification;
    }
  };
  struct Slot {
    bool used = false;
    Key key;
    Stamp first_arrival;
    std::uint64_t order = 0;
    std::size_t covered = 0;
    std::vector<std::uint8_t> bytes;
    std::vector<std::uint8_t> present;  // one per byte of `bytes`

    bool channel_known() const;
    std::uint8_t channel() const;
  };
  struct Finished {
    bool used = false;
    Key key;
    bool complete = false;
    Stamp at;
  };

  Slot* find(const Key& key);
  Slot& take(const Key& key, std::uint32_t total, Stamp arrival);
  const Finished* finished(const Key& key, Stamp now) const;
  void remember(const Key& key, bool complete, Stamp at);
  void give_up(Slot& slot, Stamp now);
  void give_up_older_than(const Slot& done, Stamp now);
  static bool place(Slot& slot, const Ms3Datagram& datagram);

  Counters& counters_;
  Span patience_ = std::chrono::milliseconds(200);
  std::array<Slot, max_open> slots_;
  std::array<Finished, 16> finished_;
  std::size_t next_finished_ = 0;
  std::uint64_t order_ = 0;
};

}  // namespace lidard::sick
