// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola_recognizer.h"

#include <array>
#include <cmath>

#include "drivers/sick/cola_geometry.h"

namespace lidard::sick {
namespace {

/// How the names begin that devices call themselves by; the first that fits counts.
/// Recorded: "MRS1xxxx". The others follow SICK 8014631 and are unverified.
struct Identity {
  std::string_view begins, model;
};
constexpr std::array identities = {
    Identity{"MRS1", "sick_mrs1000"},    Identity{"LMS10", "sick_lms1xx"},
    Identity{"LMS11", "sick_lms1xx"},    Identity{"LMS12", "sick_lms1xx"},
    Identity{"LMS13", "sick_lms1xx"},    Identity{"LMS14", "sick_lms1xx"},
    Identity{"LMS15", "sick_lms1xx"},    Identity{"LMS1xxx", "sick_lms1000"},
    Identity{"LMS1000", "sick_lms1000"}, Identity{"LMS5", "sick_lms5xx"},
    Identity{"LMS4", "sick_lms4000"},    Identity{"TiM2", "sick_tim240"},
    Identity{"TiM4", "sick_tim4xx"},     Identity{"TiM5", "sick_tim5xx"},
    Identity{"TiM7", "sick_tim7xx"},     Identity{"LRS36", "sick_lrs36x0"},
    Identity{"NAV2", "sick_nav2xx"},     Identity{"NAV31", "sick_nav31x"},
    Identity{"OEM15", "sick_oem15xx"},
};

/// The shape of the whole sweep of a family; a part of it fits too. The first that fits counts.
struct Shape {
  double start_deg, end_deg;  ///< of the device
  double step_deg;            ///< 0: any
  double hz;                  ///< 0: any
  std::string_view model;
};
constexpr std::array shapes = {
    Shape{-47.5, 227.5, 0.25, 50, "sick_lms1000"},  //
    Shape{-45, 225, 1.0 / 3, 15, "sick_tim7xx"},    //
    Shape{-120, 120, 1, 14.5, "sick_tim240"},       //
    Shape{-45, 225, 0.25, 25, "sick_lms1xx"},       //
    Shape{-45, 225, 0.5, 50, "sick_lms1xx"},        //
    Shape{-45, 225, 0.25, 50, "sick_lms1xx"},       //
    Shape{-45, 225, 0.5, 25, "sick_lms1xx"},        //
    Shape{55, 125, 1.0 / 12, 600, "sick_lms4000"},  //
    Shape{-5, 185, 0, 0, "sick_lms5xx"},            //
    Shape{0, 360, 0, 8, "sick_nav31x"},             //
    Shape{-45, 225, 0, 0, "sick_lms1xx"},           //
};

bool near_to(double a, double b, double tolerance) { return std::abs(a - b) <= tolerance; }

std::string_view model_of(const ColaScan& scan) {
  const ColaChannel* distance = scan.channel("DIST1");
  if (distance == nullptr || distance->values.empty()) return {};
  const double step = exact_step_deg(distance->step_deg);
  const double end = distance->start_deg + step * static_cast<double>(distance->values.size() - 1);
  constexpr double slack_deg = 0.1;
  for (const Shape& shape : shapes) {
    const bool inside =
        distance->start_deg >= shape.start_deg - slack_deg && end <= shape.end_deg + slack_deg;
    const bool same_step = shape.step_deg == 0 || near_to(step, shape.step_deg, 1e-4);
    const bool same_rate = shape.hz == 0 || near_to(scan.scan_hz, shape.hz, 0.6);
    // A whole LMS5xx sweep is a part of the wider ones.
    const bool lms5xx = near_to(distance->start_deg, -5, slack_deg) && near_to(end, 185, slack_deg);
    if (inside && same_step && same_rate && (!lms5xx || shape.start_deg == -5)) return shape.model;
  }
  return {};
}

}  // namespace

/// The text may stand behind its length, of whichever dialect.
std::string_view cola_model_named(std::string_view identity) {
  for (const Identity& known : identities) {
    if (identity.substr(0, 16).find(known.begins) != std::string_view::npos) return known.model;
  }
  return {};
}

void ColaRecognizer::add(const Packet& packet) {
  if (packet.transport != Transport::tcp) return;
  if (packet.stream_start || packet.missing > 0) stream_.reset();
  stream_.add(packet.payload);
  for (ColaTelegram telegram; stream_.next(telegram);) look_at(telegram);
}

void ColaRecognizer::look_at(const ColaTelegram& telegram) {
  if (telegram.kind() == "sRA" && telegram.name() == "DeviceIdent")
    note_identity(telegram.arguments().text());
  if (named_ || telegram.name() != "LMDscandata") return;
  if (parse_cola_scan(telegram, scan_) != Reject::none) return;
  layered_ = layered_ || scan_.layer != 0;
  verdict_ = layered_ ? std::string_view("sick_mrs1000") : model_of(scan_);
}

void ColaRecognizer::note_identity(std::string_view identity) {
  const std::string_view model = cola_model_named(identity);
  if (model.empty()) return;
  verdict_ = model;
  named_ = true;
}

std::string ColaRecognizer::remark() const {
  if (named_ || verdict_.empty()) return {};
  return "SICK scanners of several families send such scans; name the model if it is another one";
}

}  // namespace lidard::sick
