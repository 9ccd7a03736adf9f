// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "core/base/time.h"
#include "drivers/dialogue.h"
#include "drivers/driver_base.h"
#include "drivers/sick/safety/ms3_telegram.h"
#include "drivers/sick/safety/safety_models.h"
#include "drivers/sick/safety/safety_status.h"
#include "drivers/sick/safety/scan_clock.h"

namespace lidard::sick {
namespace {

/// After such a silence another device or channel is accepted, and sequence numbers may start again.
constexpr Span silence = std::chrono::seconds(1);
/// A warning of another device that sends to the same port stays for so long.
constexpr Span rival_memory = std::chrono::seconds(10);
/// Data sets at most this late were overtaken; older ones are a restart of the device.
constexpr std::int32_t overtaking_limit = 16;
/// Loss that is accepted at once; a larger one must fit the elapsed time.
constexpr std::int64_t loss_without_time = 1000;

enum class Warning : std::uint8_t {
  state,
  dirty_beams,
  geometry,
  no_beams_left,
  other_stream,
  other_device,
  no_geometry,
  no_measurement,
  unreadable,
  version,
  beyond_range,
  count_
};

class SafetyDriver final : public DriverBase {
 public:
  explicit SafetyDriver(const DriverConfig& config)
      : DriverBase(config),
        row_(*static_cast<const SafetyRow*>(config.model->row)),
        reassembler_(counters_),
        clock_(config.clock),
        dialogue_(make_safety_dialogue(config)) {
    prepare_scan(config, scan_);
  }

  Verdict receive(const Packet& packet, FrameReceiver& out) override {
    if (packet.transport == Transport::tcp) {
      ++counters_.other_packets;
      dialogue_->receive(packet, out);
      note_dialogue();
      return {};
    }
    last_datagram_ = packet.arrival;
    ++counters_.packets;
    counters_.bytes += packet.payload.size();
    Ms3Reassembler::Instance instance;
    Reject reason = reassembler_.add(packet, instance);
    if (reason == Reject::none && !instance.bytes.empty()) reason = handle(instance, out);
    if (reason != Reject::none) counters_.reject(reason);
    return {true, reason, device_named("scanner ", serial_in(packet.payload))};
  }

  void connected(Stamp now, FrameReceiver& out) override { dialogue_->connected(now, out); }
  void disconnected() override { dialogue_->disconnected(); }

  void tick(Stamp now, FrameReceiver& out) override {
    reassembler_.expire(now);
    dialogue_->tick(now, last_datagram_, out);
    describe_clock(clock_.clock(), 0, now);
    note_dialogue();
  }

  const DeviceClock* clock() const override { return &clock_.clock(); }
  void finish(FrameReceiver&) override { reassembler_.give_up_all(); }

  void restart() override {
    reassembler_.clear();
    clock_.reset();
    stream_known_ = false;
    sequence_known_ = false;
    stamps_.reset();
  }

 private:
  Reject handle(const Ms3Reassembler::Instance& instance, FrameReceiver& out) {
    const Reject reason = parse_ms3_telegram(instance.bytes, telegram_);
    board_.update(Warning::version, reason == Reject::version, [&] {
      return "the scanner sends version " + std::to_string(telegram_.version_major) +
             " of the data output, known is version 2; its scans are not used: update this program";
    });
    if (reason != Reject::none) return reason;
    const Stamp arrival = instance.first_arrival;
    if (!is_ours(arrival)) {
      ++counters_.other_packets;
      return Reject::none;
    }
    const bool frozen = sequence_known_ && telegram_.scan == scan_number_;
    const Reject order = follow_sequence(arrival);
    if (order != Reject::none) return order;
    note_status();
    note_blocks();
    if (frozen || !telegram_.has_measurement) {
      if (frozen || status_.in_standby()) clock_.pause();
      ++counters_.other_packets;
      scan_.stamp = arrival + config_.time_offset;
      topics_.publish_states(telegram_, scan_, out);
      return Reject::none;
    }
    if (!telegram_.derived) return Reject::field;
    apply_geometry(*telegram_.derived);
    const Stamp end =
        clock_.end_of_scan(telegram_.scan, std::chrono::milliseconds(geometry_->scan_time_ms), arrival);
    counters_.clock_steps = clock_.steps();
    publish(end, out);
    return Reject::none;
  }

