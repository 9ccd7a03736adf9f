// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <cmath>

#include "drivers/dialogue.h"
#include "drivers/driver_base.h"
#include "drivers/sick/compact/compact_models.h"
#include "drivers/sick/compact/compact_telegram.h"
#include "drivers/sick/compact/frame_builder.h"

namespace lidard::sick {
namespace {

/// After this silence another device is accepted.
constexpr Span silence = std::chrono::seconds(1);
/// A warning of another device that sends to the same port stays for so long.
constexpr Span rival_memory = std::chrono::seconds(10);
/// Device times farther apart are from two clocks, or a clock was set.
constexpr std::uint64_t one_clock_us = 2'000'000;
/// A frame is closed this long after its last segment was due.
constexpr Span deadline_slack = std::chrono::milliseconds(10);

class CompactDriver final : public DriverBase {
 public:
  explicit CompactDriver(const DriverConfig& config)
      : DriverBase(config),
        clock_(config.clock),
        side_clock_(config.clock),
        warnings_(info_),
        dialogue_(config.model->dialogue_port != 0 ? make_sopas_dialogue(config) : nullptr) {
    builder_ = config.model->kind == FrameKind::cloud ? make_cloud_builder(config_, clock_)
                                                      : make_scan_builder(config_, clock_, warnings_);
    imu_->frame_id = config.frame_id;
    encoder_->topic = "encoder";
    encoder_->frame_id = config.frame_id;
    encoder_->values = {
        {"frame", 0}, {"ticks", 0}, {"speed", 0}, {"ticks at reference 1", 0}, {"ticks at reference 2", 0}};
  }

  Verdict receive(const Packet& packet, FrameReceiver& out) override {
    if (packet.transport == Transport::udp) return receive_datagram(packet, out);
    if (!dialogue_) {
      if (!clock_.ready()) find_newest(packet);
      return read_stream<Telegram>(
          packet, stream_, [&](const Telegram& telegram) { return handle(telegram, packet.arrival, out); });
    }
    dialogue_->receive(packet, out);
    note_dialogue();
    return {};
  }

  void connected(Stamp now, FrameReceiver& out) override {
    if (dialogue_) dialogue_->connected(now, out);
  }
  void disconnected() override {
    stream_.interrupt();
    if (dialogue_) dialogue_->disconnected();
  }

  /// Closes a frame whose last segment was lost without waiting for the next frame.
  void tick(Stamp now, FrameReceiver& out) override {
    describe_clock(clock_, 0, now);
    if (dialogue_) {
      const bool heard = last_stop_us_ != 0;
      dialogue_->tick(now, heard ? std::optional<Stamp>(last_arrival_) : std::nullopt, out);
      note_dialogue();
    }
    if (frames_.expected() == 0 || last_stop_us_ == 0) return;
    const Span period = span_from_seconds(config_.model->frame_period);
    if (now - last_arrival_ < period + deadline_slack) return;
    flush(out, false);
  }

  const DeviceClock* clock() const override { return &clock_; }
  void finish(FrameReceiver& out) override { flush(out, true); }

  void restart() override {
    stream_.interrupt();
    order_.reset();
    frames_.restart();
    builder_->restart();
    clock_.reset();
    side_clock_.reset();
    first_frame_ = true;
    sender_known_ = false;
    last_stop_us_ = 0;
    last_arrival_ = Stamp();
  }

 private:
  /// The clock begins with the newest segment of the first read.
  void find_newest(const Packet& packet) {
    std::uint64_t newest_us = 0;
    look_ahead<Telegram>(packet, stream_, [&](const Telegram& telegram) {
      if (parse_scan(telegram, segment_) == Reject::none) newest_us = segment_.stop_us();
    });
    if (newest_us != 0) clock_.observe(device_span(newest_us), packet.arrival);
  }

  void note_dialogue() {
    if (!dialogue_->changed()) return;
    warnings_.lead(dialogue_->info().warnings);
    for (const auto& [key, value] : dialogue_->info().details) info_.set(key, value);
  }

  Verdict receive_datagram(const Packet& packet, FrameReceiver& out) {
    counters_.bytes += packet.payload.size();
    ByteView rest = packet.payload;
    Verdict all;
    do {
      const TelegramHead head = read_head(rest);
      const bool known = head.type <= TelegramType::imu || head.type == TelegramType::encoder;
      if (!known) {
        // Other telegrams are not used.
        ++counters_.other_packets;
        return all;
      }
      Reject reason = head.reject;
      if (reason == Reject::none && (head.length == 0 || head.length > rest.size())) reason = Reject::size;
      if (reason == Reject::none && !checksum_is_right(rest.sub(0, head.length), head.type))
        reason = Reject::checksum;
      if (reason != Reject::none) {
        ++counters_.packets;
        include_verdict({true, reason}, all);
        return all;
      }
      include_verdict(handle({rest.sub(0, head.length), head.type}, packet.arrival, out), all);
      rest = rest.from(head.length);
    } while (!rest.empty());
    return all;
  }

