// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include "core/base/number_text.h"
#include "core/base/time.h"
#include "drivers/driver_base.h"
#include "drivers/sick/cola/cola_dialogue.h"
#include "drivers/sick/cola/cola_frames.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/cola/cola_scan.h"
#include "drivers/sick/cola/cola_states.h"

namespace lidard::sick {
namespace {

/// Largest loss between two telegrams that came in one burst.
constexpr double loss_without_time = 1000;

enum class Warning : std::uint8_t {
  state,
  geometry,
  no_beams_left,
  no_distances,
  later_echo,
  raw_angles,
  layer,
  other_device,
  count_
};

class ColaDriver final : public DriverBase {
 public:
  explicit ColaDriver(const DriverConfig& config)
      : DriverBase(config),
        row_(*static_cast<const ColaRow*>(config.model->row)),
        stream_(counters_),
        clock_(config.clock),
        scan_builder_(config_, row_),
        cloud_builder_(config_, row_, counters_),
        states_(config),
        dialogue_(config, row_) {}

  Verdict receive(const Packet& packet, FrameReceiver& out) override {
    if (packet.stream_start) {
      counting_ = plain_scans_ = compensation_is_new_ = false;
      clock_.restart();
      cloud_builder_.finish(out);
    }
    if (!clock_.ready()) find_newest(packet);
    const Verdict verdict = read_stream<ColaTelegram>(
        packet, stream_, [&](const ColaTelegram& telegram) { return handle(telegram, packet.arrival, out); });
    if (dialogue_.changed()) show_info();
    return verdict;
  }

  void connected(Stamp now, FrameReceiver& out) override {
    stream_.interrupt();
    counting_ = compensation_is_new_ = false;
    dialogue_.connected(now, out);
    show_info();
  }

  void disconnected() override {
    stream_.interrupt();
    dialogue_.disconnected();
    if (dialogue_.changed()) show_info();
  }

  void tick(Stamp now, FrameReceiver& out) override {
    dialogue_.tick(now, out);
    describe_clock(clock_.clock(), clock_.wraps(), now);
    if (dialogue_.changed()) show_info();
  }

  const DeviceClock* clock() const override { return &clock_.clock(); }
  bool sends_time() const override { return clock_.sends_time(); }
  void finish(FrameReceiver& out) override { cloud_builder_.finish(out); }

  void restart() override {
    stream_.interrupt();
    clock_.reset();
    cloud_builder_.clear();
    counting_ = false;
    stamps_.reset();
    forget_repeated();
  }

 private:
  Verdict handle(const ColaTelegram& telegram, Stamp arrival, FrameReceiver& out) {
    if (is_scan(telegram)) {
      ++counters_.packets;
      const bool repeated = is_repeated(telegram.arguments());
      return {true, repeated ? Reject::duplicate : handle_scan(telegram, arrival, out)};
    }
    ++counters_.other_packets;
    if (telegram.kind() != "sSN") dialogue_.receive(telegram, arrival, out);
    const Reject reason = telegram.kind() == "sRA" ? read_answer(telegram) : Reject::none;
    return {false, reason != Reject::none ? reason : states_.read(telegram, arrival, clock_, out)};
  }

  /// Uses an answer about the device, also one to another client in a capture.
  Reject read_answer(const ColaTelegram& telegram) {
    if (telegram.name() == contamination_state)
      contamination_ = read_arguments(telegram, [](auto in) { return in.u8(); });
    if (telegram.name() != angle_compensation || row_.compensation == AngleCompensation::none)
      return Reject::none;
    ColaAngleCompensation read;
    const Reject reason = parse_cola_compensation(telegram, row_.compensation, read);
    if (reason != Reject::none) return reason;
    compensation_ = read;
    compensation_is_new_ = true;
    compensate();
    return Reject::none;
  }

  void compensate() {
    scan_builder_.compensate(compensation_.value_or(ColaAngleCompensation()));
    if (has_geometry_) has_beams_ = scan_builder_.choose(geometry_);
    show_info();
  }

  /// The clock begins with the newest scan of the first read.
  void find_newest(const Packet& packet) {
    bool found = false;
    look_ahead<ColaTelegram>(packet, stream_, [&](const ColaTelegram& telegram) {
      found = is_cola_scan(telegram) && parse_cola_scan(telegram, scan_) == Reject::none &&
              apply_geometry() == Reject::none;
    });
    if (found) observe(packet.arrival);
    clock_.repeat();
  }
  /// The unwrapped start time of the scan.
  Span observe(Stamp arrival) {
    const Span rest = row_.stamp == ColaStamp::last_beam ? Span(0) : geometry_.sweep();
    const double period_s = scan_.scan_hz > 0 ? 1 / scan_.scan_hz : config_.model->frame_period;
    return clock_.observe(scan_.start_us, scan_.transmit_us, rest, span_from_seconds(period_s), arrival);
  }

