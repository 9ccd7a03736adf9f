// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_models.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/angle.h"
#include "drivers/sick/cola/cola_frames.h"

namespace lidard::sick {
namespace {

// SICK 8014631 chapter 4.1: user level 3 is "authorized client". Passwords of the factory setting.
constexpr std::uint8_t authorized_client = 3;
constexpr std::uint32_t usual_password = 0xF4724744;
constexpr std::uint32_t tim7xxs_password = 0x6FD62C05;

// Shifts and mirroring: sick_scan_xd 3.9.0, sick_generic_parser.cpp 553-1018. Recordings confirm those of
// TiM7xx, LMS1xx, LMS5xx and MRS1000; the others are unverified.
//
// Stamps: LMS111 and TiM781 transmit 3 and 6 ms after their time stamp, but their sweeps last 15 and 50 ms:
// the stamp cannot be that of the first beam; assumed: the last beam. MRS1104 transmits 64 ms after it, its
// sweep lasts 61 ms: the first beam. LMS511: 40 ms, sweep 21 ms: assumed: the first beam. All others are
// unverified, as is the error within a turn.
constexpr ColaRow row(double shift_deg, bool mirrored, ColaStamp stamp, std::uint8_t echoes = 1,
                      std::uint32_t password = usual_password,
                      AngleCompensation compensation = AngleCompensation::none, bool contamination = false,
                      std::string_view remark = {}) {
  return {shift_deg, mirrored,     stamp,         1,     authorized_client, password, false, echoes,
          false,     compensation, contamination, remark};
}
// Echoes: a few LMS1xx configurations in public use 1, 2 or 3; all five of the LMS5xx: SICK 8014631.
constexpr std::uint8_t two_echoes = 0x03, three_echoes = 0x07, five_echoes = 0x1f;
constexpr ColaRow lms1xx =
    row(-90, false, ColaStamp::last_beam, two_echoes, usual_password, AngleCompensation::none, true);
constexpr ColaRow lms5xx =
    row(-90, false, ColaStamp::first_beam, five_echoes, usual_password, AngleCompensation::none, true);
// SICK 8023202 (LMS4400 and LMS4500) p. 56: 0 also stands for too near, too dark, or removed by a filter.
constexpr ColaRow lms4000 = {-90, false, ColaStamp::first_beam, 1, authorized_client, usual_password, false,
                             1,   true};
constexpr ColaRow tim240 = row(0, false, ColaStamp::last_beam);
constexpr ColaRow tim = row(-90, false, ColaStamp::last_beam);
constexpr ColaRow tim7xxs = row(-90, false, ColaStamp::last_beam, 1, tim7xxs_password);
constexpr ColaRow lrs36x1 = row(-180, false, ColaStamp::first_beam);
// README and angle compensation of sick_scan_xd: 90 deg less; its parser: 0.
constexpr ColaRow nav2xx = row(
    0, false, ColaStamp::first_beam, 1, usual_password, AngleCompensation::subtracted, false,
    "SICK contradicts itself on a NAV2xx's angle 0: its driver's parser has it ahead, as here, its README "
    "on the right; turn the pose by -90 degrees if objects appear 90 degrees to the left");
// NAV31x, OEM15xx and LRS36x0: sick_lmd_scandata_parser.cpp lets them begin at +180 deg, whatever the shift
// of the row is. The NAV310's 0 deg lies behind it. Unverified: sick_scan_xd's cloud of an LRS36x0 lies 90
// deg from its scan.
constexpr ColaRow backward = row(-180, true, ColaStamp::first_beam);
constexpr ColaRow nav31x =
    row(-180, true, ColaStamp::first_beam, 1, usual_password, AngleCompensation::added);
// Four measuring modules turn together and send one sweep each: four telegrams per turn (SICK 8020494, p.
// 24).
constexpr ColaRow lms1000 = {-90,   false,       ColaStamp::first_beam, 4, authorized_client, usual_password,
                             false, three_echoes};
constexpr ColaRow mrs1000 = {-90,  false,       ColaStamp::first_beam, 4, authorized_client, usual_password,
                             true, three_echoes};

constexpr std::uint16_t usual_port = 2112;
constexpr std::uint16_t other_port = 2111;
constexpr const char* unverified = "simulator only; no capture of a device";

struct Facts {
  const char* name;
  const char* product;
  const ColaRow* row;
  double hz;                    ///< telegrams per second, usual
  double range_min, range_max;  ///< m
  const char* verified;
  std::uint16_t port = usual_port;
  double dark_range = 0;  ///< m, at 10 % remission
};

// Dark ranges: SICK's pages of LMS111-10100 (18 m, 20 m at 90 %) and TiM240-2050300 (2.8 m), the data sheet
// of TiM561-2050101 (8 m, as the TiM571's), each as others quote it. An LMS14x or 15x sees farther. Those of
// the other families are not known. Ranges: the products' data sheets, the largest of each family; the near
// ends are distances in recordings (LMS111 0.08 m, MRS1104 16 mm). Unverified.
constexpr Facts all_facts[] = {
    {"sick_lms1xx", "LMS1xx", &lms1xx, 50, 0.05, 50, "1 capture (LMS111), telegrams of an LMS151", usual_port,
     18},
    {"sick_lms5xx", "LMS5xx", &lms5xx, 25, 0.05, 80, "1 capture (LMS511), single answers in CoLa A"},
    {"sick_lms1000", "LMS1000", &lms1000, 150, 0.05, 64, unverified},
    {"sick_lms4000", "LMS4000", &lms4000, 600, 0.5, 3.5, unverified},
    {"sick_tim240", "TiM240", &tim240, 14.5, 0.05, 10, unverified, other_port, 2.8},
    {"sick_tim4xx", "TiM4xx", &tim, 15, 0.05, 25, unverified},
    {"sick_tim5xx", "TiM5xx", &tim, 15, 0.05, 25, "1 telegram of CoLa A, headers of two TiM551", usual_port,
     8},
    {"sick_tim7xx", "TiM7xx", &tim, 15, 0.05, 25, "2 captures (TiM781S)"},
    {"sick_tim7xxs", "TiM7xxS", &tim7xxs, 15, 0.05, 25, "2 captures (TiM781S)"},
    {"sick_lrs36x0", "LRS36x0", &backward, 8, 0.5, 250, unverified},
    {"sick_lrs36x1", "LRS36x1", &lrs36x1, 15, 0.5, 250, unverified},
    {"sick_nav2xx", "NAV2xx", &nav2xx, 25, 0.1, 50, unverified},
    {"sick_nav31x", "NAV31x", &nav31x, 8, 0.5, 250, unverified, other_port},
    {"sick_oem15xx", "OEM15xx", &backward, 8, 0.5, 250, unverified, other_port},
    {"sick_mrs1000", "MRS1000", &mrs1000, 50, 0.016, 64,
     "2 captures (MRS1104), one beside the clouds that SICK's own driver published of it"},
};

Model model_of(const Facts& facts) {
  Model model{facts.name, "SICK", facts.product, "CoLa A/B", facts.verified};
  model.kind = facts.row->layered ? FrameKind::cloud : FrameKind::scan;
  model.transport = Transport::tcp;
  model.port = facts.port;
  model.packets_per_s = facts.hz;
  model.frame_period = (facts.row->layered ? facts.row->turn : 1) / facts.hz;
  model.range_min = facts.range_min;
  model.range_max = facts.range_max;
  model.dark_range = facts.dark_range;
  model.beams = facts.row->layered ? facts.row->turn : 0;
  model.row = facts.row;
  model.make = make_cola_driver;
  model.traits = {Trait::settings_writable, Trait::logins, Trait::skip_setting, Trait::states_on_request};
  if (facts.row->echoes != 1 && !facts.row->layered) model.traits.add(Trait::echoes);
  for (const std::string_view topic : {topic_fields, topic_outputs, topic_inputs, topic_encoder})
    model.messages.push_back(message_topic<DeviceState>(topic));
  if (facts.row->layered) model.messages.push_back(message_topic<ImuSample>());
  return model;
}

/// Prefixes of the names in DeviceIdent; the first match counts. Recorded: "MRS1xxxx", "MRS1xxxC". The others
/// follow SICK 8014631 and are unverified.
struct Identity {
  std::string_view begins, model;
};
constexpr std::array identities = {
    Identity{"MRS1", "sick_mrs1000"},    Identity{"LMS1xxx", "sick_lms1000"},
    Identity{"LMS1000", "sick_lms1000"}, Identity{"LMS1104", "sick_lms1000"},
    Identity{"LMS10", "sick_lms1xx"},    Identity{"LMS11", "sick_lms1xx"},
    Identity{"LMS12", "sick_lms1xx"},    Identity{"LMS13", "sick_lms1xx"},
    Identity{"LMS14", "sick_lms1xx"},    Identity{"LMS15", "sick_lms1xx"},
    Identity{"LMS1xx", "sick_lms1xx"},   Identity{"LMS5", "sick_lms5xx"},
    Identity{"LMS4", "sick_lms4000"},    Identity{"TiM2", "sick_tim240"},
    Identity{"TiM4", "sick_tim4xx"},     Identity{"TiM5", "sick_tim5xx"},
    Identity{"TiM7xxS", "sick_tim7xxs"}, Identity{"TiM781S", "sick_tim7xxs"},
    Identity{"TIM2", "sick_tim240"},     Identity{"TIM4", "sick_tim4xx"},
    Identity{"TIM5", "sick_tim5xx"},     Identity{"TIM7", "sick_tim7xx"},
    Identity{"TiM7", "sick_tim7xx"},     Identity{"LRS3601", "sick_lrs36x1"},
    Identity{"LRS3611", "sick_lrs36x1"}, Identity{"LRS36x1", "sick_lrs36x1"},
    Identity{"LRS36", "sick_lrs36x0"},   Identity{"NAV2", "sick_nav2xx"},
    Identity{"NAV31", "sick_nav31x"},    Identity{"OEM15", "sick_oem15xx"},
};

/// Evidence from the scans of a sender.
struct ColaEvidence {
  double start_deg = 0, end_deg = 0, step_deg = 0;  ///< as the device counts
  double hz = 0;                                    ///< scans per second
  double scale_mm = 1;                              ///< of one step of a distance
  double farthest_m = 0;                            ///< of all scans so far
  std::uint8_t echoes = 0;                          ///< bits of the channels DIST1 ...
  double parts = 0;        ///< telegrams for each turn, by the measurement frequency; 0: unknown
  std::string_view named;  ///< the model that the device's own name in the telegram contains
};

constexpr double slack_deg = 0.1;
constexpr double any = 0;

/// Possible scans of a family: a part of the sweep from `start_deg` to `end_deg` of the device, with one of
/// the rates and steps and no distance beyond `farthest_m`.
struct Family {
  std::string_view model;
  const ColaRow* row;
  double start_deg, end_deg;
  std::array<double, 5> hz;        ///< unused ones 0; all 0: any
  std::array<double, 9> step_deg;  ///< unused ones 0; all 0: any
  double most_mm;                  ///< of one step of a distance (the scale factor); 0: any
  double farthest_m;
};
/// The first family that fits is chosen. Rates and steps of the LMS5xx: SICK 8013796 p. 85; only the LMS5xx
/// sends distances in steps of 2 mm, as its range of 80 m requires (16 bits of 1 mm end at 65 m). The values
/// of the others are from recordings or, unverified, from data sheets.
constexpr std::array families = {
    Family{"sick_lms1000", &lms1000, -48.4, 228.2, {37.5, 75, 150}, {0.1875, 0.375, 0.75}, 1, 64},
    Family{"sick_tim7xx", &tim, -45, 225, {15}, {1.0 / 3}, 1, 25},
    Family{"sick_tim7xxs", &tim7xxs, -45, 225, {15}, {1.0 / 3}, 1, 25},
    Family{"sick_tim5xx", &tim, -45, 225, {15}, {1.0 / 3, 1}, 1, 25},
    Family{"sick_tim4xx", &tim, -30, 210, {15}, {1.0 / 3}, 1, 25},
    Family{"sick_tim240", &tim240, -120, 120, {14.5}, {1}, 1, 10},
    Family{"sick_lms1xx", &lms1xx, -45, 225, {25, 50}, {0.25, 0.5}, 1, 50},
    Family{"sick_lms4000", &lms4000, 55, 125, {600}, {}, 1, 6.5},
    Family{"sick_lms5xx",
           &lms5xx,
           -5,
           185,
           {25, 35, 50, 75, 100},
           {1.0 / 24, 1.0 / 12, 1.0 / 6, 0.25, 1.0 / 3, 0.5, 2.0 / 3, 0.75, 1},
           2,
           131},
    Family{"sick_lms1000", &lms1000, -48.4, 228.2, {50}, {0.25}, 1, 64},
    Family{"sick_nav31x", &nav31x, 0, 360, {8}, {}, any, any},
    Family{"sick_oem15xx", &backward, 0, 360, {8}, {}, any, any},
    Family{"sick_lrs36x0", &backward, 0, 360, {8}, {}, any, any},
    Family{"sick_lrs36x1", &lrs36x1, 0, 360, {8}, {}, any, any},
    // Accept unlisted steps and rates. An LMS1xx turns at 25 or 50 Hz only.
    Family{"sick_lms5xx", &lms5xx, -5, 185, {}, {}, any, any},
    Family{"sick_lms1xx", &lms1xx, -45, 225, {25, 50}, {}, 1, 50},
    Family{"sick_tim5xx", &tim, -45, 225, {}, {}, 1, 25},
};
/// The number of families whose scans are known from devices; the last three accept unlisted values.
constexpr std::size_t known_families = families.size() - 3;

/// The sweep of the first family of that model; an MRS1000: sick_scan_xd's table of devices.
FieldOfView field_of(const Facts& facts) {
  if (facts.row->layered) return {-137.5, 0.25, 1101, {-2.5, 0, 2.5, 5}};
  const auto family = std::find_if(families.begin(), families.end(),
                                   [&](const Family& one) { return one.model == facts.name; });
  if (family == families.end()) return {};
  const double turn = family->end_deg - family->start_deg;
  const double step = family->step_deg[0] != any ? family->step_deg[0] : 0.25;
  const double first = facts.row->mirrored ? -turn / 2 : family->start_deg + facts.row->shift_deg;
  return {first, step, static_cast<std::size_t>(std::lround(turn / step)) + (turn < 360 ? 1 : 0)};
}

bool near_to(double a, double b, double tolerance) { return std::abs(a - b) <= tolerance; }

template <std::size_t Size>
bool is_among(const std::array<double, Size>& values, double value, double tolerance) {
  if (values[0] == any) return true;
  return std::any_of(values.begin(), values.end(),
                     [&](double each) { return each != any && near_to(each, value, tolerance); });
}

/// True for a full sweep of an LMS5xx, which is also a part of wider sweeps.
bool is_whole_lms5xx(const ColaEvidence& seen) {
  return near_to(seen.start_deg, -5, slack_deg) && near_to(seen.end_deg, 185, slack_deg);
}

/// False if the measurement frequency contradicts the telegrams per turn. An LMS5xx that interlaces its scans
/// (steps of 1/12 and 1/24 deg) also counts several.
bool fits_turn(const ColaRow& row, const ColaEvidence& seen) {
  if (row.turn == 1) return !near_to(seen.parts, 4, 0.2) || seen.step_deg < 0.1;
  return !near_to(seen.parts, 1, 0.05);
}

bool fits(const Family& family, const ColaEvidence& seen) {
  if ((seen.echoes & ~family.row->echoes) != 0 || !fits_turn(*family.row, seen)) return false;
  if (seen.start_deg < family.start_deg - slack_deg || seen.end_deg > family.end_deg + slack_deg)
    return false;
  if (is_whole_lms5xx(seen) && family.model != "sick_lms5xx") return false;
  if (family.most_mm != any && seen.scale_mm > family.most_mm) return false;
  // A device may exceed its range a little.
  if (family.farthest_m != any && seen.farthest_m > 1.1 * family.farthest_m) return false;
  return is_among(family.hz, seen.hz, 0.6) && is_among(family.step_deg, seen.step_deg, 1e-4);
}

/// Adds a telegram to the evidence. False if it has no distances.
bool add_scan(const ColaScan& scan, ColaEvidence& seen) {
  const ColaChannel* const distance = scan.echo_count() > 0 ? &scan.distance(0) : nullptr;
  if (distance == nullptr || distance->values.empty()) return false;
  seen.step_deg = exact_step_deg(distance->step_deg);
  seen.start_deg = distance->start_deg;
  seen.end_deg = distance->start_deg + seen.step_deg * static_cast<double>(distance->values.size() - 1);
  seen.hz = scan.scan_hz;
  seen.scale_mm = static_cast<double>(distance->scale);
  seen.named = cola_model_named(scan.name());
  for (std::size_t i = 0; i < distance_names.size(); ++i) {
    if (scan.channel(distance_names[i]) != nullptr) seen.echoes |= static_cast<std::uint8_t>(1U << i);
  }
  const bool complete = scan.measurement_hz > 0 && seen.step_deg > 0;
  seen.parts = complete ? scan.scan_hz * 360 / seen.step_deg / scan.measurement_hz : 0;
  for (std::size_t i = 0; i < distance->values.size(); ++i) {
    if (distance->values[i] >= first_distance)
      seen.farthest_m = std::max(seen.farthest_m, distance->value(i) * 1e-3);
  }
  return true;
}

/// Recognizes scanners that speak CoLa in the bytes of one sender, see make_cola_recognizer().
class ColaRecognizer final : public Recognizer {
 public:
  void add(const Packet& packet) override {
    if (packet.transport != Transport::tcp) return;
    if (packet.stream_start || packet.missing > 0) stream_.interrupt();
    missing_ += packet.missing;
    for (const std::string_view head : {"sSN LMDscandata", "sRA LMDscandata"})
      scan_heads_ += packet.payload.text().find(head) != std::string_view::npos ? 1U : 0U;
    stream_.add(packet.payload);
    for (ColaTelegram telegram; stream_.next(telegram);) inspect(telegram);
  }

