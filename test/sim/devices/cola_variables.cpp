// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/cola_variables.h"

#include <cstdio>
#include <initializer_list>

namespace lidard::sim {
namespace {

/// Recorded: an LMS111 and an LMS511 have 30 evaluation fields, a TiM781S has 48.
int field_count(const std::string& type) {
  if (type.rfind("TiM7", 0) == 0) return 48;
  return type.rfind("LMS", 0) == 0 ? 30 : 0;
}

}  // namespace

std::map<std::string, ColaVariable> cola_variables(Cola dialect, const std::string& type,
                                                   const std::string& version, std::uint32_t serial) {
  struct Number {
    std::uint32_t value;
    int bytes;
  };
  const auto numbers = [&](std::initializer_list<Number> all) {
    ColaWords words(dialect, "");
    for (const Number& each : all) words.number(each.value, each.bytes);
    return words.payload();
  };
  const auto text = [&](const std::string& letters) {
    return ColaWords(dialect, "").text(letters, 2).payload();
  };
  const ColaWords applications = ColaWords(dialect, "").number(1, 2).letters("RANG").number(1, 1);
  // Layouts as recorded devices answer (LMS111, LMS511, TiM781S, MRS1104, RMS1000) and as sick_scan_xd writes
  // (sick_scan_common.cpp, convertAscii2BinaryCmd). The order number is invented.
  std::map<std::string, ColaVariable> all = {
      {"SerialNumber", {text(std::to_string(serial))}},
      {"FirmwareVersion", {text(version)}},
      {"DItype", {text(type)}},
      {"OrdNum", {text("1000000")}},
      {"ODoprh", {numbers({{1042, 4}})}},  // 0.1 h
      {"ODpwrc", {numbers({{63, 4}})}},
      // Without fields and wiring: version, counter, four inputs, no time.
      {"LIDinputstate", {numbers({{0, 2}, {0, 4}, {0, 1}, {0, 1}, {0, 1}, {0, 1}, {0, 2}})}},
      {"LFErec", {numbers({{0, 2}})}},
      {"LocationName", {text("not defined"), true}},
      {"EIHstCola", {numbers({{dialect == Cola::binary ? 1U : 0U, 1}}), true}},
      {"FREchoFilter", {numbers({{1, 1}}), true}},
      {"SetActiveApplications", {applications.payload(), true}},
      {"ScanLayerFilter", {numbers({{4, 2}, {1, 1}, {1, 1}, {1, 1}, {1, 1}}), true}},
      {"LFPparticle", {numbers({{0, 1}, {500, 2}}), true}},
      {"LFPmeanfilter", {numbers({{0, 1}, {2, 2}, {0, 1}}), true}},
      {"LFPmedianfilter", {numbers({{0, 1}, {3, 2}}), true}},
      {"LICencset", {numbers({{0, 1}}), true}},
      {"LICencres", {numbers({{0x3F800000, 4}}), true}},
      {"LICsrc", {numbers({{0, 1}}), true}},
      {"DO3And4Fnc", {numbers({{0, 1}}), true}},
      {"FieldSetSelectionMethod", {numbers({{0, 1}}), true}},
      {"ActiveFieldSet", {numbers({{1, 2}}), true}},
      {"TSCRole", {numbers({{0, 1}}), true}},
      {"TSCTCInterface", {numbers({{0, 1}}), true}},
      {"TSCTCSrvAddr", {numbers({{192, 1}, {168, 1}, {0, 1}, {2, 1}}), true}},
      {"TSCTCupdatetime", {numbers({{600, 4}}), true}},
      {"TSCTCtimezone", {numbers({{12, 1}}), true}},
  };
  for (int i = 0; i < field_count(type); ++i) {
    char name[16];
    std::snprintf(name, sizeof name, "field%03d", i);
    all[name] = {numbers({{0, 1}})};
  }
  return all;
}

}  // namespace lidard::sim