  /// True for a scan; LMDscandatamon is ignored if the device also sends LMDscandata, which it repeats.
  bool is_scan(const ColaTelegram& telegram) {
    if (!is_cola_scan(telegram)) return false;
    const bool monitor = telegram.name() == monitor_scan;
    plain_scans_ = plain_scans_ || !monitor;
    return !monitor || !plain_scans_;
  }

  Reject handle_scan(const ColaTelegram& telegram, Stamp arrival, FrameReceiver& out) {
    dialogue_.scan_came(telegram.dialect, arrival);
    Reject reason = parse_cola_scan(telegram, scan_);
    if (reason != Reject::none) return reason;
    if (!device_known_ || dialect_ != telegram.dialect || serial_ != scan_.serial || name_ != scan_.name()) {
      dialect_ = telegram.dialect;
      if (!device_known_ && !row_.remark.empty()) out.note(row_.remark);
      follow_device();
    }
    note_status(arrival);
    reason = apply_geometry();
    if (reason != Reject::none) return reason;
    board_.update(Warning::raw_angles, row_.compensation != AngleCompensation::none && !compensation_, [] {
      return "the scanner's angles are raw, 0.2 degrees wrong at worst: its answer to 'sRN MCAngleCompSin' "
             "is missing; record the connection from its beginning, or update the scanner's firmware";
    });
    const Span start = observe(arrival);
    counters_.clock_steps = clock_.steps();
    follow_counters(start, arrival);
    const Span first = first_of_telegram(start);
    states_.encoders(scan_, clock_.to_host(first) + config_.time_offset, out);
    if (!row_.layered) {
      publish(first, out);
      return Reject::none;
    }
    const bool known = cloud_builder_.add(scan_, geometry_, first, clock_, out);
    board_.update(Warning::layer, !known, [&] {
      return "the device sends a plane at " + std::to_string(scan_.layer) +
             " (1/100 deg) that this model does not have; check `model`";
    });
    return known ? Reject::none : Reject::model;
  }

  void note_status(Stamp arrival) {
    constexpr Span start_up = std::chrono::seconds(10);  // an LMS111 starts with 7 scans without laser
    std::uint32_t bits = scan_.status[0] * 0x100U + scan_.status[1];
    if (contamination_ > 0) bits |= contamination_ == 1 ? cola_status::contaminated : cola_status::blind;
    if (scan_.status[0] != 1 || laser_on_ == Stamp()) laser_on_ = arrival;
    if (scan_.status[0] == 1 && std::chrono::abs(arrival - laser_on_) < start_up)
      bits &= ~cola_status::laser_off;
    if (std::exchange(status_, bits) != bits) board_.show(Warning::state, cola_self_report(bits));
  }

  void follow_device() {
    const std::uint32_t before = serial_;
    if (device_known_ && before != scan_.serial) {
      clock_.reset();
      counting_ = false;
      // The answer of the former scanner.
      if (!compensation_is_new_) compensation_.reset(), compensate();
      board_.set(Warning::other_device, "scanner " + std::to_string(before) + " was replaced by scanner " +
                                            std::to_string(scan_.serial) + "; check its pose and its fields");
    }
    device_known_ = true;
    serial_ = scan_.serial;
    info_.serial = std::to_string(serial_);
    name_ = std::string(scan_.name());
    show_info();
  }

  /// Counts a gap in the telegram counter as loss if the elapsed time allows it, by the device's clock and,
  /// since that may have restarted, roughly by the host's. Some devices count scans, not telegrams.
  void follow_counters(Span start, Stamp arrival) {
    const auto by_telegram = static_cast<std::uint16_t>(scan_.telegram_counter - telegram_counter_);
    const auto by_scan = static_cast<std::uint16_t>(scan_.scan_counter - scan_counter_);
    const std::uint16_t ahead = by_telegram != 0 ? by_telegram : by_scan;
    if (counting_ && ahead > 1 && scan_.scan_hz > 0) {
      const double passed = seconds(start - counted_at_) * scan_.scan_hz;
      const double passed_here = seconds(arrival - counted_arrival_) * scan_.scan_hz;
      if (ahead <= passed + 2 && ahead <= passed_here + loss_without_time)
        counters_.lost_packets += ahead - 1U;
    }
    counting_ = true;
    telegram_counter_ = scan_.telegram_counter;
    scan_counter_ = scan_.scan_counter;
    counted_at_ = start;
    counted_arrival_ = arrival;
  }

