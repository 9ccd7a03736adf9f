// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>

#include "core/base/number_text.h"
#include "core/base/time.h"
#include "drivers/driver_base.h"
#include "drivers/hokuyo/models.h"
#include "drivers/hokuyo/scip_dialogue.h"
#include "drivers/hokuyo/scip_message.h"

namespace lidard::hokuyo {
namespace {

// urg_c allows three; no known document gives the number.
constexpr std::size_t most_echoes = 3;
constexpr char next_echo = '&';
// Two characters end at 4095, which then only says "not nearer".
constexpr int short_range_max_mm = 4094;
/// In a capture, so many scans of other steps in a row are the answer to a new request.
constexpr int foreign_limit = 10;
/// Longer pauses are an ended stream, no loss.
constexpr std::int64_t longest_loss = 10'000;
constexpr int enough_comparisons = 10;
/// Half a second of a fast sensor. One fitting answer in between shows that the line is bad, not the request.
constexpr int unfit_limit = 20;
constexpr Span fine_comparison = std::chrono::microseconds(300);
constexpr int most_renewals = 3;  // of a connection; each costs some scans

class ScipDriver final : public DriverBase, private ScipDialogue::Owner {
 public:
  explicit ScipDriver(const DriverConfig& config)
      : DriverBase(config),
        row_(*static_cast<const ScipRow*>(config.model->row)),
        dialogue_(*this, board_, config_),
        clock_(config.clock, row_.sends_on_tick),
        parameters_(row_.parameters) {
    scan_.frame_id = config.frame_id;
  }

  Verdict receive(const Packet& packet, FrameReceiver& out) override {
    if (packet.stream_start && !dialogue_.active()) clock_.connection();
    if (!clock_.ready()) find_newest(packet);
    return read_stream<ScipMessage>(packet, reader_, [&](const ScipMessage& item) {
      const Verdict verdict = handle(item, packet.arrival, out);
      last_answer_ = packet.arrival;
      return verdict;
    });
  }

  void connected(Stamp now, FrameReceiver& out) override {
    reader_.interrupt();
    clock_.connection();
    comparisons_ = renewals_ = unfit_answers_ = 0;
    dialogue_.connected(now, out);
  }

  void disconnected() override {
    reader_.interrupt();
    dialogue_.disconnected();
  }

  const DeviceClock* clock() const override { return &clock_.clock(); }
  void tick(Stamp now, FrameReceiver& out) override {
    dialogue_.tick(now, out);
    describe_clock(clock_.clock(), clock_.wraps(), now);
    if (std::chrono::abs(now - last_report_) < std::chrono::seconds(1)) return;
    last_report_ = now;
    if (const auto delay = clock_.measured_delay())
      info_.set("Computed Latency", printed("%.3f ms after the last beam", seconds(*delay) * 1e3));
  }

  void restart() override {
    reader_.interrupt();
    last_answer_ = Stamp();
    clock_.reset();
    stamps_.reset();
    forget_repeated();
  }

 private:
  /// The clock begins with the newest scan of the first read.
  void find_newest(const Packet& packet) {
    std::optional<ScipClock::Sweep> newest;
    look_ahead<ScipMessage>(packet, reader_, [&](const ScipMessage& message) {
      const auto request = parse_scan_request(message.echo);
      if (!request || message.status != "99") return;
      std::string_view body = message.body;
      const std::string_view line = cut_line(body);
      const auto stamp = has_checksum(line) ? parse_stamp(line) : std::nullopt;
      if (stamp) newest = sweep_of(*stamp, *request, packet.arrival);
    });
    if (newest) clock_.begin_with(*newest);
  }

  ScipClock::Sweep sweep_of(ScipStamp stamp, const ScipScanRequest& request, Stamp arrival) const {
    ScipClock::Sweep sweep;
    sweep.stamp = stamp;
    sweep.period = span_from_seconds(parameters_.turn_seconds() * (1 + request.skip));
    sweep.until_sent = span_from_seconds(parameters_.step_seconds() * request.last_step);
    sweep.arrival = arrival;
    sweep.evenly = request.continuous;
    return sweep;
  }

