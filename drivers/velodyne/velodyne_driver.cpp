// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "drivers/driver_base.h"
#include "drivers/velodyne/cloud_builder.h"
#include "drivers/velodyne/hdl64_status.h"
#include "drivers/velodyne/models.h"
#include "drivers/velodyne/packet.h"
#include "drivers/velodyne/packet_order.h"
#include "drivers/velodyne/raw_packets.h"
#include "drivers/velodyne/telemetry.h"
#include "drivers/velodyne/timing.h"
#include "drivers/velodyne/two_streams.h"
#include "drivers/velodyne/web/web_dialogue.h"

namespace lidard::velodyne {
namespace {

/// An S2 or S3 sends its calibration, an S1 does not.
constexpr const char* no_calibration =
    "an HDL-64E S1 does not send its calibration: without it points are wrong by a metre and more; set "
    "`calibration` to the db.xml that came with the sensor";

class VelodyneDriver final : public DriverBase {
 public:
  explicit VelodyneDriver(const DriverConfig& config)
      : DriverBase(config),
        row_(*static_cast<const ModelRow*>(config.model->row)),
        order_(row_, counters_),
        arrival_stamps_(row_),
        timing_(row_),
        raw_(config),
        frames_(config_, row_, raw_, counters_),
        clock_(config.clock),
        telemetry_(config) {
    if (row_.bank_by_bank && config.calibration == nullptr) {
      info_.warnings.emplace_back(no_calibration);
      info_.from_configuration = no_calibration;
    }
    if (config.control) web_.emplace(*web_control(config));
  }

  void change(const DriverConfig& wanted) override {
    raw_.set_time_offset(wanted.time_offset);
    frames_.change(wanted);
    telemetry_.set_time_offset(wanted.time_offset);
  }

  Verdict receive(const Packet& packet, FrameReceiver& out) override {
    raw_.add(packet, out);
    if (packet.transport == Transport::tcp) {
      if (web_) web_->receive(packet, out), note_dialogue();
      return {};
    }
    if (packet.payload.size() == position_packet_size) {
      ++counters_.other_packets;
      return {false, telemetry_.receive(packet, out, info_)};
    }
    incoming_.index = static_cast<std::uint32_t>(counters_.packets++);
    counters_.bytes += packet.payload.size();
    incoming_.arrival = packet.arrival;
    // Copied first: one read of the memory is faster than access to single blocks.
    if (packet.payload.size() == packet_size)
      std::memcpy(incoming_.bytes.data(), packet.payload.data(), packet_size);
    const Reject reason = check(packet.payload);
    if (reason != Reject::none) {
      counters_.reject(reason);
      return {true, reason, reason == Reject::model ? device_of(incoming_, true) : std::string_view()};
    }
    incoming_.layout = &layout_of(incoming_.view(), row_);
    incoming_.azimuths = read_azimuths(incoming_.view(), *incoming_.layout);
    if (!row_.has_stamp()) arrival_stamps_.stamp(packet.arrival, incoming_.azimuths, incoming_.bytes.data());
    const std::uint8_t product = incoming_.view().product();
    const bool may_be_old = row_.without_factory_bytes != nullptr && !is_product(product);
    incoming_.other_product = row_.names_product() && !row_.has_product(product) && !may_be_old;
    const std::string_view device = device_of(incoming_, incoming_.other_product);
    return {true, order_.add(incoming_, [&](const OrderedPacket& p, Span time) { accept(p, time, out); }),
            device};
  }