  Reject apply_geometry() {
    ColaGeometry now;
    const bool good = read_geometry(scan_, row_, now);
    board_.update(Warning::no_distances, !good && scan_.echo_count() == 0, [] {
      return "the device sends scans without distances; switch the channel DIST1 on (LMDscandatacfg)";
    });
    board_.update(Warning::later_echo, good && scan_.echo(0) != 0, [&] {
      return "the device sends " + std::string(distance_names.at(scan_.echo(0))) +
             " without the first echo: nearer objects are unseen and nothing is free; switch DIST1 on "
             "(LMDscandatacfg)";
    });
    if (!good) return Reject::field;
    if (has_geometry_ && now == geometry_) return Reject::none;
    if (has_geometry_ && !now.is_interlaced_with(geometry_)) {
      board_.set(Warning::geometry,
                 "the scanner changed from " + describe(geometry_) + " to " + describe(now) +
                     "; restart whatever expects the former, or undo the change in SOPAS ET");
    }
    if (!(now.beam_period == geometry_.beam_period)) clock_.forget_ways();
    geometry_ = now;
    has_geometry_ = true;
    has_beams_ = scan_builder_.choose(geometry_);
    board_.update(Warning::no_beams_left, !has_beams_ && !row_.layered, [&] {
      return "no beam lies between angle_min and angle_max, the scanner sends " + describe(geometry_) +
             "; correct the angles in the configuration";
    });
    return Reject::none;
  }

  /// A stamp is not that of the last beam where half a turn and more passes before the transmission: an
  /// LMS151 at 25 Hz sends 45 ms after it.
  Span first_of_telegram(Span start) const {
    const Span turn = span_from_seconds(geometry_.beam_period * 360 / geometry_.step_deg);
    const bool is_late = clock_.shortest_way() && *clock_.shortest_way() > turn / 2;
    return row_.stamp == ColaStamp::last_beam && !is_late ? start - geometry_.sweep() : start;
  }

  void publish(Span first, FrameReceiver& out) {
    if (!has_beams_) return;
    const Span before =
        span_from_seconds(geometry_.beam_period * static_cast<double>(scan_builder_.first_beam()));
    PlanarScan& scan = scan_builder_.fill(scan_);
    scan.stamp = stamps_.next(clock_.to_host(first + before) + config_.time_offset);
    ++counters_.frames;
    out.scan(scan);
  }

  void show_info() {
    clear_details();
    info_.set("Dialect", dialect_ == ColaDialect::a ? "CoLa A" : "CoLa B");
    if (!name_.empty()) info_.set("Device name", name_);
    if (!row_.remark.empty()) info_.set("Remark", row_.remark);
    if (compensation_)
      info_.set("Angle compensation (deg)",
                printed("amplitude %.4f, phase %.4f, offset %.4f", compensation_->amplitude_deg,
                        compensation_->phase_deg, compensation_->offset_deg));
    for (const auto& each : dialogue_.info().details) info_.details.push_back(each);
    board_.lead(dialogue_.info().warnings);
  }

  const ColaRow& row_;
  WarningBoard<Warning> board_{info_};
  ColaStream stream_;
  ColaClock clock_;
  ColaScan scan_;
  ColaGeometry geometry_;
  bool has_geometry_ = false, has_beams_ = false;
  ColaScanBuilder scan_builder_;
  ColaCloudBuilder cloud_builder_;
  ColaStates states_;
  ColaDialogue dialogue_;
  std::uint8_t contamination_ = 0;  // SICK 8013796 p. 86: 1 warning, 2 error, 3 serious error
  std::uint32_t status_ = 0;        // shown
  Stamp laser_on_;                  // the last scan with the laser on
  std::optional<ColaAngleCompensation> compensation_;
  bool compensation_is_new_ = false;  // of this connection

  bool device_known_ = false;
  std::uint32_t serial_ = 0;
  ColaDialect dialect_ = ColaDialect::b;
  std::string name_;
  bool counting_ = false;
  bool plain_scans_ = false;  // LMDscandata came in this stream
  std::uint16_t telegram_counter_ = 0, scan_counter_ = 0;
  Span counted_at_{0};  // device time
  Stamp counted_arrival_;
  SteadyStamps stamps_;
};

}  // namespace

std::unique_ptr<Driver> make_cola_driver(const DriverConfig& config) {
  return std::make_unique<ColaDriver>(config);
}

}  // namespace lidard::sick
