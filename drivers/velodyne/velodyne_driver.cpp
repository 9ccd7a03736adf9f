// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/velodyne_driver.h"

#include <algorithm>
#include <cstring>

#include "core/revolution.h"
#include "drivers/model.h"
#include "drivers/velodyne/azimuth.h"
#include "drivers/velodyne/packet.h"
#include "drivers/velodyne/packet_order.h"
#include "drivers/velodyne/unpacker.h"

namespace lidard::velodyne {
namespace {

constexpr double deg_per_rad = 180 / 3.14159265358979323846;

Reject check_blocks(const DataPacket& packet) {
  for (std::size_t b = 0; b < blocks_per_packet; ++b) {
    if (packet.flag(b) != flag_lasers_0_31) return Reject::magic;
    if (packet.azimuth(b) >= azimuth_limit) return Reject::field;
  }
  return Reject::none;
}

class VelodyneDriver final : public Driver {
 public:
  explicit VelodyneDriver(const DriverConfig& config)
      : config_(config),
        row_(*static_cast<const ModelRow*>(config.model->row)),
        order_(row_, counters_),
        unpacker_(row_, config.keep_origins),
        cutter_(config.cut_angle * deg_per_rad),
        clock_(config.clock) {
    cloud_.frame_id = config.frame_id;
    cloud_.rings = static_cast<std::uint16_t>(row_.lasers);
    info_.details = {{"Vendor Name", "Velodyne"}, {"Product Name", std::string(config.model->product)}};
  }

  Reject receive(const Packet& packet, DriverOutput& out) override;
  void finish(DriverOutput& out) override {
    order_.flush([&](const OrderedPacket& p, Span time) { decode(p, time, out); });
    end_frame(false, out);
    cutter_.reset();
  }
  void restart() override {
    order_.reset();
    cutter_.reset();
    clock_.reset();
    cloud_.columns.clear();
    in_stream_ = false;
  }
  const Counters& counters() const override { return counters_; }
  const DeviceInfo& info() const override { return info_; }

 private:
  void decode(const OrderedPacket& packet, Span time, DriverOutput& out);
  void place(Sequence& sequence, Span time, DriverOutput& out);
  void begin_frame(Span time, bool at_cut);
  void end_frame(bool at_cut, DriverOutput& out);
  void note_product();

  DriverConfig config_;
  const ModelRow& row_;
  Counters counters_;
  DeviceInfo info_;
  PacketOrder order_;
  Unpacker unpacker_;
  RevolutionCutter cutter_;
  DeviceClock clock_;
  OrderedPacket incoming_{};