  void finish(FrameReceiver& out) override {
    order_.flush([&](const OrderedPacket& p, Span time) { accept(p, time, out); });
    decode_pending(std::nullopt, out);
    frames_.cut_off(out);
    raw_.publish(out);
    describe_status();
  }
  void restart() override {
    order_.reset();
    arrival_stamps_.reset();
    status_.restart();
    raw_.clear();
    frames_.reset();
    clock_.reset();
    telemetry_.restart();
    edge_.reset();
    pending_ = in_stream_ = false;
  }
  void connected(Stamp now, FrameReceiver& out) override {
    if (web_) web_->connected(now, out);
  }
  void disconnected() override {
    if (web_) web_->disconnected();
  }
  void tick(Stamp now, FrameReceiver& out) override {
    telemetry_.tick(now, info_);
    describe_clock(clock_, order_.wraps(), now);
    if (web_) {
      const bool heard = counters_.packets > 0;
      web_->tick(now, heard ? std::optional<Stamp>(incoming_.arrival) : std::nullopt, out);
      note_dialogue();
    }
    constexpr Span describe_period = std::chrono::seconds(1);
    if (now - described_ < describe_period && described_ < now) return;
    described_ = now;
    describe_status();
  }

  const DeviceClock* clock() const override { return &clock_; }
  bool sends_time() const override { return row_.has_stamp(); }

 private:
  /// What distinguishes the packet's lidar from another one with its address; not of an HDL-64E, which names
  /// no product and may have no stamps or two packets of one stamp.
  std::string_view device_of(const OrderedPacket& packet, bool is_other_product) {
    if (!row_.names_product()) return {};
    if (is_other_product) return other_product_ = product_name(packet.view().product());
    const Span period = row_.packet_period(row_.timings.front(), packet.layout->echoes);
    return streams_.is_other(packet, period) ? std::string_view(another_) : config_.model->product;
  }

  Reject check(ByteView payload) {
    if (payload.size() != packet_size) return Reject::size;
    const DataPacket packet(payload);
    const Reject reason = check_blocks(packet, layout_of(packet, row_));
    if (reason == Reject::none || row_.has_product(packet.product())) return reason;
    if (row_.names_product()) return is_product(packet.product()) ? Reject::model : reason;
    // An HDL-64E S1 has another order of blocks than the later ones.
    const ModelRow* other = reason == Reject::magic ? family_of(payload) : nullptr;
    const bool is_hdl64e = other != nullptr && !other->names_product();
    return is_hdl64e && other->has_stamp() != row_.has_stamp() ? Reject::model : reason;
  }

  /// Accepts a packet in order; it waits for the next packet if its times depend on that one.
  void accept(const OrderedPacket& packet, Span time, FrameReceiver& out) {
    if (row_.has_status()) read_status(packet.view());
    // Times within a frame are differences, so a jump of the device clock ends the frame.
    constexpr Span jump = std::chrono::seconds(5);
    const bool is_set = counters_.clock_steps != known_steps_;
    known_steps_ = counters_.clock_steps;
    if (in_stream_ && (is_set || time < last_time_ || time - last_time_ > jump)) {
      decode_pending(std::nullopt, out);
      frames_.cut_off(out);
      clock_.restart();
      turned_deg_ = turned_s_ = 0;
      edge_.reset();
    } else if (in_stream_) {
      const NextPacket next{time - last_time_};
      measure_turn(packet.view().azimuth(0) * 0.01, next.step);
      timing_.add(next.step, row_.sequences_per_packet(last_echoes_));
      decode_pending(next, out);
    }
    in_stream_ = true;
    last_time_ = time;
    last_echoes_ = packet.layout->echoes;
    last_azimuth_deg_ = packet.view().azimuth(0) * 0.01;
    if (row_.random_rest || packet.azimuths.hidden_total_deg > 0 || !timing_.decided()) {
      waiting_ = packet;
      waiting_time_ = time;
      pending_ = true;
    } else {
      decode(packet, time, std::nullopt, out);
    }
  }

  void decode_pending(const std::optional<NextPacket>& next, FrameReceiver& out) {
    if (!pending_) return;
    pending_ = false;
    decode(waiting_, waiting_time_, next, out);
  }

