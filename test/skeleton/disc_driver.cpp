// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/skeleton/disc_driver.h"

#include <string>

#include "drivers/driver_base.h"

namespace lidard::acme {
namespace {

/// Datagrams so little behind the newest were overtaken. Farther back the device began to count anew.
constexpr std::int32_t overtaking_limit = 16;
/// Datagrams that may be missing although no time has passed for them, since a host may stall.
constexpr std::int64_t loss_without_time = 100;

bool is_disc(ByteView bytes) { return bytes.size() >= 4 && bytes.sub(0, 4).text() == "DISC"; }

enum class Warning : std::uint8_t { dirty, no_beams_left, count_ };

class DiscDriver final : public DriverBase {
 public:
  explicit DiscDriver(const DriverConfig& config);

  Verdict receive(const Packet& packet, FrameReceiver& out) override;
  void finish(FrameReceiver&) override { give_up_scan(); }
  void restart() override;

 private:
  Reject use(const Packet& packet, FrameReceiver& out);
  Reject follow(std::size_t part, std::uint32_t scan, Stamp arrival);
  void begin_scan(std::uint32_t scan, std::uint32_t device_us);
  void give_up_scan();
  void place_beams(ByteView bytes, std::size_t part);
  void publish(FrameReceiver& out);

  WarningBoard<Warning> board_{info_};
  DeviceClock clock_;
  SteadyStamps stamps_;
  PlanarScan scan_;
  std::size_t first_beam_ = 0;    // the first that the configured angles leave
  std::size_t parts_placed_ = 0;  // of scan_; 0: none is begun

