// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_recognizer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/sick/cola/cola_geometry.h"

namespace lidard::sick {
namespace {

/// How the names begin that devices call themselves by; the first that fits counts.
/// Recorded: "MRS1xxxx", "MRS1xxxC". The others follow SICK 8014631 and are unverified.
struct Identity {
  std::string_view begins, model;
};
constexpr std::array identities = {
    Identity{"MRS1", "sick_mrs1000"},    Identity{"LMS1xxx", "sick_lms1000"},
    Identity{"LMS1000", "sick_lms1000"}, Identity{"LMS10", "sick_lms1xx"},
    Identity{"LMS11", "sick_lms1xx"},    Identity{"LMS12", "sick_lms1xx"},
    Identity{"LMS13", "sick_lms1xx"},    Identity{"LMS14", "sick_lms1xx"},
    Identity{"LMS15", "sick_lms1xx"},    Identity{"LMS5", "sick_lms5xx"},
    Identity{"LMS4", "sick_lms4000"},    Identity{"TiM2", "sick_tim240"},
    Identity{"TiM4", "sick_tim4xx"},     Identity{"TiM5", "sick_tim5xx"},
    Identity{"TiM7", "sick_tim7xx"},     Identity{"LRS36", "sick_lrs36x0"},
    Identity{"NAV2", "sick_nav2xx"},     Identity{"NAV31", "sick_nav31x"},
    Identity{"OEM15", "sick_oem15xx"},
};

constexpr double slack_deg = 0.1;
constexpr double any = 0;

/// What the scans of a family may be: a part of the sweep from `start_deg` to `end_deg` of the device, at one
/// of the rates and steps, no distance beyond `farthest_m`.
struct Family {
  std::string_view model;
  double start_deg, end_deg;
  std::array<double, 5> hz;        ///< unused ones 0; all 0: any
  std::array<double, 9> step_deg;  ///< unused ones 0; all 0: any
  double most_mm;                  ///< of one step of a distance (the scale factor); 0: any
  double farthest_m;
};
/// Of the families that fit, the first is told. Rates and steps of the LMS5xx: SICK 8013796 p. 85; that it
/// alone tells distances in steps of 2 mm follows from its range of 80 m (16 bits of 1 mm end at 65 m) and
/// was seen; the others' were seen or follow their data sheets, unverified.
constexpr std::array families = {
    Family{"sick_lms1000", -47.5, 227.5, {50}, {0.25}, 1, 64},
    Family{"sick_tim7xx", -45, 225, {15}, {1.0 / 3}, 1, 25},
    Family{"sick_tim7xxs", -45, 225, {15}, {1.0 / 3}, 1, 25},
    Family{"sick_tim5xx", -45, 225, {15}, {1.0 / 3}, 1, 25},
    Family{"sick_tim4xx", -30, 210, {15}, {1.0 / 3}, 1, 25},
    Family{"sick_tim240", -120, 120, {14.5}, {1}, 1, 10},
    Family{"sick_lms1xx", -45, 225, {25, 50}, {0.25, 0.5}, 1, 50},
    Family{"sick_lms4000", 55, 125, {600}, {}, 1, 6.5},
    Family{"sick_lms5xx",
           -5,
           185,
           {25, 35, 50, 75, 100},
           {1.0 / 24, 1.0 / 12, 1.0 / 6, 0.25, 1.0 / 3, 0.5, 2.0 / 3, 0.75, 1},
           2,
           131},
    Family{"sick_nav31x", 0, 360, {8}, {}, any, any},
    Family{"sick_oem15xx", 0, 360, {8}, {}, any, any},
    Family{"sick_lrs36x0", 0, 360, {8}, {}, any, any},
    // Steps and rates that are not listed: rather a scan than none.
    Family{"sick_lms5xx", -5, 185, {}, {}, any, any},
    Family{"sick_lms1xx", -45, 225, {}, {}, 1, 50},
};
/// The families whose scans are known from devices; the last two take what is not listed.
constexpr std::size_t known_families = families.size() - 2;

bool near_to(double a, double b, double tolerance) { return std::abs(a - b) <= tolerance; }

template <std::size_t Size>
bool is_among(const std::array<double, Size>& values, double value, double tolerance) {
  if (values[0] == any) return true;
  return std::any_of(values.begin(), values.end(),
                     [&](double each) { return each != any && near_to(each, value, tolerance); });
}

/// A whole sweep of an LMS5xx is a part of the wider ones.
bool is_whole_lms5xx(const ColaEvidence& seen) {
  return near_to(seen.start_deg, -5, slack_deg) && near_to(seen.end_deg, 185, slack_deg);
}

bool fits(const Family& family, const ColaEvidence& seen) {
  if (seen.start_deg < family.start_deg - slack_deg || seen.end_deg > family.end_deg + slack_deg)
    return false;
  if (is_whole_lms5xx(seen) && family.model != "sick_lms5xx") return false;
  if (family.most_mm != any && seen.scale_mm > family.most_mm) return false;
  // A device may overshoot its range a little.
  if (family.farthest_m != any && seen.farthest_m > 1.1 * family.farthest_m) return false;
  return is_among(family.hz, seen.hz, 0.6) && is_among(family.step_deg, seen.step_deg, 1e-4);
}

/// What a telegram says, and how far the scans before it saw. False if it has no distances.
bool look(const ColaScan& scan, ColaEvidence& seen) {
  const ColaChannel* distance = scan.channel("DIST1");
  if (distance == nullptr || distance->values.empty()) return false;
  seen.step_deg = exact_step_deg(distance->step_deg);
  seen.start_deg = distance->start_deg;
  seen.end_deg = distance->start_deg + seen.step_deg * static_cast<double>(distance->values.size() - 1);
  seen.hz = scan.scan_hz;
  seen.scale_mm = static_cast<double>(distance->scale);
  for (std::size_t i = 0; i < distance->values.size(); ++i) {
    if (status_of_raw(distance->values[i]) == BeamStatus::hit)
      seen.farthest_m = std::max(seen.farthest_m, distance->value(i) * 1e-3);
  }
  return true;
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
  if (layered_) {
    verdict_ = "sick_mrs1000";
    others_.clear();
    return;
  }
  if (look(scan_, seen_)) choose();
}

/// The families that fit everything seen so far.
void ColaRecognizer::choose() {
  verdict_ = {};
  others_.clear();
  for (std::size_t i = 0; i < families.size(); ++i) {
    if (i >= known_families && !verdict_.empty()) return;
    if (!fits(families[i], seen_)) continue;
    if (verdict_.empty())
      verdict_ = families[i].model;
    else
      others_.push_back(families[i].model);
  }
}

void ColaRecognizer::note_identity(std::string_view identity) {
  const std::string_view model = cola_model_named(identity);
  if (model.empty()) return;
  verdict_ = model;
  named_ = true;
  others_.clear();
}

std::unique_ptr<Recognizer> make_cola_recognizer() { return std::make_unique<ColaRecognizer>(); }

}  // namespace lidard::sick
