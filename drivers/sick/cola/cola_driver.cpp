// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include "core/base/time.h"
#include "drivers/driver_base.h"
#include "drivers/sick/cola/cola_dialogue.h"
#include "drivers/sick/cola/cola_frames.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/cola/cola_scan.h"
#include "drivers/sick/cola/cola_states.h"

namespace lidard::sick {
namespace {

/// So many telegrams may be missing between two that came in one burst.
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

  Reject receive(const Packet& packet, DriverOutput& out) override {
    counters_.bytes += packet.payload.size();
    if (packet.stream_start || packet.missing > 0) stream_.reset();
    if (packet.stream_start) counting_ = false;
    const std::uint64_t rejected = counters_.rejected_total();
    stream_.add(packet.payload);
    Reject result = Reject::none;
    ColaTelegram telegram;
    while (stream_.next(telegram)) {
      const Reject reason = handle(telegram, packet.arrival, out);
      if (reason == Reject::none) continue;
      counters_.reject(reason);
      result = reason;
    }
    if (result == Reject::none && counters_.rejected_total() != rejected) result = Reject::checksum;
    if (dialogue_.changed()) show_info();
    return result;
  }

  void connected(Stamp now, DriverOutput& out) override {
    stream_.reset();
    counting_ = false;
    dialogue_.start(now, out);
    show_info();
  }

  void disconnected() override {
    stream_.reset();
    dialogue_.stop();
    if (dialogue_.changed()) show_info();
  }

  void tick(Stamp now, DriverOutput& out) override {
    dialogue_.tick(now, out);
    if (dialogue_.changed()) show_info();
  }

  void finish(DriverOutput& out) override { cloud_builder_.finish(out); }

  void restart() override {
    stream_.reset();
    clock_.reset();
    cloud_builder_.clear();
    counting_ = false;
    stamps_.reset();
  }

 private:
  Reject handle(const ColaTelegram& telegram, Stamp arrival, DriverOutput& out) {
    const std::string_view kind = telegram.kind();
    if (telegram.name() == "LMDscandata" && (kind == "sSN" || kind == "sRA")) {
      ++counters_.packets;
      return handle_scan(telegram, arrival, out);
    }
    ++counters_.other_packets;
    if (kind != "sSN") dialogue_.answer(telegram, arrival, out);
    Reject reason = Reject::none;
    states_.take(telegram, arrival, clock_, out, reason);
    return reason;
  }

  Reject handle_scan(const ColaTelegram& telegram, Stamp arrival, DriverOutput& out) {
    Reject reason = parse_cola_scan(telegram, scan_);
    if (reason != Reject::none) return reason;
    dialogue_.scan_came(telegram.dialect);
    if (!device_known_ || dialect_ != telegram.dialect || serial_ != scan_.serial || name_ != scan_.name()) {
      dialect_ = telegram.dialect;
      follow_device();
    }
    board_.tell(Warning::status, scan_.status[0] != 0 || scan_.status[1] != 0, [&] {
      return "the device tells status " + std::to_string(scan_.status[0]) + " " +
             std::to_string(scan_.status[1]) +
             " instead of 0 0: a fault or a dirty window; look at it with SOPAS ET";
    });
    reason = take_geometry();
    if (reason != Reject::none) return reason;
    const Span start = clock_.observe(scan_.start_us, scan_.transmit_us, geometry_.sweep(), arrival);
    counters_.clock_steps = clock_.steps();
    follow_counters(start, arrival);
    const Span first = first_of_telegram(start);
    states_.encoders(scan_, clock_.to_host(first) + config_.time_offset, out);
    if (!row_.layered) {
      publish(first, out);
      return Reject::none;
    }
    const bool known = cloud_builder_.add(scan_, geometry_, first, clock_, out);
    board_.tell(Warning::layer, !known, [&] {
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
      board_.tell(Warning::other_device, true, [&] {
        return "scanner " + std::to_string(before) + " was replaced by scanner " +
               std::to_string(scan_.serial) + "; check its pose and its fields";
      });
    }
    device_known_ = true;
    serial_ = scan_.serial;
    info_.serial = std::to_string(serial_);
    name_ = std::string(scan_.name());
    show_info();
  }

  /// A gap in the telegram counter is a loss if the time that passed allows for it, by the device's clock
  /// and, since that may have started anew, roughly by ours. Devices that do not count telegrams count scans.
  /// A telegram that comes twice is no loss; it is handed on as what it says it is.
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

  Reject take_geometry() {
    ColaGeometry now;
    const bool good = read_geometry(scan_, row_, now);
    board_.tell(Warning::no_distances, !good && scan_.channel("DIST1") == nullptr, [] {
      return "the device sends scans without distances; switch the channel DIST1 on (LMDscandatacfg)";
    });
    if (!good) return Reject::field;
    if (has_geometry_ && now == geometry_) return Reject::none;
    if (has_geometry_) {
      board_.set(Warning::geometry,
                 "the scanner changed from " + describe(geometry_) + " to " + describe(now) +
                     "; restart whatever expects the former, or undo the change in SOPAS ET");
    }
    geometry_ = now;
    has_geometry_ = true;
    has_beams_ = scan_builder_.choose(geometry_);
    board_.tell(Warning::no_beams_left, !has_beams_ && !row_.layered, [&] {
      return "no beam lies between angle_min and angle_max, the scanner sends " + describe(geometry_) +
             "; correct the angles in the configuration";
    });
    return Reject::none;
  }

  Span first_of_telegram(Span start) const {
    return row_.stamp == ColaStamp::last_beam ? start - geometry_.sweep() : start;
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
