// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/counters.h"
#include "core/base/number_text.h"
#include "core/base/time.h"
#include "core/frames/scan.h"
#include "drivers/driver.h"

namespace lidard::sick {

/// One beam as sent by the device.
struct Ms3Beam {
  std::uint16_t distance;  ///< times Ms3Derived::factor: mm
  std::uint8_t reflectivity;
  std::uint8_t status;  ///< Ms3BeamFlag

  bool is(std::uint8_t flag) const { return (status & flag) != 0; }
};

/// Flags of Ms3Beam::status.
namespace ms3_beam {
constexpr std::uint8_t valid = 0x01;
constexpr std::uint8_t infinite = 0x02;  ///< no echo
constexpr std::uint8_t glare = 0x04;     ///< the receiver is dazzled
constexpr std::uint8_t reflector = 0x08;
constexpr std::uint8_t contamination = 0x10;
constexpr std::uint8_t contamination_warning = 0x20;
/// Not described in SICK 8022708 (2019) and not read by SICK's own drivers (sick_safetyscanners_base). In a
/// recording of a microScan3 (129 scans) 11.5 % of the beams have one or both of them: 79 and 65 % of the
/// hits with a reflectivity below 20, 2.4 and 3.2 % of those from 30 on; the second alone stands at steps
/// from one surface to another, also of bright ones. So they may mark weak and mixed echoes, which is
/// unverified. The distances are as steady as others', and count.
constexpr std::uint8_t unknown_6 = 0x40;
constexpr std::uint8_t unknown_7 = 0x80;
}  // namespace ms3_beam

/// Configuration of the data output, as rounded by the device.
struct Ms3Derived {
  std::uint16_t factor;              ///< raw distance times this is mm
  std::uint16_t beams;               ///< number of beams
  std::uint16_t scan_time_ms;        ///< ms
  double start_deg;                  ///< of the first beam; 0 is right of the device, counter-clockwise
  double step_deg;                   ///< deg between neighbouring beams
  std::uint32_t beam_period_us;      ///< us between neighbouring beams
  std::int32_t raw_start, raw_step;  ///< the angles in 1/4194304 deg
};

/// General system state. Cut-off paths are bits, path 1 first; a set bit of `safe_paths` and
/// `non_safe_paths` is the ON state (field free).
struct Ms3State {
  bool run_mode, standby, contamination_warning, contamination_error, reference_contour, manipulation;
  std::uint32_t safe_paths, non_safe_paths, reset_required_paths;
  std::array<std::uint8_t, 4> monitoring_case;  ///< of tables 1-4
  bool application_error, device_error;

  auto tied() const {
    return std::tie(run_mode, standby, contamination_warning, contamination_error, reference_contour,
                    manipulation, safe_paths, non_safe_paths, reset_required_paths, monitoring_case,
                    application_error, device_error);
  }
  friend bool operator==(const Ms3State& a, const Ms3State& b) { return a.tied() == b.tied(); }
};

/// Application data: the outputs that are used.
struct Ms3Application {
  std::uint32_t evaluation_paths, evaluation_safe, evaluation_valid;
  std::array<std::uint16_t, 20> cases;  ///< active monitoring case per table
  std::uint8_t standby_state;           ///< 1 standby, 2 not in standby
  std::uint8_t valid_flags;             ///< bit 0 standby state, bit 1 error flags
};

/// One instance of the data output of a microScan3, nanoScan3 or outdoorScan3 ("MS3 MD"), all blocks.
/// The views point into the bytes that were parsed. Blocks that are switched off are empty.
struct Ms3Telegram {
  std::uint8_t version_major, version_minor, version_release;
  std::uint32_t serial, plug_serial;
  std::uint8_t channel;
  std::uint32_t sequence;  ///< counts the data sets sent on this channel
  std::uint32_t scan;      ///< counts scans; does not move in standby

  std::optional<Ms3State> state;
  std::optional<Ms3Derived> derived;
  bool has_measurement;
  ByteView beam_bytes;
  std::array<ByteView, 24> intrusion;  ///< per cut-off path: bits of interrupted beams, first beam in bit 0
  std::optional<Ms3Application> application;
  bool has_unreadable_block;  ///< a status block is shorter than known; it was left out