  /// False for the data of another device or another channel.
  bool is_ours(Stamp arrival) {
    if (stream_known_ && telegram_.serial == serial_ && telegram_.channel == channel_) {
      if (std::chrono::abs(arrival - rival_at_) > rival_memory) board_.clear(Warning::other_stream);
      last_arrival_ = arrival;
      return true;
    }
    if (stream_known_ && std::chrono::abs(arrival - last_arrival_) <= silence) {
      rival_at_ = arrival;
      board_.update(Warning::other_stream, true, [&] {
        const std::string remedy = telegram_.serial == serial_
                                       ? "give each channel its own UDP port"
                                       : "give each its own UDP port, or set ip_address";
        return "channel " + std::to_string(telegram_.channel) + " of scanner " +
               std::to_string(telegram_.serial) + " sends to the same place as channel " +
               std::to_string(channel_) + " of scanner " + std::to_string(serial_) + " and is left out; " +
               remedy;
      });
      return false;
    }
    const std::uint32_t before = serial_;
    board_.clear(Warning::other_device);
    if (stream_known_ && telegram_.serial != before)
      board_.set(Warning::other_device, "scanner " + std::to_string(before) + " was replaced by scanner " +
                                            std::to_string(telegram_.serial) +
                                            "; check its pose and its fields");
    stream_known_ = true;
    serial_ = telegram_.serial;
    channel_ = telegram_.channel;
    last_arrival_ = arrival;
    sequence_known_ = false;
    clock_.reset();
    info_.serial = std::to_string(serial_);
    return true;
  }

  /// Counts missing data sets by the sequence number. The scan number also skips where only every n-th scan
  /// is sent, and after standby (SICK 8022708 p. 11).
  Reject follow_sequence(Stamp arrival) {
    const std::uint32_t by_sequence = telegram_.sequence - sequence_;
    const std::uint32_t by_scan = telegram_.scan - scan_number_;
    const auto ahead = static_cast<std::int32_t>(by_sequence != 0 ? by_sequence : by_scan);
    if (sequence_known_) {
      if (ahead == 0) return Reject::duplicate;
      const bool soon = std::chrono::abs(arrival - counted_until_) <= silence;
      if (ahead < 0 && ahead >= -overtaking_limit && soon) {
        ++counters_.reordered;
        return Reject::stale;
      }
      const Span scan_time = std::chrono::milliseconds(geometry_ ? geometry_->scan_time_ms : 30);
      const std::int64_t passed = std::chrono::abs(arrival - counted_until_) / scan_time;
      if (ahead > 0 && ahead - 1 <= loss_without_time + passed)
        counters_.lost_packets += static_cast<std::uint64_t>(ahead - 1);
    }
    sequence_known_ = true;
    sequence_ = telegram_.sequence;
    scan_number_ = telegram_.scan;
    counted_until_ = arrival;
    return Reject::none;
  }

  void note_status() {
    const SafetyStatus now = read_status(telegram_);
    if (status_known_ && now == status_) return;
    status_known_ = true;
    status_ = now;
    board_.show(Warning::state, troubles(status_));
    list_details();
  }

  void note_blocks() {
    board_.update(Warning::no_geometry, telegram_.has_measurement && !telegram_.derived, [] {
      return "the scanner sends measurement data without the configuration of the data output (derived "
             "values), so the angles of its beams are unknown; switch that block on in Safety Designer";
    });
    board_.update(Warning::no_measurement, !telegram_.has_measurement && !status_.in_standby(), [] {
      return "the scanner sends its state but no measurement data; switch that block on in Safety Designer";
    });
    board_.update(Warning::unreadable, telegram_.has_unreadable_block, [] {
      return "a status block of the scanner is not as SICK 8022708 describes it and is left out; scans are "
             "not affected, but its state may be missing here: please report the firmware version";
    });
  }

  void note_dialogue() {
    if (!dialogue_->changed()) return;
    if (info_.serial.empty()) info_.serial = dialogue_->info().serial;
    list_details();
    board_.lead(dialogue_->info().warnings);
  }

  void list_details() {
    clear_details();
    for (const auto& detail : dialogue_->info().details) info_.details.push_back(detail);
    if (!status_known_) return;
    for (auto& detail : describe(status_)) info_.details.push_back(std::move(detail));
  }

  void apply_geometry(const Ms3Derived& derived) {
    if (geometry_ && same_geometry(*geometry_, derived)) {
      geometry_ = derived;  // the distance factor may differ
      return;
    }
    if (geometry_) {
      board_.set(Warning::geometry,
                 "the scanner changed from " + describe(*geometry_) + " to " + describe(derived) +
                     "; restart whatever expects the former, or undo the change in Safety Designer");
    }
    geometry_ = derived;
    // Late is no loss: a busy network delays a datagram by more than a turn.
    reassembler_.set_patience(
        std::chrono::milliseconds(std::max<std::int64_t>(100, 2 * std::int64_t{derived.scan_time_ms})));
    choose_beams();
  }