  Verdict handle(const Telegram& telegram, Stamp arrival, FrameReceiver& out) {
    const TelegramType type = telegram.type;
    if (type == TelegramType::scan || type == TelegramType::msgpack) {
      ++counters_.packets;
      const Reject reason = handle_scan(telegram, arrival, out);
      return {true, reason, device_named("device ", reason == Reject::none ? segment_.sender : 0)};
    }
    ++counters_.other_packets;
    if (type == TelegramType::imu) return {false, handle_imu(telegram.bytes, arrival, out)};
    if (type == TelegramType::encoder) return {false, handle_encoder(telegram.bytes, arrival, out)};
    return {};
  }

  Reject handle_scan(const Telegram& telegram, Stamp arrival, FrameReceiver& out) {
    const Reject reason = parse_scan(telegram, segment_);
    if (reason != Reject::none) return reason;
    if (!is_ours(segment_.sender, arrival)) {
      ++counters_.other_packets;
      return Reject::none;
    }
    const Reject fit = builder_->check(segment_);
    if (fit != Reject::none) return fit;
    const auto order = order_.add(segment_.counter, counters_);
    if (order == TelegramOrder::Verdict::duplicate) return Reject::duplicate;
    const std::uint64_t stop_us = segment_.stop_us();
    // A telegram that is late may be as old; the next one is older only if the clock was set.
    const std::uint64_t disorder_us = order == TelegramOrder::Verdict::next ? 20'000 : one_clock_us;
    const bool jumped = last_stop_us_ != 0 && (stop_us + disorder_us < last_stop_us_ ||
                                               stop_us > last_stop_us_ + 3600 * one_clock_us);
    if (order == TelegramOrder::Verdict::restart || jumped || frames_.counts_anew(segment_)) {
      begin_stream(out);
      if (jumped) {
        clock_.restart();
        ++clock_restarts_;
        last_stop_us_ = 0;
      }
    }
    describe_format();
    return handle_segment(arrival, out);
  }

  Reject handle_segment(Stamp arrival, FrameReceiver& out) {
    const std::uint64_t stop_us = segment_.stop_us();
    clock_.observe(device_span(stop_us), arrival);
    counters_.clock_steps = clock_.steps() + clock_restarts_;
    if (stop_us > last_stop_us_) {
      last_stop_us_ = stop_us;
      last_arrival_ = arrival;
    }
    if (!adopted_ || !builder_->continues(segment_)) {
      flush(out, true);
      frames_.reset();
      first_frame_ = true;
      builder_->adopt(segment_);
      adopted_ = builder_->continues(segment_);
      if (!adopted_) return Reject::field;
    }
    std::size_t slot = 0;
    const auto release = [&](std::size_t done) { end_frame(done, false, out); };
    const Reject reason = frames_.assign(segment_, slot, release);
    if (reason != Reject::none) return reason;
    if (frames_.frame(slot).telegrams == 1) builder_->begin(slot);
    builder_->add(slot, segment_, static_cast<std::uint32_t>(counters_.packets - 1));
    frames_.settle(release);
    return Reject::none;
  }

  Reject handle_imu(ByteView telegram, Stamp arrival, FrameReceiver& out) {
    ImuTelegram read;
    const Reject reason = parse_imu(telegram, read);
    if (reason != Reject::none) return reason;
    if (read.time_us > latest_device_us) return Reject::field;
    imu_->stamp = stamp_of(read.time_us, arrival);
    set_imu(read.acceleration, read.angular_velocity, read.orientation, imu_);
    out.message(imu_);
    return Reject::none;
  }

  Reject handle_encoder(ByteView telegram, Stamp arrival, FrameReceiver& out) {
    EncoderTelegram read;
    const Reject reason = parse_encoder(telegram, read);
    if (reason != Reject::none) return reason;
    if (read.transmit_us > latest_device_us) return Reject::field;
    // In public telegrams of a picoScan150 the time of the tick lacks its upper half, which is that of the
    // nearby time of transmission.
    constexpr std::uint64_t half = 0xffffffffU;
    auto apart =
        static_cast<std::int32_t>(static_cast<std::uint32_t>((read.tick_us - read.transmit_us) & half));
    if (apart < 0 && static_cast<std::uint64_t>(-static_cast<std::int64_t>(apart)) > read.transmit_us)
      apart = 0;
    const std::uint64_t us = read.transmit_us + static_cast<std::uint64_t>(static_cast<std::int64_t>(apart));
    encoder_->stamp = stamp_of(us, arrival);
    encoder_->values[0].value = static_cast<double>(read.frame);
    encoder_->values[1].value = read.ticks;
    encoder_->values[2].value = read.speed;
    encoder_->values[3].value = read.reference_ticks[0];
    encoder_->values[4].value = read.reference_ticks[1];
    if (config_.model->sends<DeviceState>()) out.message(encoder_);
    return Reject::none;
  }

