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
#include "drivers/velodyne/packet_stream.h"
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
        stream_(row_, counters_),
        arrival_stamps_(row_),
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
    return {true, stream_.add(incoming_, [&](const auto& p, const auto& next) { decode(p, next, out); }),
            device};
  }

  void finish(FrameReceiver& out) override {
    stream_.flush([&](const auto& p, const auto& next) { decode(p, next, out); });
    frames_.cut_off(out);
    raw_.publish(out);
    describe_status();
  }
  void restart() override {
    stream_.reset();
    arrival_stamps_.reset();
    status_.restart();
    raw_.clear();
    frames_.reset();
    clock_.reset();
    telemetry_.restart();
  }
  void connected(Stamp now, FrameReceiver& out) override {
    if (web_) web_->connected(now, out);
  }
  void disconnected() override {
    if (web_) web_->disconnected();
  }
  void tick(Stamp now, FrameReceiver& out) override {
    telemetry_.tick(now, info_);
    describe_clock(clock_, stream_.wraps(), now);
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

  void decode(const OrderedPacket& packet, const std::optional<NextPacket>& next, FrameReceiver& out) {
    const DataPacket view = packet.view();
    if (row_.has_status()) read_status(view);
    if (packet.begins_anew) {
      frames_.cut_off(out);
      clock_.restart();
    }
    set_timing(stream_.timing());
    const PacketLayout& layout = *packet.layout;
    const PacketAzimuths& azimuths = packet.azimuths;
    const FiringSchedule schedule = schedule_of(row_, stream_.timing(), stream_.measured_sequence(), azimuths,
                                                layout.echoes, next, stream_.turn_rate(packet));
    // The packet is sent after its last firing sequence.
    clock_.observe(packet.time + schedule.end, packet.arrival);

    frames_.unpacker().set_rate(schedule.rate_deg_per_s);
    frames_.set_echoes(layout.echoes);
    const std::size_t per_block = row_.sequences_per_block();
    begin_packet(packet, schedule, schedule.sequence * static_cast<int>(per_block - 1));
    Sequence sequence{};
    sequence.packet = packet.index;
    for (std::size_t g = 0; g < layout.groups; ++g) {
      for (std::size_t s = 0; s < per_block; ++s) {
        const Span into_group = schedule.sequence * static_cast<int>(s);
        sequence.in_packet = schedule.begin[g] + into_group;
        const double azimuth = azimuths.group_deg(g) + schedule.rate_deg_per_s * seconds(into_group);
        sequence.azimuth_deg = azimuth < 360 ? azimuth : azimuth - 360;
        frames_.find_frame(sequence, packet.time + sequence.in_packet, clock_, out);
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
  }

  /// `into_block`: from the first to the last sequence of a block.
  void begin_packet(const OrderedPacket& packet, const FiringSchedule& schedule, Span into_block) {
    const PacketAzimuths& azimuths = packet.azimuths;
    const double turn = schedule.rate_deg_per_s * seconds(into_block);
    const std::size_t last = azimuths.groups - 1;
    bool even = turn >= 0 && azimuths.hidden_total_deg <= 0 && azimuths.group_deg(last) + turn < 360;
    for (std::size_t g = 0; g < last && even; ++g)
      even = azimuths.group_deg(g) + turn <= azimuths.group_deg(g + 1);
    if (!even) return frames_.begin_packet();
    frames_.begin_even_packet(azimuths.group_deg(0), azimuths.group_deg(last) + turn,
                              packet.time + schedule.begin[0],
                              packet.time + schedule.begin[last] + into_block);
  }

  void set_timing(const Timing& timing) {
    if (std::exchange(timing_in_force_, &timing) != &timing) frames_.unpacker().set_timing(timing);
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
  PacketStream stream_;
  TwoStreams streams_;
  const std::string another_ = "another " + std::string(config_.model->product);
  std::string other_product_;
  ArrivalStamps arrival_stamps_;
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
};

}  // namespace

std::unique_ptr<Driver> make_driver(const DriverConfig& config) {
  return std::make_unique<VelodyneDriver>(config);
}

}  // namespace lidard::velodyne
