// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/packet_mill.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "drivers/capture/pcap_source.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/packet.h"
#include "test/sim/devices/checksums.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::test {
namespace {

using velodyne::blocks_per_packet;

/// Sorted by protocol; what is for none of ours (a client's requests) is left out.
void take_apart(const std::string& path, std::vector<ProtocolPackets>& all) {
  std::map<std::string_view, ProtocolPackets> parts;
  PcapSource source(path);
  Packet packet;
  while (source.next(packet)) {
    const auto model = std::find_if(models().begin(), models().end(),
                                    [&packet](const Model& m) { return is_for(m, packet); });
    if (model == models().end()) continue;
    ProtocolPackets& part = parts[model->protocol];
    part.protocol = model->protocol;
    part.packets.push_back({{packet.payload.begin(), packet.payload.end()}, packet});
    part.packets.back().head.payload = ByteView();
  }
  for (auto& [protocol, part] : parts) all.push_back(std::move(part));
}

std::vector<ProtocolPackets> read_all() {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::directory_iterator(project_file("pcaps"))) {
    if (entry.path().extension() == ".pcap") paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());  // the order must not depend on the disk
  std::vector<ProtocolPackets> all;
  for (const std::string& path : paths) take_apart(path, all);
  return all;
}

/// Devices at one port are all tried with each other's packets; the two protocols of Compact telegrams are
/// one.
bool is_fit(const ProtocolPackets& parts, const Model& model) {
  const auto first_word = [](std::string_view text) { return text.substr(0, text.find(' ')); };
  return first_word(parts.protocol) == first_word(model.protocol) ||
         (model.vendor == "Hokuyo" && parts.packets.front().head.from.port == model.port);
}

void put(std::vector<std::uint8_t>& bytes, std::size_t at, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size && at + i < bytes.size(); ++i)
    bytes[at + i] = static_cast<std::uint8_t>(value >> 8 * i);
}

}  // namespace

const std::vector<ProtocolPackets>& all_parts() {
  static const std::vector<ProtocolPackets> all = read_all();
  return all;
}

PacketMill::PacketMill(const Model& model, std::uint64_t seed) : model_(model), rng_(seed) {
  std::vector<const ProtocolPackets*> fit;
  for (const ProtocolPackets& parts : all_parts()) {
    if (is_fit(parts, model)) fit.push_back(&parts);
  }
  if (fit.empty()) fit.push_back(&all_parts().front());
  main_ = fit[below(fit.size())];
  other_ = fit[below(fit.size())];
  // Most streams have few kinds of trouble, some a lot of one.
  for (double& chance : chance_) chance = 0.7 * std::pow(rng_.uniform(), 8);
  at_ = below(main_->packets.size());
}

const OwnPacket& PacketMill::choose() {
  const std::size_t size = main_->packets.size();
  if (is_due(foreign)) {
    const ProtocolPackets& parts = all_parts()[below(all_parts().size())];
    return parts.packets[below(parts.packets.size())];
  }
  if (is_due(neighbour)) return other_->packets[below(other_->packets.size())];
  if (is_due(old)) return main_->packets[(at_ + size - below(std::min<std::size_t>(size, 20))) % size];
  if (is_due(repeat)) return main_->packets[at_];
  at_ += 1 + (is_due(burst) ? 20 + below(56) : 0);
  if (at_ >= size) ++rounds_;
  at_ %= size;
  return main_->packets[at_];
}

/// A capture that begins again goes on in time, or all of it would be stale.
void PacketMill::restamp() {
  if (bytes_.size() != velodyne::packet_size || rounds_ == 0) return;
  const auto stamp_of = [](const OwnPacket& p) {
    return p.bytes.size() == velodyne::packet_size
               ? velodyne::DataPacket({p.bytes.data(), p.bytes.size()}).stamp_us()
               : 0U;
  };
  constexpr std::uint64_t hour_us = 3'600'000'000;
  const std::uint32_t first = stamp_of(main_->packets.front()), last = stamp_of(main_->packets.back());
  const std::uint64_t span = last > first ? last - first + 1000 : 100'000;
  const ByteView view(bytes_.data(), bytes_.size());
  put(bytes_, velodyne::stamp_offset, (view.le32(velodyne::stamp_offset) + rounds_ * span) % hour_us, 4);
}