  /// Chooses the beams between the configured angles.
  void choose_beams() {
    const double step = geometry_->step_deg * rad_per_deg;
    const double first = (geometry_->start_deg - row_.ahead_deg) * rad_per_deg;
    window_ = lidard::choose_beams(config_, first, step, geometry_->beams, scan_);
    scan_.scan_time = static_cast<float>(geometry_->scan_time_ms * 1e-3);
    scan_.time_increment = static_cast<float>(seconds(beam_period(*geometry_)));
    board_.update(Warning::no_beams_left, window_.count == 0, [&] {
      return "no beam lies between angle_min and angle_max, the scanner sends " + describe(*geometry_) +
             " (90 deg is ahead); correct the angles in the configuration";
    });
  }

  void publish(Stamp end, FrameReceiver& out) {
    scan_.stamp = first_ray(end);
    topics_.publish_states(telegram_, scan_, out);
    if (scan_.beams == 0) {
      ++counters_.other_packets;
      return;
    }
    fill();
    board_.update(Warning::beyond_range, beyond_range_m_ > 0, [&] {
      return "the scanner measures up to " + std::to_string(beyond_range_m_) + " m, but range_max of " +
             std::string(config_.model->name) + " is " + std::to_string(config_.model->range_max) +
             " m and farther echoes count as none; choose the model with the longer range";
    });
    ++counters_.frames;
    topics_.publish_beams(telegram_, scan_, window_, out);
    out.scan(scan_);
  }

  void fill() {
    scan_.reset(scan_.beams, 1, config_.publish_intensity);
    const double metres = geometry_->factor * 1e-3;
    constexpr unsigned dirty = ms3_beam::contamination | ms3_beam::contamination_warning;
    unsigned flags = 0;
    scan_.flags.resize(scan_.beams);
    for (std::size_t i = 0; i < scan_.beams; ++i) {
      const Ms3Beam beam = telegram_.beam(window_.first + i);
      scan_.flags[i] = beam.status;
      flags |= beam.status;
      if (config_.publish_intensity) scan_.intensities[i] = beam.reflectivity;
      const BeamStatus status = status_of(beam);
      const auto range = static_cast<float>(beam.distance * metres);
      if (status != BeamStatus::hit) {
        scan_.set_without_hit(i, status);
        continue;
      }
      scan_.set_measured(i, range);
      // A device of that range may overshoot its end a little.
      if (range > 1.05F * scan_.range_max) beyond_range_m_ = std::max<double>(beyond_range_m_, range);
    }
    board_.update(Warning::dirty_beams, !telegram_.state && (flags & dirty) != 0,
                  [] { return "the scanner marks beams as contaminated; clean its optics cover"; });
    // The ranges show these two.
    scan_.hide_gap(window_);
    if ((flags & ~(0U + ms3_beam::valid + ms3_beam::infinite)) == 0) scan_.flags.clear();
  }

  /// The data leaves after the last beam; the first published beam was measured so many periods before.
  Stamp first_ray(Stamp end) {
    const auto before = static_cast<std::int64_t>(geometry_->beams - 1 - window_.first);
    return stamps_.next(end - beam_period(*geometry_) * before + config_.time_offset);
  }

  const SafetyRow& row_;
  WarningBoard<Warning> board_{info_};
  Ms3Reassembler reassembler_;
  Ms3Telegram telegram_{};
  ScanClock clock_;

  bool stream_known_ = false;
  std::uint32_t serial_ = 0;
  std::uint8_t channel_ = 0;
  Stamp last_arrival_, rival_at_;
  bool sequence_known_ = false;
  std::uint32_t sequence_ = 0, scan_number_ = 0;
  Stamp counted_until_;
  bool status_known_ = false;
  SafetyStatus status_;

  std::optional<Ms3Derived> geometry_;
  BeamWindow window_;
  PlanarScan scan_;
  SteadyStamps stamps_;
  double beyond_range_m_ = 0;

  SafetyTopics topics_;
  std::unique_ptr<SideDialogue> dialogue_;
  std::optional<Stamp> last_datagram_;
};

}  // namespace

std::unique_ptr<Driver> make_safety_driver(const DriverConfig& config) {
  return std::make_unique<SafetyDriver>(config);
}

}  // namespace lidard::sick
