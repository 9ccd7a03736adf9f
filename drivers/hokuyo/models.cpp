// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/models.h"

#include "core/base/angle.h"
#include "drivers/hokuyo/uam_frame.h"

namespace lidard::hokuyo {
namespace {

// Angles of UST, UTM: 270 deg in steps of 0.25 deg, 40 turns a second. Least and largest distance as the
// sensors answer PP (UTM-30LX-EW 23 and 60000 mm, UST-10LX 20 and 30000 mm); of the others unverified.
constexpr ScipParameters ust(int range_max_mm) { return {20, range_max_mm, 1440, 0, 1080, 540, 2400}; }
constexpr ScipRow ust_05lx = {"UST-05LX", ust(30000), CodeTable::utm, true, true, false};  // 5 m; unverified
constexpr ScipRow ust_10lx = {"UST-10LX", ust(30000), CodeTable::utm, true, true, false};
constexpr ScipRow ust_20lx = {"UST-20LX", ust(60000), CodeTable::utm, true, true, false};  // unverified
constexpr ScipRow ust_30lx = {"UST-30LX", ust(60000), CodeTable::utm, true, true, false};  // unverified
constexpr ScipRow utm_30lx_ew = {
    "UTM-30LX", {23, 60000, 1440, 0, 1080, 540, 2400}, CodeTable::utm, false, false, false};
// 190 deg, 20 turns a second (data sheet); all else unverified, the sensor's PP counts.
constexpr ScipRow uxm_30lx_ew = {
    "UXM-30LX", {100, 80000, 1440, 0, 760, 380, 1200}, CodeTable::utm, false, false, false};
constexpr ScipRow any_scip = {"", {20, 60000, 1440, 0, 1080, 540, 2400}, CodeTable::utm, true, false, true};

Model scanner(std::string_view name, const char* product, const ScipRow& row, Traits traits,
              double dark_range = 0) {
  Model model{name, "Hokuyo", product, "SCIP 2",
              "own simulator; single answers of real sensors, no capture of a connection"};
  model.transport = Transport::tcp;
  model.port = 10940;  // Hokuyo C-42-04076 (UST-10LX)
  model.frame_period = row.parameters.turn_seconds();
  model.packets_per_s = 1 / model.frame_period;
  model.range_min = row.parameters.range_min_mm * 1e-3;
  model.range_max = row.parameters.range_max_mm * 1e-3;
  model.dark_range = dark_range;
  const ScipParameters& own = row.parameters;
  model.field = {own.angle(own.first_step) * deg_per_rad, own.rad_per_step() * deg_per_rad,
                 static_cast<std::size_t>(own.last_step - own.first_step + 1)};
  model.traits = traits;
  model.row = &row;
  model.make = make_scip_driver;
  return model;
}

}  // namespace

void append_scip_models(std::vector<Model>& list) {
  const Traits one = {Trait::skip_request, Trait::clock_request};
  const Traits several = {Trait::skip_request, Trait::clock_request, Trait::echoes};
  // Dark ranges: 10 % diffuse reflectance, hokuyo-aut.jp/search/single.php?serial=227, 167 and 233, as others
  // quote these pages; of the other sensors not known.
  list.push_back(scanner("hokuyo_ust_05lx", "UST-05LX", ust_05lx, one, 2));
  list.push_back(scanner("hokuyo_ust_10lx", "UST-10LX", ust_10lx, one, 4));
  list.push_back(scanner("hokuyo_ust_20lx", "UST-20LX", ust_20lx, one));
  list.push_back(scanner("hokuyo_ust_30lx", "UST-30LX", ust_30lx, one, 12));
  list.push_back(scanner("hokuyo_utm_30lx_ew", "UTM-30LX-EW", utm_30lx_ew, several));
  list.push_back(scanner("hokuyo_uxm_30lx_ew", "UXM-30LX-EW", uxm_30lx_ew, several));
  list.push_back(scanner(any_scip_name, "generic", any_scip, several));
}

void append_models(std::vector<Model>& list) {
  append_scip_models(list);
  append_uam_models(list);
}

std::string_view scip_name_of(std::string_view product) {
  const auto names = names_of(append_scip_models, [product](const Model& model) {
    const auto& row = *static_cast<const ScipRow*>(model.row);
    return !row.any && product.substr(0, row.product.size()) == row.product;
  });
  return names.empty() ? any_scip_name : names.front();
}

namespace {

/// A sender of so much without one known answer speaks another protocol.
constexpr std::uint64_t patience_bytes = 1 << 20;

/// Recognizes the TCP stream of a Hokuyo, and its model.
class HokuyoRecognizer final : public Recognizer {
 public:
  void add(const Packet& packet) override {
    if (packet.transport != Transport::tcp || useless_bytes_ > patience_bytes) return;
    if (packet.stream_start || packet.missing > 0) {
      scip_.interrupt();
      uam_.interrupt();
    }
    if (name_.empty()) useless_bytes_ += packet.payload.size();
    scip_.add(packet.payload);
    for (ScipMessage message; scip_.next(message);) inspect(message);
    uam_.add(packet.payload);
    for (UamFrame frame; uam_.next(frame);) {
      if (frame.reject != Reject::none) continue;
      const std::string_view command = frame.text.substr(5, 4);
      if (command == "AR00") name_ = "hokuyo_uam_05lp";
      if (command == "AR01") name_ = "hokuyo_uam_05lp_intensity";
      if (command == "AR06") name_ = "hokuyo_uam_05lp_fine";
    }
  }

  /// Name of a model; empty while nothing fits; the generic SCIP model after distances without a name.
  std::string_view verdict() const override { return name_; }
  /// While the sensor's name is unknown: all models that speak SCIP.
  std::vector<std::string_view> others() const override {
    if (name_ != any_scip_name) return {};
    return names_of(append_scip_models, [](const Model&) { return true; });
  }

 private:
  void inspect(const ScipMessage& message) {
    if (message.echo == "PP" && message.status == "00") {
      ScipParameters parameters;
      std::string product;
      if (parse_parameters(message.body, parameters, product)) name_ = scip_name_of(product);
    }
    if (name_.empty() && parse_scan_request(message.echo) &&
        (message.status == "99" || message.status == "00"))
      name_ = any_scip_name;
  }

  Counters ignored_;
  ScipReader scip_{ignored_};
  UamReader uam_{ignored_};
  std::uint64_t useless_bytes_ = 0;
  std::string_view name_;
};

}  // namespace

std::unique_ptr<Recognizer> make_recognizer() { return std::make_unique<HokuyoRecognizer>(); }

}  // namespace lidard::hokuyo
