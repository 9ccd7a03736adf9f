// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "drivers/address.h"

namespace lidard::sim {

/// The settings of a SICK safety scanner behind its CoLa 2 port: bytes of one connection in, bytes out.
/// The telegrams are written from SICK 8022708 p. 28-47, the variables from the offsets that the vendor's
/// client reads (SICKAG/sick_safetyscanners_base, src/cola2 and src/data_processing): every variable that it
/// knows is here. Independent of the driver.
class SafetySettings {
 public:
  using Bytes = std::vector<std::uint8_t>;

  struct Output {
    bool enabled = false;
    IpAddress host = IpAddress::v4(192, 168, 0, 1);
    std::uint16_t port = 6060;
    std::uint16_t every = 1;
    std::int32_t start = 0, end = 0;  ///< 1/4194304 deg; both 0: all beams
    std::uint16_t features = 0x1f;
    std::uint8_t interface = 0;
  };

  /// What the scanner works out from its output's angles.
  struct Derived {
    std::uint16_t beams = 705;
    std::uint16_t scan_time_ms = 30;
    std::int32_t start = -199229440, step = 1635779;  ///< 1/4194304 deg
    std::uint32_t beam_period_us = 33;
  };

  std::string type_code = "MICS3-ACAZ40ZA1P01";
  std::string order_number = "1082012";
  std::string serial = "12345678";
  std::string firmware = "R 01.20";
  std::string device_name = "front left";
  std::string project_name = "yard";
  std::string application_name = "forklift";
  std::string user_name = "fitter";
  std::uint8_t device_status = 1;
  std::uint32_t power_cycles = 42;
  std::uint16_t user_action = 0;
  Derived derived;
  std::vector<std::string> fields;                            ///< names; all protective
  std::map<std::uint16_t, std::vector<std::uint16_t>> cases;  ///< field numbers by case number
  Output persistent;                                          ///< as Safety Designer wrote it
  Output current;                                             ///< lost at a power cycle
  std::uint8_t refuse_with = 0;                               ///< the result of every change; 0: it is made
  bool refuse_session = false;
  bool hides_output = false;    ///< refuses to tell its data output
  bool ignore_changes = false;  ///< accepted, but nothing happens
  bool mute = false;            ///< reads and never answers
  Bytes latest;                 ///< the latest measurement, as the data output sends it without its headers

  /// A new connection: nothing of the last one is left.
  void connect() { pending_.clear(); }
  void power_cycle();
  /// What the scanner answers to a chunk of what it is sent.
  Bytes answer(ByteView chunk);

  /// Everything understood so far: "open", "read 13", "call 176", "close".
  std::vector<std::string> heard;

 private:
  Bytes answer_one(ByteView telegram);
  Bytes variable(std::uint16_t index) const;
  Bytes fixed_variable(std::uint16_t index) const;
  std::uint8_t change(ByteView argument);

  Bytes pending_;
  std::uint32_t session_ = 0x12345;
};

}  // namespace lidard::sim