  bool started_ = false;
  std::uint32_t number_ = 0;  // of the newest datagram, counted through all scans
  Stamp arrival_;
  std::uint32_t scan_number_ = 0, device_us_ = 0;
  Span device_{0};  // device time of the scan's first beam, unwrapped
};

DiscDriver::DiscDriver(const DriverConfig& config) : DriverBase(config), clock_(config.clock) {
  prepare_scan(config, scan_);
  scan_.scan_time = static_cast<float>(seconds(disc::turn));
  scan_.time_increment = static_cast<float>(seconds(disc::beam));
  first_beam_ =
      choose_beams(config, disc::first_deg * rad_per_deg, disc::step_deg * rad_per_deg, disc::beams, scan_)
          .first;
  board_.update(Warning::no_beams_left, scan_.beams == 0, [] {
    return "no beam lies between angle_min and angle_max, the scanner measures from -135 to 134.625 deg; "
           "correct the angles in the configuration";
  });
}

Verdict DiscDriver::receive(const Packet& packet, FrameReceiver& out) {
  ++counters_.packets;
  counters_.bytes += packet.payload.size();
  const Reject reason = use(packet, out);
  if (reason != Reject::none) counters_.reject(reason);
  return {true, reason};
}

Reject DiscDriver::use(const Packet& packet, FrameReceiver& out) {
  const ByteView bytes = packet.payload;
  if (!is_disc(bytes)) return Reject::magic;
  if (bytes.size() != disc::packet_size) return Reject::size;
  if (bytes.u8(4) != 1) return Reject::version;
  const std::size_t part = bytes.u8(5);
  if (part >= disc::parts) return Reject::field;
  const std::uint32_t scan = bytes.le16(6);
  const Reject order = follow(part, scan, packet.arrival);
  if (order != Reject::none) return order;

  if (info_.serial.empty()) info_.serial = std::to_string(bytes.le32(8));
  board_.update(Warning::dirty, (bytes.le16(16) & 1U) != 0,
                [] { return "the scanner says that its window is dirty; clean it, or beams end too early"; });
  if (parts_placed_ == 0 || scan != scan_number_) begin_scan(scan, bytes.le32(12));
  clock_.observe(device_ + disc::beam * static_cast<int>((part + 1) * disc::beams_of_part), packet.arrival);
  counters_.clock_steps = clock_.steps();
  place_beams(bytes, part);
  ++parts_placed_;
  if (part + 1 == disc::parts) publish(out);
  return Reject::none;
}

/// Counts what is missing before this datagram. The scan's number and the part are one number that overflows.
Reject DiscDriver::follow(std::size_t part, std::uint32_t scan, Stamp arrival) {
  constexpr unsigned unused_bits = 32 - 16 - 2;  // 16 bits count scans, 2 their parts
  const std::uint32_t number = static_cast<std::uint32_t>(scan * disc::parts + part) << unused_bits;
  const std::int32_t ahead = static_cast<std::int32_t>(number - number_) >> unused_bits;
  if (started_ && ahead == 0) return Reject::duplicate;
  if (started_ && ahead < 0 && ahead >= -overtaking_limit) {
    ++counters_.reordered;
    return Reject::stale;
  }
  // A number that the time does not explain is that of a device that was switched off and on.
  const std::int64_t due = std::chrono::abs(arrival - arrival_) / (disc::turn / disc::parts);
  if (started_ && ahead > 1 && ahead - 1 <= due + loss_without_time)
    counters_.lost_packets += static_cast<std::uint64_t>(ahead - 1);
  started_ = true;
  number_ = number;
  arrival_ = arrival;
  return Reject::none;
}

void DiscDriver::begin_scan(std::uint32_t scan, std::uint32_t device_us) {
  give_up_scan();
  scan_number_ = scan;
  // The difference is signed, so that the overflow of the counter is a small step forward.
  device_ += std::chrono::microseconds(static_cast<std::int32_t>(device_us - device_us_));
  device_us_ = device_us;
  scan_.reset(scan_.beams, 1, false);
}

/// A scan with a hole would say "not observed" where something may be: it is counted and dropped.
void DiscDriver::give_up_scan() {
  if (parts_placed_ > 0) ++counters_.partial_frames;
  parts_placed_ = 0;
}

void DiscDriver::place_beams(ByteView bytes, std::size_t part) {
  for (std::size_t i = 0; i < disc::beams_of_part; ++i) {
    const std::size_t beam = part * disc::beams_of_part + i - first_beam_;
    if (beam >= scan_.beams) continue;  // also those before the first one: the difference wraps
    const std::uint16_t distance = bytes.le16(disc::header_size + 2 * i);
    if (distance == disc::not_measured) continue;  // reset() made every beam `invalid`
    if (distance == disc::nothing)
      scan_.set_without_hit(beam, BeamStatus::none);
    else if (distance == disc::too_near)
      scan_.set_without_hit(beam, BeamStatus::near);
    else
      scan_.set_measured(beam, static_cast<float>(distance * 1e-3));
  }
}

void DiscDriver::publish(FrameReceiver& out) {
  if (parts_placed_ != disc::parts) return give_up_scan();
  parts_placed_ = 0;
  if (scan_.beams == 0) return;
  const Span first_ray = device_ + disc::beam * static_cast<int>(first_beam_);
  scan_.stamp = stamps_.next(clock_.to_host(first_ray) + config_.time_offset);
  ++counters_.frames;
  out.scan(scan_);
}

void DiscDriver::restart() {
  started_ = false;
  parts_placed_ = 0;
  clock_.reset();
  stamps_.reset();
}

/// Any datagram that begins like the protocol settles it.
class DiscRecognizer final : public Recognizer {
 public:
  void add(const Packet& packet) override {
    if (packet.transport == Transport::udp && is_disc(packet.payload)) name_ = "acme_disc270";
  }
  std::string_view verdict() const override { return name_; }

 private:
  std::string_view name_;
};

void append_models(std::vector<Model>& list) {
  Model model;
  model.name = "acme_disc270";
  model.vendor = "Acme";
  model.product = "Disc 270";
  model.protocol = "DISC";
  model.verified = "invented";
  model.port = disc::port;
  model.packets_per_s = disc::parts / seconds(disc::turn);
  model.frame_period = seconds(disc::turn);
  model.range_min = 0.05;
  model.range_max = 40;
  model.beams = disc::beams;
  model.make = [](const DriverConfig& config) -> std::unique_ptr<Driver> {
    return std::make_unique<DiscDriver>(config);
  };
  list.push_back(model);
}

}  // namespace

const Family disc_family = {
    append_models, []() -> std::unique_ptr<Recognizer> { return std::make_unique<DiscRecognizer>(); }};

}  // namespace lidard::acme
