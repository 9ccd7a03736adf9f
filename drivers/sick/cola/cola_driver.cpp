// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include "core/base/time.h"
#include "drivers/driver_base.h"
#include "drivers/sick/cola/cola_dialogue.h"
#include "drivers/sick/cola/cola_frames.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/cola/cola_scan.h"

namespace lidard::sick {
namespace {

/// Largest loss between two telegrams that came in one burst.
constexpr double loss_without_time = 1000;

enum class Warning : std::uint8_t {
  status,
  geometry,
  no_beams_left,
  no_distances,
  layer,
  other_device,
  count_
};

/// "output_1" ..., with static storage.
template <std::size_t Count>
class Names {
 public:
  Names(const char* before, const char* after) {
    for (std::size_t i = 0; i < Count; ++i) texts_[i] = before + std::to_string(i + 1) + after;
  }
  std::string_view operator[](std::size_t i) const { return texts_.at(i); }

 private:
  std::array<std::string, Count> texts_;
};

std::string_view field_name(std::uint8_t number) {
  static const Names<256> names("field_", "");
  return names[number == 0 ? 255 : number - 1U];
}

std::string_view pin_name(bool output, bool count, std::size_t i) {
  static const Names<ColaPins::most> outputs("output_", "");
  static const Names<ColaPins::most> counts("output_", "_count");
  static const Names<ColaPins::most> inputs("input_", "");
  if (!output) return inputs[i];
  return count ? counts[i] : outputs[i];
}

std::string_view encoder_name(bool speed, std::size_t i) {
  static const Names<ColaScan::most_encoders> positions("position_", "");
  static const Names<ColaScan::most_encoders> speeds("speed_", "");
  return speed ? speeds[i] : positions[i];
}

/// Publishes the device's messages beside its scans as states on topics of their own: `lferec` (field_1 ...:
/// 0 invalid, 1 free, 2 infringed), `lidoutputstate` (output_1 ..., output_1_count ...), `lidinputstate`
/// (input_1 ...: 0 inactive, 1 active, 2 not used), `encoder` (position_1 in ticks, speed_1 in ticks/mm) and
/// `imu`.
class ColaStates {
 public:
  explicit ColaStates(const DriverConfig& config) : time_offset_(config.time_offset) {
    state_->frame_id = imu_->frame_id = config.frame_id;
  }

  /// Publishes the telegram if it is one of these messages. Returns why it cannot be parsed.
  Reject read(const ColaTelegram& telegram, Stamp arrival, const ColaClock& clock, DriverOutput& out) {
    const std::string_view kind = telegram.kind(), name = telegram.name();
    if (kind != "sSN" && kind != "sRA") return Reject::none;
    if (name == "LFErec") return read_fields(telegram, arrival, clock, out);
    if (name == "LIDoutputstate") return read_pins(telegram, true, arrival, clock, out);
    if (name == "LIDinputstate") return read_pins(telegram, false, arrival, clock, out);
    if (name == "InertialMeasurementUnit") return read_imu(telegram, arrival, clock, out);
    return Reject::none;
  }

  /// The encoders of a scan, if it has any.
  void encoders(const ColaScan& scan, Stamp stamp, DriverOutput& out) {
    if (scan.encoder_count == 0) return;
    state_->values.clear();
    for (std::size_t i = 0; i < scan.encoder_count; ++i) {
      state_->values.push_back({encoder_name(false, i), static_cast<double>(scan.encoders[i].position)});
      state_->values.push_back({encoder_name(true, i), static_cast<double>(scan.encoders[i].speed)});
    }
    send(topic_encoder, stamp, out);
  }

 private:
  void send(std::string_view topic, Stamp stamp, DriverOutput& out) {
    state_->topic = topic;
    state_->stamp = stamp;
    out.message(state_);
  }

  Stamp stamp_of(const std::optional<std::uint32_t>& time_us, Stamp arrival, const ColaClock& clock) const {
    // The pins of some devices have no stamp, and a new subscription begins with old times, perhaps of before
    // the counter's overflow.
    const bool use = time_us && clock.ready();
    if (!use) return arrival + time_offset_;
    const Stamp stamp = clock.to_host(clock.near_last(*time_us));
    return (clock.clock().is_held() ? stamp : std::min(stamp, arrival)) + time_offset_;
  }

  Reject read_fields(const ColaTelegram& telegram, Stamp arrival, const ColaClock& clock, DriverOutput& out) {
    const Reject reason = parse_cola_fields(telegram, fields_);
    if (reason != Reject::none) return reason;
    state_->values.clear();
    for (std::size_t i = 0; i < fields_.count; ++i) {
      const ColaFields::Field& field = fields_.fields[i];
      state_->values.push_back({field_name(field.number), static_cast<double>(field.result)});
    }
    send(topic_fields, stamp_of(fields_.time_us, arrival, clock), out);
    return Reject::none;
  }

  Reject read_pins(const ColaTelegram& telegram, bool output, Stamp arrival, const ColaClock& clock,
                   DriverOutput& out) {
    const Reject reason = output ? parse_cola_outputs(telegram, pins_) : parse_cola_inputs(telegram, pins_);
    if (reason != Reject::none) return reason;
    state_->values.clear();
    for (std::size_t i = 0; i < pins_.count; ++i) {
      state_->values.push_back({pin_name(output, false, i), static_cast<double>(pins_.pins[i].state)});
    }
    for (std::size_t i = 0; output && i < pins_.count; ++i) {
      state_->values.push_back({pin_name(output, true, i), static_cast<double>(pins_.pins[i].count)});
    }
    send(output ? topic_outputs : topic_inputs, stamp_of(pins_.time_us, arrival, clock), out);
    return Reject::none;
  }

