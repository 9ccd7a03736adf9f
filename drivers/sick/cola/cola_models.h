// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "drivers/driver.h"
#include "drivers/recognizer.h"

namespace lidard::sick {

/// Meaning of the telegram's "time since start up". SICK 8014631 says "time at the zero index before the
/// measurement itself starts"; the times of transmission beside it contradict that for some devices.
enum class ColaStamp : std::uint8_t { first_beam, last_beam };

/// What the answer to MCAngleCompSin means (sick_scan_xd 3.9.0, angle_compensator.cpp), a: the device's
/// angle. `subtracted`: a - A sin(a + P) - O (NAV2xx); `added`: a + A sin(a - P) + O (NAV3xx).
enum class AngleCompensation : std::uint8_t { none, subtracted, added };

/// Protocol properties of one device.
struct ColaRow {
  double shift_deg;              ///< added to the device's angle, so that 0 points ahead
  bool mirrored;                 ///< then the sign changes: the device counts clockwise
  ColaStamp stamp;               ///< meaning of the start time
  std::uint8_t turn;             ///< telegrams for each turn of the mirror
  std::uint8_t login;            ///< SOPAS user level that may write settings
  std::uint32_t password;        ///< its factory password, as SOPAS hashes it
  bool layered;                  ///< several planes, one telegram for each: a cloud
  std::uint8_t echoes = 1;       ///< bits of the echoes DIST1 ... that it can send
  bool zero_is_unknown = false;  ///< distance 0 does not say that nothing is there
  AngleCompensation compensation = AngleCompensation::none;
  bool reports_contamination =
      false;                  ///< answers LCMstate (SICK 8013796 p. 86; drivers of the LMS1xx ask it)
  std::string_view remark{};  ///< said once of a sensor: what sources disagree on
};

/// Adds the scanners that speak CoLa A and B over TCP to the table of models.
void append_cola_models(std::vector<Model>& list);
/// Recognizes such a scanner by DeviceIdent, else by angles, rates and distances of its scans. If several
/// families fit, others() lists those that were not chosen.
std::unique_ptr<Recognizer> make_cola_recognizer();
/// The search telegram of SICK devices (UDP 30718, as sick_scan_xd sends it; unverified on a device): 24
/// bytes; the answer is XML.
const Discovery& discovery();
/// The model of a device with this `identity` (DeviceIdent); empty if it contains no known name.
std::string_view cola_model_named(std::string_view identity);

/// Topics of the messages beside the scans, in Model::messages.
constexpr std::string_view topic_fields = "lferec";
constexpr std::string_view topic_outputs = "lidoutputstate";
constexpr std::string_view topic_inputs = "lidinputstate";
constexpr std::string_view topic_encoder = "encoder";

/// The driver of every scanner that speaks CoLa A or B; config.model->row is a ColaRow.
std::unique_ptr<Driver> make_cola_driver(const DriverConfig& config);

}  // namespace lidard::sick
