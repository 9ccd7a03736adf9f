// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_status.h"

#include <array>

namespace lidard::hokuyo {
namespace {

struct Meaning {
  std::string_view status;
  std::string_view words;
  std::string_view remedy;
};

constexpr std::string_view check_range = "correct angle_min, angle_max, cluster or skip in the configuration";
constexpr std::string_view check_model = "check the model in the configuration and the sensor's firmware";
constexpr std::string_view report = "please report the sensor's firmware version";
constexpr std::string_view wait =
    "wait, it is asked again every second; if it stays, switch its power off and on";

// Hokuyo C-42-03320B p. 11 and p. 23 (SCIP 2.0); the second generation (SCIP 2.2: UST, UTM-30LX-EW) as
// hokuyolx and urg_stamped have it.
constexpr std::array<Meaning, 20> meanings = {{
    {"01", "the first step is no number, or the laser is broken", check_range},
    {"02", "the last step is no number", check_range},
    {"03", "the cluster is no number", check_range},
    {"04", "the last step is out of range", check_range},
    {"05", "the last step is below the first", check_range},
    {"06", "the interval is no number", check_range},
    {"07", "the number of scans is no number", check_range},
    {"0A", "it has no memory left to answer", wait},
    {"0B", "the buffer is full or the command was repeated before it was done", wait},
    {"0C", "the command is too short, or a parameter of it is wrong", report},
    {"0D", "the command is too long or unknown", report},
    {"0E", "it does not know the command", check_model},
    {"0F", "it does not support the command", check_model},
    {"0G", "the user string is too long", report},
    {"0H", "the user string or the command's length is wrong", report},
    {"0I", "it is in firmware update mode",
     "finish the update with the maker's tool, then switch its power off and on"},
    {"0L", "it is in an abnormal state",
     "switch its power off and on; if it comes back, look at it with the maker's tool (UrgBenriPlus)"},
    {"0M", "its measurement is not stable yet",
     "wait until its motor runs steadily; if it stays, check power supply and vibration"},
    {"10", "the laser is off or the sensor is busy in another mode",
     "wait, it is asked again every second; check that no other program is connected to it"},
    {"98", "it had stopped to check itself and measures again", "nothing to do"},
}};

bool is_number(std::string_view status, int& value) {
  if (status.size() != 2) return false;
  value = 0;
  for (const char c : status) {
    if (c < '0' || c > '9') return false;
    value = 10 * value + (c - '0');
  }
  return true;
}

}  // namespace

StatusClass class_of(std::string_view status) {
  if (status == "00") return StatusClass::accepted;
  if (status == "99") return StatusClass::data;
  if (status == "98") return StatusClass::resumed;
  if (status == "0E" || status == "0F") return StatusClass::unknown;
  int value = 0;
  if (!is_number(status, value)) return StatusClass::refused;
  if (value >= 50) return StatusClass::fault;
  return value >= 21 ? StatusClass::verifying : StatusClass::refused;
}

std::string explain_status(std::string_view command, std::string_view status) {
  const std::string what =
      "the sensor answers " + std::string(command) + " with status " + std::string(status) + ": ";
  switch (class_of(status)) {
    case StatusClass::verifying:
      return what +
             "it has stopped measuring to check an error; keep dirt and strong light off its window, it "
             "goes on by itself if the error does not last";
    case StatusClass::fault:
      return what +
             "it reports hardware trouble; switch its power off and on, and have it repaired if it "
             "comes back";
    default:
      break;
  }
  for (const Meaning& meaning : meanings) {
    if (meaning.status == status)
      return what + std::string(meaning.words) + "; " + std::string(meaning.remedy);
  }
  return what + "no document known here explains it; " + std::string(report);
}

}  // namespace lidard::hokuyo
