// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Streams of Velodynes of every model: the first bytes choose model, return mode and settings, the rest makes
// one packet after the other: a well-formed data packet whose azimuths, stamp and some bytes the input tells,
// a position packet with any text in place of the sentence, any bytes, or what happens to a driver between
// packets. A frame that breaks an invariant is a finding, and so is a packet that is counted twice or not at
// all.
#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/calibration.h"
#include "drivers/velodyne/packet.h"
#include "test/sim/devices/velodyne.h"
#include "test/sim/servers/output_check.h"
#include "test/support/random_bytes.h"

namespace {

using namespace lidard;
using sim::Bytes;

class Stream {
 public:
  explicit Stream(Bytes& in)
      : in_(in), table_(sim::velodyne_tables()[in.below(sim::velodyne_tables().size())]) {
    static constexpr sim::ReturnMode modes[] = {sim::ReturnMode::strongest, sim::ReturnMode::last,
                                                sim::ReturnMode::dual, sim::ReturnMode::dual_confidence};
    mode_ = in.below(table_.has_confidence() ? 4 : table_.has_dual ? 3 : 2);
    plan_ = sim::plan_packet(table_.lasers.size(), modes[mode_]);
  }
  DriverConfig config() {
    DriverConfig config;
    config.model = find_model(table_.name);
    const std::uint8_t wishes = in_.byte();
    config.clock = (wishes & 1U) != 0 ? ClockMode::arrival : ClockMode::smooth;
    config.keep_partial = (wishes & 2U) != 0;
    config.keep_origins = (wishes & 4U) != 0;
    config.keep_too_near = (wishes & 8U) != 0;
    config.cut_angle = in_.between(0, 6.28);
    if ((wishes & 128U) != 0)
      config.calibration = std::make_shared<Calibration>(table_calibration(*config.model));
    return config;
  }
  /// Blocks of one firing look the same way; the stamp goes on by up to 16 ms, or to anywhere.
  const std::vector<std::uint8_t>& data_packet() {
    bytes_.assign(velodyne::packet_size, 0);
    const unsigned how = in_.byte();
    if ((how & 1U) != 0) azimuth_ = word() % 36001U;
    if ((how & 2U) != 0) turn_ = word() % ((how & 4U) != 0 ? 36000U : 100U);
    stamp_ = (how & 8U) != 0 ? word() << 16U | word() : stamp_ + word() / 4;
    std::size_t before = plan_.front().first_beam;
    for (std::size_t b = 0; b < plan_.size(); ++b) {
      const bool dummy = plan_[b].content == sim::BlockPlan::Content::dummy;
      if (plan_[b].first_beam / table_.lasers.size() != before / table_.lasers.size())
        azimuth_ = (azimuth_ + turn_) % 36000U;
      before = plan_[b].first_beam;
      put(b * velodyne::block_size, plan_[b].flag, 2);
      put(b * velodyne::block_size + 2, dummy ? 0xFFFFU : azimuth_, 2);
    }
    azimuth_ = (azimuth_ + turn_) % 36000U;
    put(velodyne::stamp_offset, stamp_, 4);
    if (table_.product != 0) {
      constexpr unsigned mode_bytes[] = {0x37, 0x38, 0x39, 0x3B};
      put(velodyne::mode_offset, mode_bytes[mode_], 1);
      put(velodyne::product_offset, (how & 16U) != 0 ? in_.byte() : table_.product, 1);
    } else {
      put(velodyne::mode_offset, word(), 2);  // type and value of the status
    }
    for (unsigned n = how >> 5U; n > 0; --n) put(word() % bytes_.size(), in_.byte(), 1);
    fill();
    return bytes_;
  }
  const std::vector<std::uint8_t>& position_packet() {
    bytes_.assign(velodyne::position_packet_size, 0);
    constexpr std::size_t head = 0xC6, sentence = 0xCE;
    const std::size_t from = in_.below(2) == 0 ? head : 0;
    for (std::size_t i = from; i < sentence && from != 0; ++i) bytes_[i] = in_.byte();
    constexpr std::string_view begins[] = {"$GPRMC,", "$GPGGA,", "$GNRMC,", ""};
    const std::string_view begin = begins[in_.below(4)];
    std::copy(begin.begin(), begin.end(), bytes_.begin() + sentence);
    const std::size_t length = in_.below(120);
    for (std::size_t i = 0; i < length; ++i) bytes_[sentence + begin.size() + i] = in_.byte();
    return bytes_;
  }
  const std::vector<std::uint8_t>& any_bytes() {
    bytes_.resize(in_.below(1400));
    for (std::uint8_t& byte : bytes_) byte = in_.byte();
    return bytes_;
  }

 private:
  unsigned word() { return static_cast<unsigned>(in_.below(65536)); }
  void put(std::size_t at, unsigned value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) bytes_[at + i] = static_cast<std::uint8_t>(value >> 8U * i);
  }
  /// Returns from somewhere, in slots that the input left alone.
  void fill() {
    const unsigned distance = word();
    for (std::size_t slot = 0; slot < 12 * 32; slot += 1 + distance % 7U) {
      const std::size_t at = slot / 32 * velodyne::block_size + 4 + slot % 32 * 3;
      if (bytes_[at] == 0 && bytes_[at + 1] == 0) put(at, distance + 77U * static_cast<unsigned>(slot), 3);
    }
  }

  Bytes& in_;
  const sim::VelodyneTable& table_;
  std::size_t mode_;
  std::vector<sim::BlockPlan> plan_;
  unsigned azimuth_ = 0, turn_ = 20, stamp_ = 1000;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  Stream stream(in);
  const auto driver = [&stream] {
    const DriverConfig config = stream.config();
    return config.model->make(config);
  }();
  sim::OutputCheck out;
  Packet packet;
  packet.arrival = Stamp{1'767'225'600'000'000'000};
  std::uint64_t given = 0, refused = 0;
  while (!in.empty()) {
    const std::size_t kind = in.below(64);
    packet.arrival = packet.arrival + std::chrono::microseconds(kind == 63 ? 900'000 : 700);
    if (kind == 0) driver->tick(packet.arrival, out);
    if (kind == 1) driver->finish(out);
    if (kind == 2) driver->restart();
    if (kind < 3) continue;
    const auto& bytes = kind < 8    ? stream.position_packet()
                        : kind < 10 ? stream.any_bytes()
                                    : stream.data_packet();
    packet.payload = ByteView(bytes.data(), bytes.size());
    ++given;
    refused += driver->receive(packet, out).reject != Reject::none ? 1U : 0U;
  }
  driver->finish(out);
  const Counters& counters = driver->counters();
  if (out.violation() != nullptr || counters.frames != out.frames()) std::abort();
  if (counters.packets + counters.other_packets != given) std::abort();
  if (counters.rejected_total() < refused || counters.rejected_total() > given) std::abort();
  return 0;
}
