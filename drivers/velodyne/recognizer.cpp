// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause

#include <algorithm>
#include <cstdlib>

#include "drivers/velodyne/models.h"
#include "drivers/velodyne/packet.h"
#include "drivers/velodyne/telemetry.h"

namespace lidard::velodyne {
namespace {

/// An S3 sends a warning byte in every fourth cycle of 16 status bytes, others the first byte of the
/// calibration: 63-HDL64ES3 Rev K, appendix E.
constexpr std::uint8_t before_warning = 'V', warning = 'W', first_of_calibration = '1';
constexpr std::uint64_t enough_quiet_cycles = 5;

bool is_within_percent(Span a, Span b, int percent) {
  return a * 100 < b * (100 + percent) && a * 100 > b * (100 - percent);
}

/// True for telemetry: sent to its usual port, or with a sentence of a satellite receiver.
bool is_telemetry(const Packet& packet) {
  const auto telemetry = read_telemetry(packet.payload);
  return telemetry && (packet.to.port == usual_telemetry_port || telemetry->nmea.substr(0, 2) == "$G");
}

/// Adds the products of a row: a Puck LITE has the row of a VLP-16.
void add_products(const ModelRow* row, std::vector<std::string_view>& names) {
  static const std::vector<Model> products = [] {
    std::vector<Model> list;
    append_models(list);
    return list;
  }();
  for (const Model& model : products) {
    if (model.row == row) names.push_back(model.name);
  }
}

/// Recognizes the model from the order of blocks, the product byte (unless the packet period contradicts it)
/// and the status bytes of an HDL-64E.
class VelodyneRecognizer final : public Recognizer {
 public:
  void add(const Packet& received) override {
    if (received.transport != Transport::udp) return;
    const ByteView payload = received.payload;
    const ModelRow* family = family_of(payload);
    telemetry_ += is_telemetry(received) ? 1U : 0U;
    if (family == nullptr) return;
    const DataPacket packet(payload);
    if (packets_ > 0 && step_count_ < steps_.size()) {
      const Span step = hour_difference(packet.stamp_us(), last_us_);
      if (step != Span(0)) steps_[step_count_++] = std::abs(step.count());
    }
    last_us_ = packet.stamp_us();
    ++packets_;
    family_ = family;
    if (layout_of(packet, *family).echoes == 2) ++dual_packets_;
    product_ = packet.product();
    note_status(packet.mode());
  }

  std::string_view verdict() const override {
    const auto names = others();
    return names.empty() ? std::string_view() : names.front();
  }

  /// All products of the rows that fit: a Puck LITE has the row of a VLP-16.
  std::vector<std::string_view> others() const override {
    std::vector<std::string_view> names;
    for (const ModelRow* row : possible_rows()) add_products(row, names);
    return names;
  }

  /// Reports a product that is not supported, or whose packet period is another model's.
  std::string remark() const override {
    if (packets_ == 0 && telemetry_ > 0)
      return "telemetry of a Velodyne, but none of its data; check that its laser and motor are "
             "on and that it "
             "sends data to port " +
             std::to_string(usual_data_port) + " of the same host";
    if (packets_ == 0) return {};
    const auto rows = possible_rows();
    if (rows.empty()) return "Velodyne packets of a " + product_name(product_) + ", which is not supported";
    const ModelRow* const chosen = rows.front();
    if (!chosen->names_product() || chosen->has_product(product_)) return {};
    return "product byte says " + product_name(product_) + ", the packet period says " +
           std::string(chosen->product);
  }

 private:
  /// The rows that fit the packets, most likely first; empty: not a Velodyne, or one without a row.
  std::vector<const ModelRow*> possible_rows() const {
    if (packets_ == 0) return {};
    if (!family_->has_stamp()) return {family_};
    std::vector<const ModelRow*> rows;
    const bool is_named = is_byte_right();
    for (const ModelRow* each : model_rows()) {
      const bool is_possible = family_->has_status() ? is_possible_generation(*each)
                               : is_named ? each->banks == family_->banks && each->has_product(product_)
                                          : fits_period(*each);
      if (is_possible) rows.push_back(each);
    }
    if (!family_->has_status()) return rows;
    // Every HDL-64E has both periods; prefer the first row whose usual period fits.
    const auto usual = std::find_if(rows.begin(), rows.end(), [&](const ModelRow* each) {
      return is_within_percent(packet_period(), each->packet_period(each->timings.front(), echoes()), 3);
    });
    if (usual != rows.end()) std::rotate(rows.begin(), usual, usual + 1);
    return rows;
  }

  std::size_t echoes() const { return dual_packets_ * 2 > packets_ ? 2 : 1; }

  const ModelRow* by_product() const {
    for (const ModelRow* each : model_rows()) {
      if (each->banks == family_->banks && each->has_product(product_)) return each;
    }
    return nullptr;
  }

  bool fits_period(const ModelRow& model) const {
    if (model.banks != family_->banks) return false;
    const Span period = packet_period();
    return std::any_of(model.timings.begin(), model.timings.end(), [&](const Timing& timing) {
      return is_within_percent(period, model.packet_period(timing, echoes()), 3);
    });
  }

  /// The product byte names a model and the period, if known, is that model's.
  bool is_byte_right() const {
    const ModelRow* named = by_product();
    return packet_period() == Span(0) || (named != nullptr && fits_period(*named));
  }

  /// True if an HDL-64E with pairs of blocks may be of that generation, by the status bytes, else by the
  /// period.
  bool is_possible_generation(const ModelRow& model) const {
    if (!model.has_status()) return false;
    const bool is_s3 = model.warns;
    if (warnings_ > 0) return is_s3;
    if (quiet_ >= enough_quiet_cycles) return !is_s3;
    return true;
  }

  void note_status(std::uint8_t type) {
    if (last_type_ == before_warning) {
      warnings_ += type == warning ? 1U : 0U;
      quiet_ += type == first_of_calibration ? 1U : 0U;
    }
    last_type_ = type;
  }

  /// The usual step between stamps of packets of which none in between is missing; 0 while fewer than four
  /// packets were seen.
  Span packet_period() const {
    constexpr std::size_t enough = 3;
    if (step_count_ < enough) return Span(0);
    auto sorted = steps_;
    const auto low = sorted.begin() + static_cast<std::ptrdiff_t>(step_count_ / 10);
    std::nth_element(sorted.begin(), low, sorted.begin() + static_cast<std::ptrdiff_t>(step_count_));
    return Span(*low);
  }

  std::uint64_t packets_ = 0;
  std::uint64_t telemetry_ = 0;
  std::uint64_t dual_packets_ = 0;
  std::uint8_t product_ = 0;
  const ModelRow* family_ = nullptr;
  std::uint32_t last_us_ = 0;
  std::array<std::int64_t, 128> steps_{};
  std::size_t step_count_ = 0;
  std::uint8_t last_type_ = 0;  // of the status bytes of an HDL-64E
  std::uint64_t warnings_ = 0;  // cycles with a warning byte
  std::uint64_t quiet_ = 0;     // cycles without one
};

}  // namespace

const ModelRow* family_of(ByteView payload) {
  if (payload.size() != packet_size) return nullptr;
  const DataPacket packet(payload);
  for (const ModelRow* row : model_rows()) {
    if (check_blocks(packet, layout_of(packet, *row)) == Reject::none) return row;
  }
  return nullptr;
}

std::unique_ptr<Recognizer> make_recognizer() { return std::make_unique<VelodyneRecognizer>(); }

}  // namespace lidard::velodyne