  void decode(const OrderedPacket& packet, Span time, const std::optional<NextPacket>& next,
              FrameReceiver& out) {
    const DataPacket view = packet.view();
    const PacketLayout& layout = *packet.layout;
    const bool old_firmware = row_.without_factory_bytes != nullptr && !row_.has_product(view.product());
    set_timing(old_firmware ? *row_.without_factory_bytes : timing_.timing(), timing_.decided());
    const PacketAzimuths& azimuths = packet.azimuths;
    const FiringSchedule schedule =
        schedule_of(row_, *timing_in_force_, timing_.measured_sequence(), azimuths, layout.echoes, next,
                    rate_over_turn(azimuths, time));
    // The packet is sent after its last firing sequence.
    clock_.observe(time + schedule.end, packet.arrival);

    frames_.unpacker().set_rate(schedule.rate_deg_per_s);
    frames_.set_echoes(layout.echoes);
    const std::size_t per_block = row_.sequences_per_block();
    begin_packet(packet, time, schedule, schedule.sequence * static_cast<int>(per_block - 1));
    Sequence sequence{};
    sequence.packet = packet.index;
    for (std::size_t g = 0; g < layout.groups; ++g) {
      for (std::size_t s = 0; s < per_block; ++s) {
        const Span into_group = schedule.sequence * static_cast<int>(s);
        sequence.in_packet = schedule.begin[g] + into_group;
        const double azimuth = azimuths.group_deg(g) + schedule.rate_deg_per_s * seconds(into_group);
        sequence.azimuth_deg = azimuth < 360 ? azimuth : azimuth - 360;
        frames_.find_frame(sequence, time + sequence.in_packet, clock_, out);
        for (std::size_t echo = 0; echo < layout.echoes; ++echo) {
          sequence.echo = static_cast<std::uint8_t>(echo);
          for (std::size_t bank = 0; bank < layout.banks; ++bank) {
            sequence.blocks[bank] = layout.block[g][echo][bank];
            sequence.slots[bank] = slots_of(view, layout, g, echo, bank) + s * row_.lasers * 3;
          }
          frames_.append(sequence);
        }
      }
    }
    frames_.end_packet();
    order_.set_turn_rate(turn_rate());
  }

  /// `into_block`: from the first to the last sequence of a block.
  void begin_packet(const OrderedPacket& packet, Span time, const FiringSchedule& schedule, Span into_block) {
    const PacketAzimuths& azimuths = packet.azimuths;
    const double turn = schedule.rate_deg_per_s * seconds(into_block);
    const std::size_t last = azimuths.groups - 1;
    bool even = turn >= 0 && azimuths.hidden_total_deg <= 0 && azimuths.group_deg(last) + turn < 360;
    for (std::size_t g = 0; g < last && even; ++g)
      even = azimuths.group_deg(g) + turn <= azimuths.group_deg(g + 1);
    if (!even) return frames_.begin_packet();
    frames_.begin_even_packet(azimuths.group_deg(0), azimuths.group_deg(last) + turn,
                              time + schedule.begin[0], time + schedule.begin[last] + into_block);
  }

  void set_timing(const Timing& timing, bool decided) {
    order_.set_timing(timing, decided);
    if (timing_in_force_ == &timing) return;
    timing_in_force_ = &timing;
    frames_.unpacker().set_timing(timing);
  }

  void measure_turn(double azimuth_deg, Span step) {
    // Long compared with the resolution of stamps and azimuths, short enough to follow the motor.
    constexpr double window_s = 0.2;
    constexpr Span longest_step = std::chrono::milliseconds(40);  // below one turn at 1200 rpm
    if (step <= Span(0) || step > longest_step) return;
    turned_deg_ += std::fmod(azimuth_deg - last_azimuth_deg_ + 360.5, 360) - 0.5;
    turned_s_ += seconds(step);
    if (turned_s_ < window_s) return;
    turned_deg_ /= 2;
    turned_s_ /= 2;
  }

