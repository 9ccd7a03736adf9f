// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_models.h"

#include "drivers/sick/cola/cola_driver.h"

namespace lidard::sick {
namespace {

// SICK 8014631 chapter 4.1: user level 3 is "authorized client". Passwords of the factory setting.
constexpr std::uint8_t authorized_client = 3;
constexpr std::uint32_t usual_password = 0xF4724744;
constexpr std::uint32_t tim7xxs_password = 0x6FD62C05;

// Shifts and mirroring: sick_scan_xd 3.9.0, sick_generic_parser.cpp 553-1018. Only those of TiM7xx, LMS1xx,
// LMS5xx and MRS1000 were seen in recordings, whose angles fit; the others are unverified.
//
// Stamps: LMS111 and TiM781 transmit 3 and 6 ms after their time stamp, but their sweeps take 15 and 50 ms:
// the stamp cannot be that of the first beam sent; taken for the last one's. MRS1104 transmits 64 ms after
// it, its sweep takes 61 ms: the first beam. LMS511: 40 ms, sweep 21 ms: taken for the first beam. What is
// not named here is unverified, as is the part of a turn that each may be off.
constexpr ColaRow row(double shift_deg, bool mirrored, ColaStamp stamp,
                      std::uint32_t password = usual_password) {
  return {shift_deg, mirrored, stamp, 1, authorized_client, password, false};
}
constexpr ColaRow lms1xx = row(-90, false, ColaStamp::last_beam);
constexpr ColaRow lms5xx = row(-90, false, ColaStamp::first_beam);
constexpr ColaRow lms4000 = row(-90, false, ColaStamp::first_beam);
constexpr ColaRow tim240 = row(0, false, ColaStamp::last_beam);
constexpr ColaRow tim = row(-90, false, ColaStamp::last_beam);
constexpr ColaRow tim7xxs = row(-90, false, ColaStamp::last_beam, tim7xxs_password);
constexpr ColaRow lrs36x0 = row(90, true, ColaStamp::first_beam);
constexpr ColaRow lrs36x1 = row(-180, false, ColaStamp::first_beam);
constexpr ColaRow nav2xx = row(0, false, ColaStamp::first_beam);
constexpr ColaRow nav31x = row(0, true, ColaStamp::first_beam);
// Four measuring modules turn together, each sends its sweep: four telegrams a turn (SICK 8020494, p. 24).
constexpr ColaRow lms1000 = {-90, false, ColaStamp::first_beam, 4, authorized_client, usual_password, false};
constexpr ColaRow mrs1000 = {-90, false, ColaStamp::first_beam, 4, authorized_client, usual_password, true};

constexpr std::uint16_t usual_port = 2112;
constexpr std::uint16_t other_port = 2111;
constexpr const char* unverified = "simulator only; no capture of a device";

struct Facts {
  const char* name;
  const char* product;
  const ColaRow* row;
  double hz;                    ///< telegrams per second, usual
  double range_min, range_max;  ///< m
  bool has_echoes;
  const char* verified;
  std::uint16_t port = usual_port;
};

// Ranges: the products' data sheets, the largest of each family; the near ends are those of what devices
// were seen to send (an LMS111 tells 0.08 m, an MRS1104 16 mm). Unverified.
constexpr Facts all_facts[] = {
    {"sick_lms1xx", "LMS1xx", &lms1xx, 50, 0.05, 50, true, "1 capture (LMS111), telegrams of an LMS151"},
    {"sick_lms5xx", "LMS5xx", &lms5xx, 25, 0.05, 80, true, "1 capture (LMS511), single answers in CoLa A"},
    {"sick_lms1000", "LMS1000", &lms1000, 50, 0.05, 64, true, unverified},
    {"sick_lms4000", "LMS4000", &lms4000, 600, 0.5, 3.5, false, unverified},
    {"sick_tim240", "TiM240", &tim240, 14.5, 0.05, 10, false, unverified, other_port},
    {"sick_tim4xx", "TiM4xx", &tim, 15, 0.05, 25, false, unverified},
    {"sick_tim5xx", "TiM5xx", &tim, 15, 0.05, 25, false, "1 telegram of CoLa A"},
    {"sick_tim7xx", "TiM7xx", &tim, 15, 0.05, 25, false, "2 captures (TiM781S)"},
    {"sick_tim7xxs", "TiM7xxS", &tim7xxs, 15, 0.05, 25, false, "2 captures (TiM781S)"},
    {"sick_lrs36x0", "LRS36x0", &lrs36x0, 8, 0.5, 250, false, unverified},
    {"sick_lrs36x1", "LRS36x1", &lrs36x1, 15, 0.5, 250, false, unverified},
    {"sick_nav2xx", "NAV2xx", &nav2xx, 25, 0.1, 50, false, unverified},
    {"sick_nav31x", "NAV31x", &nav31x, 8, 0.5, 250, false, unverified, other_port},
    {"sick_oem15xx", "OEM15xx", &nav31x, 8, 0.5, 250, false, unverified, other_port},
    {"sick_mrs1000", "MRS1000", &mrs1000, 50, 0.016, 64, true,
     "2 captures (MRS1104), one beside the clouds that SICK's own driver published of it"},
};

Model model_of(const Facts& facts) {
  Model model;
  model.name = facts.name;
  model.vendor = "SICK";
  model.product = facts.product;
  model.protocol = "CoLa A/B";
  model.kind = facts.row->layered ? FrameKind::cloud : FrameKind::scan;
  model.transport = Transport::tcp;
  model.port = facts.port;
  model.packets_per_s = facts.hz;
  model.frame_period = (facts.row->layered ? facts.row->turn : 1) / facts.hz;
  model.range_min = facts.range_min;
  model.range_max = facts.range_max;
  model.beams = facts.row->layered ? facts.row->turn : 0;
  model.verified = facts.verified;
  model.row = facts.row;
  model.make = make_cola_driver;
  model.traits = {Trait::settings_writable, Trait::logins, Trait::skip_setting, Trait::states_on_request};
  if (facts.has_echoes && !facts.row->layered) model.traits.add(Trait::echoes);
  for (const std::string_view topic : {topic_fields, topic_outputs, topic_inputs, topic_encoder})
    model.messages.push_back(message_topic<DeviceState>(topic));
  return model;
}

}  // namespace

void append_cola_models(std::vector<Model>& list) {
  for (const Facts& facts : all_facts) list.push_back(model_of(facts));
}

}  // namespace lidard::sick