  Reject read_imu(const ColaTelegram& telegram, Stamp arrival, const ColaClock& clock, DriverOutput& out) {
    ColaImu read;
    const Reject reason = parse_cola_imu(telegram, read);
    if (reason != Reject::none) return reason;
    if (std::exchange(imu_us_, read.time_us) == read.time_us) return Reject::duplicate;
    imu_->stamp = stamp_of(read.time_us, arrival, clock);
    set_imu(read.acceleration, read.angular_velocity, read.orientation, imu_);
    out.message(imu_);
    return Reject::none;
  }

  Span time_offset_;
  ReusedMessage<DeviceState> state_;
  ReusedMessage<ImuSample> imu_;
  std::optional<std::uint32_t> imu_us_;  // time of the last sample
  ColaFields fields_;
  ColaPins pins_;
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

  Verdict receive(const Packet& packet, DriverOutput& out) override {
    if (packet.stream_start) {
      counting_ = plain_scans_ = false;
      clock_.restart();
      cloud_builder_.finish(out);
    }
    const Verdict verdict = read_stream<ColaTelegram>(
        packet, stream_, [&](const ColaTelegram& telegram) { return handle(telegram, packet.arrival, out); });
    if (dialogue_.changed()) show_info();
    return verdict;
  }

  void connected(Stamp now, DriverOutput& out) override {
    stream_.interrupt();
    counting_ = false;
    dialogue_.connected(now, out);
    show_info();
  }

  void disconnected() override {
    stream_.interrupt();
    dialogue_.disconnected();
    if (dialogue_.changed()) show_info();
  }

  void tick(Stamp now, DriverOutput& out) override {
    dialogue_.tick(now, out);
    describe_clock(clock_.clock(), clock_.wraps(), now);
    if (dialogue_.changed()) show_info();
  }

  const DeviceClock* clock() const override { return &clock_.clock(); }
  bool sends_time() const override { return clock_.sends_time(); }
  void finish(DriverOutput& out) override { cloud_builder_.finish(out); }

  void restart() override {
    stream_.interrupt();
    clock_.reset();
    cloud_builder_.clear();
    counting_ = false;
    stamps_.reset();
    forget_repeated();
  }

 private:
  Verdict handle(const ColaTelegram& telegram, Stamp arrival, DriverOutput& out) {
    if (is_scan(telegram)) {
      ++counters_.packets;
      const bool repeated = is_repeated(telegram.arguments());
      return {true, repeated ? Reject::duplicate : handle_scan(telegram, arrival, out)};
    }
    ++counters_.other_packets;
    if (telegram.kind() != "sSN") dialogue_.receive(telegram, arrival, out);
    return {false, states_.read(telegram, arrival, clock_, out)};
  }

  /// True for a scan; LMDscandatamon is ignored if the device also sends LMDscandata, which it repeats.
  bool is_scan(const ColaTelegram& telegram) {
    if (!is_cola_scan(telegram)) return false;
    const bool monitor = telegram.name() == monitor_scan;
    plain_scans_ = plain_scans_ || !monitor;
    return !monitor || !plain_scans_;
  }

  Reject handle_scan(const ColaTelegram& telegram, Stamp arrival, DriverOutput& out) {
    dialogue_.scan_came(telegram.dialect, arrival);
    Reject reason = parse_cola_scan(telegram, scan_);
    if (reason != Reject::none) return reason;
    if (!device_known_ || dialect_ != telegram.dialect || serial_ != scan_.serial || name_ != scan_.name()) {
      dialect_ = telegram.dialect;
      follow_device();
    }
    board_.update(Warning::status, scan_.status[0] != 0 || scan_.status[1] != 0, [&] {
      return "the device reports status " + std::to_string(scan_.status[0]) + " " +
             std::to_string(scan_.status[1]) +
             " instead of 0 0: a fault or a dirty window; check it with SOPAS ET";
    });
    reason = apply_geometry();
    if (reason != Reject::none) return reason;
    const Span rest = row_.stamp == ColaStamp::last_beam ? Span(0) : geometry_.sweep();
    const Span period = span_from_seconds(scan_.scan_hz > 0 ? 1 / scan_.scan_hz : config_.model->frame_period);
    const Span start = clock_.observe(scan_.start_us, scan_.transmit_us, rest, period, arrival);
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

  void follow_device() {
    const std::uint32_t before = serial_;
    if (device_known_ && before != scan_.serial) {
      clock_.reset();
      counting_ = false;
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
    board_.update(Warning::no_distances, !good && scan_.channel("DIST1") == nullptr, [] {
      return "the device sends scans without distances; switch the channel DIST1 on (LMDscandatacfg)";
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

  void publish(Span first, DriverOutput& out) {
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
    for (const auto& each : dialogue_.info().details) info_.details.push_back(each);
    board_.lead(dialogue_.info().warnings);
  }

  const ColaRow& row_;
  WarningBoard<Warning> board_{info_.warnings};
  ColaStream stream_;
  ColaClock clock_;
  ColaScan scan_;
  ColaGeometry geometry_;
  bool has_geometry_ = false, has_beams_ = false;
  ColaScanBuilder scan_builder_;
  ColaCloudBuilder cloud_builder_;
  ColaStates states_;
  ColaDialogue dialogue_;

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