  /// Rotation over the last packets, deg/s; 0 unknown.
  double turn_rate() const { return turned_s_ > 0 ? plausible_rate(turned_deg_ / turned_s_) : 0; }

  /// The rotation over full turns, from one begin of the hidden sector to the next, for the duration of the
  /// sector.
  double rate_over_turn(const PacketAzimuths& azimuths, Span time) {
    const double usual = turn_rate();
    if (azimuths.hidden_total_deg <= 0) return usual;
    std::size_t g = 1;
    while (azimuths.hidden_deg[g] <= 0) ++g;
    const auto sequences = static_cast<int>((g - 1) * row_.sequences_per_block());
    const Span begin = time + timing_.timing().sequence * sequences;
    const double azimuth = azimuths.group_deg(g - 1);
    const auto before = std::exchange(edge_, std::make_pair(begin, azimuth));
    if (!before) return usual;
    const double elapsed = seconds(begin - before->first);
    const double beyond = std::remainder(azimuth - before->second, 360);
    const double turns = std::round((usual * elapsed - beyond) / 360);
    constexpr double recent_turns = 3;
    return turns < 1 || turns > recent_turns ? usual : plausible_rate((360 * turns + beyond) / elapsed);
  }

  /// Reads the last two bytes: state and calibration of an HDL-64E, which has no product byte.
  void read_status(const DataPacket& packet) {
    status_.add(packet.mode(), packet.product());
    if (status_.calibration() == sent_) return;
    sent_ = status_.calibration();
    if (config_.calibration == nullptr) frames_.set_calibration(sent_);
    describe_status();
  }

  void note_dialogue() {
    if (!web_->changed()) return;
    const DeviceInfo& found = web_->info();
    info_.serial = found.serial;
    for (const auto& [key, value] : found.details) info_.set(key, value);
    const std::string warning = found.warnings.empty() ? "" : found.warnings.front();
    info_.replace_warning(std::exchange(settings_warning_, warning), warning);
  }

  void describe_status() {
    if (!row_.has_status()) return;
    const char* source = config_.calibration != nullptr ? "file"
                         : sent_ != nullptr             ? "sent by the sensor"
                                            : "that of another sensor, until the sensor sends its own";
    info_.set("calibration", source);
    for (const auto& [key, value] : hdl64_details(status_.info())) info_.set(key, value);
    info_.warnings = hdl64_warnings(status_.info());
  }

  const ModelRow& row_;
  PacketOrder order_;
  TwoStreams streams_;
  const std::string another_ = "another " + std::string(config_.model->product);
  std::string other_product_;
  ArrivalStamps arrival_stamps_;
  TimingChooser timing_;
  RawPacketCollector raw_;
  CloudBuilder frames_;
  DeviceClock clock_;
  TelemetryReceiver telemetry_;
  std::optional<WebDialogue> web_;
  std::string settings_warning_;  // of the last comparison
  Hdl64Status status_;
  std::shared_ptr<const Calibration> sent_;  // by the sensor, in the last two bytes of its packets
  Stamp described_{};
  const Timing* timing_in_force_ = nullptr;
  OrderedPacket incoming_{};
  OrderedPacket waiting_{};  // until the next packet gives its times
  Span waiting_time_{0};
  bool pending_ = false;
  bool in_stream_ = false;
  Span last_time_{0};
  std::size_t last_echoes_ = 1;
  std::uint64_t known_steps_ = 0;  // of the sensor's clock
  double last_azimuth_deg_ = 0;
  double turned_deg_ = 0, turned_s_ = 0;
  std::optional<std::pair<Span, double>>
      edge_;  // when the last hidden sector inside a packet began, and where
};

}  // namespace

std::unique_ptr<Driver> make_driver(const DriverConfig& config) {
  return std::make_unique<VelodyneDriver>(config);
}

}  // namespace lidard::velodyne