  bool is_ours(std::uint32_t sender, Stamp arrival) {
    if (sender_known_ && sender == sender_) {
      if (rival_at_ && std::chrono::abs(arrival - *rival_at_) > rival_memory) {
        warnings_.clear(SegmentTrouble::other_device);
        rival_at_.reset();
      }
      return true;
    }
    if (sender_known_ && std::chrono::abs(arrival - last_arrival_) <= silence) {
      if (!rival_at_)
        warnings_.set(SegmentTrouble::other_device,
                      "device " + std::to_string(sender) + " sends to the same place as device " +
                          std::to_string(sender_) + " and is ignored; set ip_address of both");
      rival_at_ = arrival;
      return false;
    }
    if (sender_known_) {
      warnings_.set(SegmentTrouble::other_device, "device " + std::to_string(sender_) +
                                                      " was replaced by device " + std::to_string(sender) +
                                                      "; check its pose");
      clock_.reset();
    }
    sender_known_ = true;
    sender_ = sender;
    rival_at_.reset();
    order_.reset();
    frames_.restart();
    first_frame_ = true;
    last_stop_us_ = 0;
    // MSGPACK of older firmware has no serial number.
    if (sender != 0) info_.serial = std::to_string(sender);
    return true;
  }

  /// Restarts the stream: the device was switched on, or its counters start again.
  void begin_stream(FrameReceiver& out) {
    flush(out, true);
    frames_.restart();
    first_frame_ = true;
  }

  void flush(FrameReceiver& out, bool torn) {
    while (frames_.release_oldest([&](std::size_t slot) { end_frame(slot, torn, out); })) {
    }
  }

  void end_frame(std::size_t slot, bool torn, FrameReceiver& out) {
    const OpenFrames::Frame& frame = frames_.frame(slot);
    FrameEnd how;
    how.segments = frame.segments;
    how.expected = frames_.expected();
    how.torn = (torn || first_frame_) && !how.complete();
    first_frame_ = false;
    if (builder_->end(slot, how, out))
      ++counters_.frames;
    else
      ++counters_.partial_frames;
  }

  void describe_format() {
    if (segment_.version == described_version_) return;
    described_version_ = segment_.version;
    info_.set("Scan Data Format",
              described_version_ == 0 ? "MSGPACK" : "Compact, version " + std::to_string(described_version_));
  }

  /// Host time of a sample of an inertial unit or encoder. It uses the clock of the scans, or its own clock
  /// if there are no scans or the times differ.
  Stamp stamp_of(std::uint64_t us, Stamp arrival) {
    const std::uint64_t apart = us > last_stop_us_ ? us - last_stop_us_ : last_stop_us_ - us;
    const bool is_common = clock_.ready() && apart < one_clock_us;
    if (!is_common) side_clock_.observe(device_span(us), arrival);
    const DeviceClock& clock = is_common ? clock_ : side_clock_;
    const Stamp stamp = clock.to_host(device_span(us));
    return (clock.is_held() ? stamp : std::min(stamp, arrival)) + config_.time_offset;
  }

  DeviceClock clock_;
  DeviceClock side_clock_;  // of inertial unit and encoder, if their times differ from those of scans
  SegmentWarnings warnings_;
  std::unique_ptr<SideDialogue> dialogue_;  // of a device that uses TCP only for settings
  Segment segment_;
  TelegramStream stream_{counters_};
  TelegramOrder order_;
  OpenFrames frames_;
  std::unique_ptr<FrameBuilder> builder_;
  bool adopted_ = false;
  bool first_frame_ = true;  // the begin of the stream's first frame may be missing
  std::uint64_t clock_restarts_ = 0;
  std::uint64_t last_stop_us_ = 0;
  Stamp last_arrival_;
  std::optional<Stamp> rival_at_;  // arrival of a scan of another device
  bool sender_known_ = false;
  std::uint32_t sender_ = 0;
  std::uint32_t described_version_ = ~0U;
  ReusedMessage<ImuSample> imu_;
  ReusedMessage<DeviceState> encoder_;
};

}  // namespace

std::unique_ptr<Driver> make_compact_driver(const DriverConfig& config) {
  return std::make_unique<CompactDriver>(config);
}

}  // namespace lidard::sick