  std::size_t beams() const { return beam_bytes.size() / 4; }
  Ms3Beam beam(std::size_t i) const {
    const std::uint8_t* p = beam_bytes.data() + 4 * i;
    return {static_cast<std::uint16_t>(p[0] | p[1] << 8U), p[2], p[3]};
  }
  /// True if any beam of the cut-off path (0-23) is interrupted.
  bool is_intruded(std::size_t path) const;
};

/// Reads one instance. Every offset, length and count is checked; Reject::none if the telegram can be used.
Reject parse_ms3_telegram(ByteView instance, Ms3Telegram& telegram);

/// True if beams, angles and times are the same; the distance factor may differ.
inline bool same_geometry(const Ms3Derived& a, const Ms3Derived& b) {
  return a.beams == b.beams && a.raw_start == b.raw_start && a.raw_step == b.raw_step &&
         a.scan_time_ms == b.scan_time_ms && a.beam_period_us == b.beam_period_us;
}

/// "48 beams from -10.5597 deg in steps of 0.51306 deg, 30 ms a scan".
inline std::string describe(const Ms3Derived& d) {
  return printed("%u beams from %.4f deg in steps of %.5f deg, %u ms a scan", d.beams, d.start_deg,
                 d.step_deg, d.scan_time_ms);
}

/// Time between neighbouring beams. The announced one is rounded to us, 0.3 ms in a scan; the exact one
/// follows from the turn of the mirror and is used where it agrees.
inline Span beam_period(const Ms3Derived& d) {
  const Span announced = std::chrono::microseconds(d.beam_period_us);
  const Span exact = span_from_seconds(d.scan_time_ms * 1e-3 * std::abs(d.step_deg) / 360);
  return std::chrono::abs(exact - announced) <= std::chrono::microseconds(1) ? exact : announced;
}

/// State of a beam by its flags. A dazzled receiver misses objects, so glare comes before "no echo": no false
/// free space.
inline BeamStatus status_of(Ms3Beam beam) {
  if (beam.is(ms3_beam::glare)) return BeamStatus::invalid;
  if (beam.is(ms3_beam::infinite)) return BeamStatus::none;
  return beam.is(ms3_beam::valid) ? BeamStatus::hit : BeamStatus::invalid;
}

/// One datagram of the safety scanners' data output, with its position in the instance.
struct Ms3Datagram {
  std::uint32_t total = 0;           ///< bytes of the instance
  std::uint32_t identification = 0;  ///< equal in all datagrams of an instance
  std::uint32_t offset = 0;          ///< of `data` in the instance, bytes
  ByteView data;
};

/// Reads and checks a datagram's header; `datagram` is valid if the answer is Reject::none.
Reject read_ms3_datagram(ByteView payload, Ms3Datagram& datagram);

/// The serial number of the scanner, in the first datagram of an instance; 0: not in this one.
std::uint32_t serial_in(ByteView payload);

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
  /// Blocks are addressed by 16-bit offsets (SICK 8022708 p. 20): no block lies beyond.
  static constexpr std::uint32_t max_instance = 65536;

  /// Instances given up are counted in `counters.incomplete`.
  explicit Ms3Reassembler(Counters& counters) : counters_(counters) {}

  /// Adds a datagram. `complete.bytes` is empty unless it was the last one missing.
  Reject add(const Packet& packet, Instance& complete);
  /// Sets the time after which an unfinished instance is given up; two scan times are right.
  void set_patience(Span patience) { patience_ = patience; }
  /// Gives up instances that waited too long at `now` (arrival time scale).
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
  Slot& claim(const Key& key, std::uint32_t total, Stamp arrival);
  const Finished* finished(const Key& key, Stamp now) const;
  void remember(const Key& key, bool complete, Stamp at);
  void give_up(Slot& slot, Stamp now);
  void give_up_older_than(const Slot& done, Stamp now);
  static bool store(Slot& slot, const Ms3Datagram& datagram);

  Counters& counters_;
  Span patience_ = std::chrono::milliseconds(200);
  std::array<Slot, max_open> slots_;
  std::array<Finished, 16> finished_;
  std::size_t next_finished_ = 0;
  std::uint64_t order_ = 0;
};

}  // namespace lidard::sick