  ScipScanRequest wanted() override { return request_for(parameters_, config_); }

  bool knows_percent() const override {
    return row_.has_percent && product_.find("UST") != std::string::npos && firmware_knows_percent(firmware_);
  }

  bool compared(ScipStamp stamp, Stamp sent, Stamp received) override {
    clock_.compare(stamp, sent, received);
    const auto rest = clock_.uncertainty();
    return ++comparisons_ >= enough_comparisons && rest && *rest < fine_comparison;
  }

  Verdict handle(const ScipMessage& message, Stamp arrival, FrameReceiver& out) {
    if (message.echo.empty()) {
      ++counters_.packets;
      return {true, Reject::magic};
    }
    const auto request = parse_scan_request(message.echo);
    const bool has_data = request && message.status == (request->continuous ? "99" : "00");
    if (!has_data) {
      ++counters_.other_packets;
      if (message.status == "00" && message.echo == "VV") note_version(message);
      if (message.status == "00" && message.echo == "PP") note_parameters(message);
      if (message.status == "00" && message.echo == "II") note_information(message);
      // In a capture: clients ask when the answer before has come, as the dialogue does.
      const auto time = parse_time(message);
      if (time && !dialogue_.active() && last_answer_ != Stamp())
        clock_.compare(*time, last_answer_, arrival);
      dialogue_.receive(message, arrival, out);
      return {};
    }
    const bool before_our_stream = dialogue_.active() && !dialogue_.streaming();
    dialogue_.receive(message, arrival, out);
    if (before_our_stream && !dialogue_.streaming()) {
      ++counters_.other_packets;  // on its way when the stream was ended
      return {};
    }
    ++counters_.packets;
    if (is_repeated(ByteView(message.body))) return {true, Reject::duplicate};
    const Reject reason = publish(message, *request, arrival, out);
    note_fit(reason, arrival, out);
    return {true, reason};
  }

  /// A stream without a fitting answer is from another sensor than assumed: asks for its identity again, and
  /// for a plainer stream.
  void note_fit(Reject reason, Stamp arrival, FrameReceiver& out) {
    if (reason == Reject::none) {
      unfit_answers_ = 0;
      board_.clear(ScipTrouble::unfit);
      if (!clock_.needs_comparison() || renewals_ >= most_renewals) return;
      ++renewals_;
      comparisons_ = 0;
      return dialogue_.compare_again(arrival, out);
    }
    if (++unfit_answers_ < unfit_limit) return;
    board_.set(
        ScipTrouble::unfit,
        "no answer of the stream fits what was asked for (" + std::string(to_string(reason)) +
            "), the sensor is asked again who it is and for plain stamps; if it stays, check the model "
            "in the configuration and report the firmware version");
    dialogue_.reexamine(arrival, out);
  }

  // Checksums of these lines do not matter: URG-04LX firmware sends a wrong one for the serial number.
  void note_version(const ScipMessage& message) {
    for_each_entry(message.body, [this](std::string_view key, std::string_view value, bool) {
      if (key == "VEND") info_.set("Vendor Name", value);
      if (key == "PROT") info_.set("Protocol Version", value);
      if (key == "SERI") note_serial(value);
      if (key == "FIRM") info_.set("Firmware Version", firmware_ = value);
      if (key == "PROD") info_.set("Product Name", product_ = value);
    });
  }