/// Blocks that look the same way still do, so that a packet keeps its layout.
void PacketMill::scramble_velodyne() {
  if (bytes_.size() != velodyne::packet_size) return;
  constexpr std::uint32_t steps_us[] = {0, 1, 55, 100, 276, 553, 664, 1327, 1328, 2654, 20'000, 75'645};
  const std::uint64_t step = below(2) == 0 ? steps_us[below(std::size(steps_us))] : below(1U << below(25));
  scrambled_us_ += static_cast<std::uint32_t>(step);
  put(bytes_, velodyne::stamp_offset, below(50) == 0 ? rng_.bits() : scrambled_us_, 4);
  std::uint64_t azimuth = below(36001);
  const std::uint64_t turn = below(3) == 0 ? below(36000) : below(100);
  std::uint16_t before = 0xFFFF;
  for (std::size_t b = 0; b < blocks_per_packet; ++b) {
    const std::size_t at = b * velodyne::block_size + 2;
    const std::uint16_t sent = ByteView(bytes_.data(), bytes_.size()).le16(at);
    if (sent != before) azimuth = turn > 100 ? below(36001) : (azimuth + turn) % 36000;
    before = sent;
    if (sent != 0xFFFF) put(bytes_, at, azimuth, 2);  // a block without returns
  }
}

void PacketMill::damage() {
  if (is_due(scramble)) scramble_velodyne();
  if (bytes_.empty()) return;
  bool damaged = false;
  if (is_due(flip)) {
    for (std::uint64_t n = 1 + below(8); n > 0; --n)
      bytes_[below(bytes_.size())] = static_cast<std::uint8_t>(below(256));
    damaged = true;
  }
  if (is_due(word)) {
    constexpr std::uint64_t special[] = {0,      1,     0xFF,       0x7F,       0x8000,
                                         0x7FFF, 36000, 0xFFFFFFFF, 0x7FFFFFFF, 0x80000000};
    const std::uint64_t value = below(3) == 0 ? rng_.bits() : special[below(std::size(special))];
    put(bytes_, below(bytes_.size()), value, std::size_t{1} << below(4));
    damaged = true;
  }
  if (is_due(smear)) {  // a few bytes over and over
    const std::size_t from = below(bytes_.size()), length = 1 + below(16);
    const std::size_t to = std::min(bytes_.size(), from + below(bytes_.size()));
    for (std::size_t i = from + length; i < to; ++i) bytes_[i] = bytes_[i - length];
    damaged = true;
  }
  if (damaged && below(5) != 0) sim::make_checksums_right(bytes_);
  if (is_due(cut)) bytes_.resize(below(2) == 0 ? below(bytes_.size()) : bytes_.size() + below(900));
}

void PacketMill::set_times() {
  now_ = now_ + span_from_seconds(rng_.uniform() * 2 / model_.packets_per_s);
  if (is_due(leap)) {
    constexpr double leaps[] = {-1, 1, -0.001, 0.2, -3600, 3600, 1e6, -1e6};
    now_ = now_ + span_from_seconds(leaps[below(std::size(leaps))] * rng_.uniform());
  }
  packet_.arrival = now_;
  packet_.transport = model_.transport;
  if (model_.transport != Transport::tcp || !is_due(hole)) return;
  packet_.missing = below(3) == 0 ? rng_.bits() : below(2000);
  packet_.stream_start = below(4) == 0;
}

const Packet& PacketMill::next() {
  if (!rest_.empty()) {
    bytes_ = std::move(rest_);
    rest_.clear();
    packet_.missing = 0;
    packet_.stream_start = false;
  } else {
    const OwnPacket& own = choose();
    bytes_ = own.bytes;
    packet_ = own.head;
    restamp();
    damage();
    set_times();
    if (model_.transport == Transport::tcp && below(4) == 0 && bytes_.size() > 1) {
      const auto middle = bytes_.begin() + static_cast<std::ptrdiff_t>(below(bytes_.size()));
      rest_.assign(middle, bytes_.end());
      bytes_.erase(middle, bytes_.end());
    }
  }
  packet_.payload = ByteView(bytes_.data(), bytes_.size());
  return packet_;
}

}  // namespace lidard::test