  std::string_view verdict() const override { return verdict_; }
  std::vector<std::string_view> others() const override { return others_; }
  /// Reports scans that cannot be parsed.
  std::string remark() const override {
    if (!verdict_.empty() || scan_heads_ == 0) return {};
    std::string text =
        "LMDscandata of a SICK scanner (CoLa) begins " + std::to_string(scan_heads_) + " times, ";
    if (parsed_) return text + "but its angles, rate and ranges are those of no known model; set the model";
    text += "but none could be read: ";
    if (missing_ > 0)
      return text + std::to_string(missing_) +
             " bytes of the connection are not in the capture, so no telegram is complete; record again "
             "without loss";
    std::string reasons;
    for (std::size_t i = 0; i < reject_reasons; ++i) {
      if (counters_.rejected[i] > 0)
        reasons += (reasons.empty() ? "" : ", ") + std::to_string(counters_.rejected[i]) + " rejected for " +
                   to_string(static_cast<Reject>(i));
    }
    if (reasons.empty())
      return text + "no telegram is complete; is the capture truncated, or not of a scanner?";
    return text + reasons + "; report it with the device's firmware version";
  }

 private:
  void inspect(const ColaTelegram& telegram) {
    if (telegram.kind() == "sRA") note_answer(telegram);
    if (named_ || !is_cola_scan(telegram)) return;
    const Reject reason = parse_cola_scan(telegram, scan_);
    if (reason != Reject::none) return counters_.reject(reason);
    parsed_ = true;
    layered_ = layered_ || scan_.layer != 0;
    if (layered_) {
      verdict_ = is_plane_of_mrs1000(scan_.layer) ? "sick_mrs1000" : "";
      others_.clear();
      return;
    }
    if (add_scan(scan_, seen_)) choose();
  }