  Cloud cloud_;
  std::size_t points_ = 0;
  bool in_stream_ = false;
  bool began_at_cut_ = false;
  Span frame_time_{0};
  Span last_time_{0};
  Stamp last_stamp_{};
  std::uint8_t told_product_ = 0;
  std::size_t echoes_ = 1;
};

Reject VelodyneDriver::receive(const Packet& packet, DriverOutput& out) {
  if (packet.payload.size() == position_packet_size) {
    ++counters_.other_packets;
    return Reject::none;
  }
  incoming_.index = static_cast<std::uint32_t>(counters_.packets++);
  counters_.bytes += packet.payload.size();
  const Reject reason =
      packet.payload.size() == packet_size ? check_blocks(DataPacket(packet.payload)) : Reject::size;
  if (reason != Reject::none) {
    counters_.reject(reason);
    return reason;
  }
  std::memcpy(incoming_.bytes.data(), packet.payload.data(), packet_size);
  incoming_.arrival = packet.arrival;
  incoming_.other_product = incoming_.view().product() != row_.product_id;
  const Reject verdict =
      order_.add(incoming_, [&](const OrderedPacket& p, Span time) { decode(p, time, out); });
  if (incoming_.other_product) note_product();
  return verdict;
}

void VelodyneDriver::note_product() {
  const std::uint8_t product = incoming_.view().product();
  if (product == told_product_) return;
  const std::string says = "packets name " + product_name(product) + " as their product, configured is " +
                           std::string(config_.model->product);
  if (product == order_.lying_product()) {
    info_.warnings.push_back(says +
                             "; their period is that of the configured model, so they are decoded as it");
  } else if (product == order_.refused_product()) {
    info_.warnings.push_back(
        says + "; they are refused: correct `model`, or `ip_address` if two sensors share the port");
  } else {
    return;
  }
  told_product_ = product;
}

void VelodyneDriver::decode(const OrderedPacket& packet, Span time, DriverOutput& out) {
  const DataPacket view = packet.view();
  // A jump of the device clock cannot lie inside a frame: times within it are differences.
  constexpr Span jump = std::chrono::seconds(5);
  if (in_stream_ && (time < last_time_ || time - last_time_ > jump)) {
    end_frame(false, out);
    cutter_.reset();
    clock_.reset();
  }
  last_time_ = time;
  echoes_ = is_dual(view) ? 2 : 1;
  // The packet leaves after its last firing sequence.
  clock_.observe(time + row_.packet_period(echoes_), packet.arrival);

  const PacketAzimuths azimuths = read_azimuths(view, echoes_);
  const std::size_t per_block = row_.sequences_per_block();
  const Span group_time = row_.sequence_time * static_cast<int>(per_block);
  const double rate = azimuths.step_deg / seconds(group_time);
  unpacker_.set_rate(rate);
  unpacker_.reserve_packet(cloud_);
  Sequence sequence{};
  sequence.packet = packet.index;
  for (std::size_t g = 0; g < azimuths.groups; ++g) {
    for (std::size_t s = 0; s < per_block; ++s) {
      sequence.in_packet = row_.sequence_time * static_cast<int>(g * per_block + s);
      const double azimuth =
          azimuths.group_deg[g] + rate * seconds(row_.sequence_time) * static_cast<double>(s);
      sequence.azimuth_deg = azimuth < 360 ? azimuth : azimuth - 360;
      place(sequence, time + sequence.in_packet, out);
      for (std::size_t echo = 0; echo < echoes_; ++echo) {
        const std::size_t block = g * echoes_ + echo;
        sequence.block = static_cast<std::uint8_t>(block);
        sequence.echo = static_cast<std::uint8_t>(echo);
        sequence.slots = view.slots(block) + s * row_.lasers * 3;
        unpacker_.append(sequence, cloud_, points_);
      }
    }
  }
}

/// Finds the frame the sequence belongs to, and its times.
void VelodyneDriver::place(Sequence& sequence, Span time, DriverOutput& out) {
  const auto verdict = cutter_.next(sequence.azimuth_deg, time);
  if (!in_stream_) {
    begin_frame(time, false);
  } else if (verdict != RevolutionCutter::Verdict::same) {
    const bool at_cut = verdict == RevolutionCutter::Verdict::crossed;
    end_frame(at_cut, out);
    begin_frame(time, at_cut);
  }
  sequence.in_frame = time - frame_time_;
  sequence.stamp = clock_.to_host(time) + config_.time_offset;
}

void VelodyneDriver::begin_frame(Span time, bool at_cut) {
  in_stream_ = true;
  began_at_cut_ = at_cut;
  frame_time_ = time;
  cloud_.columns.clear();
  cloud_.origins.clear();
  points_ = 0;
  unpacker_.reserve_packet(cloud_);
  const Stamp stamp = clock_.to_host(time) + config_.time_offset;
  cloud_.stamp = std::max(stamp, last_stamp_ + Span(1));
}

void VelodyneDriver::end_frame(bool at_cut, DriverOutput& out) {
  if (!in_stream_) return;
  in_stream_ = false;
  if (cloud_.columns.empty()) return;
  cloud_.complete = began_at_cut_ && at_cut;
  if (!cloud_.complete && !config_.keep_partial) {
    ++counters_.partial_frames;
    return;
  }
  cloud_.end = cloud_.columns.back().stamp;
  cloud_.expected_columns = static_cast<std::size_t>(cutter_.period() / row_.sequence_time) * echoes_;
  cloud_.points_bytes.resize(points_ * sizeof(CloudPoint));
  last_stamp_ = cloud_.stamp;
  ++counters_.frames;
  out.cloud(cloud_);
}

}  // namespace

std::unique_ptr<Driver> make_driver(const DriverConfig& config) {
  return std::make_unique<VelodyneDriver>(config);
}

}  // namespace lidard::velodyne