  void note_parameters(const ScipMessage& message) {
    ScipParameters read;
    std::string product;
    if (!parse_parameters(message.body, read, product)) {
      board_.set(
          ScipTrouble::parameters,
          "the sensor's answer to PP cannot be used, the angles and ranges of " +
              std::string(config_.model->product) +
              " are taken instead; check the model in the configuration and report the firmware version");
      return;
    }
    board_.clear(ScipTrouble::parameters);
    parameters_ = read;
    if (product_.empty()) info_.set("Product Name", product);
    product_ = product;
    board_.clear(ScipTrouble::model);
    if (!row_.any && product.compare(0, row_.product.size(), row_.product) != 0)
      board_.set(
          ScipTrouble::model,
          "the sensor says it is a " + product + ", not a " + std::string(config_.model->product) +
              "; its own angles and ranges are used: set model: " + std::string(scip_name_of(product)));
  }

  void note_information(const ScipMessage& message) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 4> shown = {
        {{"LASR", "Laser"}, {"SCSP", "Scan speed"}, {"MESM", "Measurement mode"}, {"STAT", "Device Status"}}};
    for_each_entry(message.body, [this, &shown](std::string_view key, std::string_view value, bool) {
      for (const auto& [name, label] : shown) {
        if (name == key) info_.set(label, value);
      }
    });
  }

  void note_serial(std::string_view serial) {
    if (!info_.serial.empty() && info_.serial != serial)
      board_.set(ScipTrouble::device, "sensor " + info_.serial + " was replaced by sensor " +
                                          std::string(serial) + "; check its pose");
    info_.serial = serial;
    info_.set("Device ID", serial);
  }

  Reject publish(const ScipMessage& message, const ScipScanRequest& request, Stamp arrival,
                 FrameReceiver& out) {
    std::string_view body = message.body;
    const std::string_view stamp_line = cut_line(body);
    if (!has_checksum(stamp_line) || !join_lines(body, flat_)) return Reject::checksum;
    const auto stamp = parse_stamp(stamp_line);
    if (!stamp) return Reject::field;
    if (!accept_geometry(request)) {
      ++counters_.other_packets;
      return Reject::none;
    }
    const Reject reason = fill(request);
    board_.clear(ScipTrouble::values);
    if (reason == Reject::size) {
      board_.set(ScipTrouble::values,
                 "the sensor sends another number of distances than was asked for; the stream is started "
                 "again: if it goes on, switch its power off and on");
      dialogue_.restart_stream(arrival, out);
    }
    if (reason != Reject::none) return reason;
    const ScipClock::Sweep sweep = sweep_of(*stamp, request, arrival);
    scan_.scan_time = static_cast<float>(seconds(sweep.period));
    scan_.stamp = first_ray(sweep);
    if (scan_.beams == 0) return Reject::none;
    ++counters_.frames;
    out.scan(scan_);
    return Reject::none;
  }

  /// False for scans of other steps than those of this session.
  bool accept_geometry(const ScipScanRequest& request) {
    const bool same_sensor = geometry_ && geometry_->parameters == parameters_;
    if (same_sensor && geometry_->request == request &&
        geometry_->request.short_values == request.short_values) {
      foreign_ = 0;
      return true;
    }
    if (same_sensor && !dialogue_.active() && ++foreign_ < foreign_limit) return false;
    foreign_ = 0;
    if (geometry_)
      board_.set(ScipTrouble::geometry,
                 "the number or the angles of the beams changed; restart whatever expects the former");
    geometry_ = Geometry{parameters_, request};
    choose_beams();
    return true;
  }

  /// Chooses the values between the configured angles. The middle of a group of merged steps is its
  /// direction.
  void choose_beams() {
    const ScipParameters& p = geometry_->parameters;
    const ScipScanRequest& request = geometry_->request;
    const double step = request.cluster * p.rad_per_step();
    const double first = p.angle(request.first_step + (request.cluster - 1) / 2.0);
    window_ = lidard::choose_beams(config_, first, step, request.values(), scan_);
    scan_.time_increment = static_cast<float>(p.step_seconds() * request.cluster);
    range_max_mm_ = request.short_values ? std::min(p.range_max_mm, short_range_max_mm) : p.range_max_mm;
    scan_.range_min = static_cast<float>(p.range_min_mm * 1e-3);
    scan_.range_max = static_cast<float>(range_max_mm_ * 1e-3);
    const auto steps_before = request.first_step + static_cast<int>(window_.first) * request.cluster;
    before_first_ray_ = span_from_seconds(p.step_seconds() * steps_before);
    board_.update(ScipTrouble::no_beams, window_.count == 0, [] {
      return "no beam lies between angle_min and angle_max; correct the angles in the configuration";
    });
  }