  /// Uses answers that name the device: DeviceIdent, DItype (type code) and index 0, the DeviceIdent of older
  /// drivers ("sRI 0"; two bytes in CoLa B, which is unverified); and MCAngleCompSin, by its size.
  void note_answer(const ColaTelegram& telegram) {
    const std::string_view name = telegram.name();
    const bool is_first = name == "0" || telegram.payload.text().substr(3, 2) == std::string_view("\0\0", 2);
    std::string_view model;
    if (is_first || name == "DeviceIdent" || name == "DItype")
      model = cola_model_named(telegram.payload.text().substr(4 + name.size()));
    if (name == angle_compensation && telegram.dialect == ColaDialect::b)
      model = telegram.arguments().size() == 12 ? "sick_nav2xx" : "sick_nav31x";
    if (model.empty()) return;
    verdict_ = model;
    named_ = true;
    others_.clear();
  }

  /// The families that fit everything seen so far.
  void choose() {
    verdict_ = {};
    others_.clear();
    for (std::size_t i = 0; i < families.size(); ++i) {
      if (i >= known_families && !verdict_.empty()) return;
      if (!fits(families[i], seen_)) continue;
      if (families[i].model == seen_.named) {
        verdict_ = seen_.named;
        return others_.clear();
      }
      if (verdict_.empty())
        verdict_ = families[i].model;
      else
        others_.push_back(families[i].model);
    }
  }

  Counters counters_;
  ColaStream stream_{counters_};
  ColaScan scan_;
  ColaEvidence seen_;
  std::string_view verdict_;
  std::vector<std::string_view> others_;
  std::uint64_t scan_heads_ = 0, missing_ = 0;
  bool parsed_ = false;   // at least one scan
  bool named_ = false;    // by the device itself
  bool layered_ = false;  // planes other than the horizontal one came
};

}  // namespace

void append_cola_models(std::vector<Model>& list) {
  for (const Facts& facts : all_facts) {
    list.push_back(model_of(facts));
    list.back().field = field_of(facts);
  }
}

/// The text may follow its length, in either dialect.
std::string_view cola_model_named(std::string_view identity) {
  for (const Identity& known : identities) {
    if (identity.substr(0, 16).find(known.begins) != std::string_view::npos) return known.model;
  }
  return {};
}

std::unique_ptr<Recognizer> make_cola_recognizer() { return std::make_unique<ColaRecognizer>(); }

}  // namespace lidard::sick