  /// The stamp is that of step 0, even if it is not asked for (Hokuyo C-42-03320B p. 12).
  Stamp first_ray(const ScipClock::Sweep& sweep) {
    std::int64_t skipped = 0;
    const Stamp begin = clock_.begin_of(sweep, skipped);
    if (skipped <= longest_loss) counters_.lost_packets += static_cast<std::uint64_t>(skipped);
    counters_.clock_steps = clock_.steps();
    return stamps_.next(begin + before_first_ray_ + config_.time_offset);
  }

  Reject fill(const ScipScanRequest& request) {
    const std::size_t echoes =
        config_.publish_multiecho && config_.model->has(Trait::echoes) ? most_echoes : 1;
    const bool with_intensities = config_.publish_intensity && request.intensities;
    scan_.reset(scan_.beams, echoes, with_intensities);
    const std::size_t distance_size = request.short_values ? 2 : 3;
    const std::size_t size = distance_size + (request.intensities ? 3 : 0);
    const std::string_view values(flat_.data(), flat_.size());
    std::size_t count = 0;
    std::size_t echo = 0;
    for (std::size_t at = 0; at < values.size(); at += size) {
      const bool further = values[at] == next_echo;
      if (further && count == 0) return Reject::field;
      if (further) ++at;
      echo = further ? echo + 1 : 0;
      if (!further) ++count;
      if (values.size() - at < size) return Reject::size;
      const auto distance = scip_number(values.substr(at, distance_size));
      const auto intensity = request.intensities ? scip_number(values.substr(at + distance_size, 3))
                                                 : std::optional<std::uint64_t>(0);
      if (!distance || !intensity) return Reject::field;
      const std::size_t beam = count - 1 - window_.first;  // wraps below the first: then it is not less
      if (beam >= scan_.beams || echo >= echoes) continue;
      put(beam, echo, static_cast<std::uint32_t>(*distance));
      if (with_intensities) scan_.intensities[scan_.index(beam, echo)] = static_cast<float>(*intensity);
    }
    scan_.hide_gap(window_);
    return count == request.values() ? Reject::none : Reject::size;
  }

  void put(std::size_t beam, std::size_t echo, std::uint32_t distance_mm) {
    const std::size_t i = scan_.index(beam, echo);
    if (static_cast<int>(distance_mm) < geometry_->parameters.range_min_mm)
      scan_.set_without_hit(i, status_of_code(row_.any ? code_table_of(product_) : row_.codes, distance_mm));
    else
      scan_.set_measured(i, static_cast<float>(distance_mm * 1e-3));
  }

  const ScipRow& row_;
  WarningBoard<ScipTrouble> board_{info_};
  ScipReader reader_{counters_};
  ScipDialogue dialogue_;
  ScipClock clock_;
  int comparisons_ = 0, renewals_ = 0;
  std::string product_, firmware_;
  ScipParameters parameters_;  // as far as known

  struct Geometry {
    ScipParameters parameters;
    ScipScanRequest request;
  };
  std::optional<Geometry> geometry_;
  int foreign_ = 0, unfit_answers_ = 0;
  BeamWindow window_;
  Span before_first_ray_{0};
  int range_max_mm_ = 0;
  PlanarScan scan_;
  SteadyStamps stamps_;
  Stamp last_report_, last_answer_;
  std::vector<char> flat_;
};

}  // namespace

std::unique_ptr<Driver> make_scip_driver(const DriverConfig& config) {
  return std::make_unique<ScipDriver>(config);
}

}  // namespace lidard::hokuyo
