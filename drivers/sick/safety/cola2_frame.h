// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "drivers/address.h"
#include "drivers/stream_buffer.h"

namespace lidard::sick {

/// One CoLa 2 telegram (SICK 8022708 p. 28-30). No checksum; numbers of the header big endian, of the data
/// little endian.
struct Cola2Telegram {
  std::uint32_t session = 0;  ///< 0 in the request that opens one
  std::uint16_t request = 0;  ///< repeated in the answer
  char type = 0;  ///< 'O' open, 'C' close, 'R' read, 'M' method; 'A' answer of a method, 'F' refusal
  char mode = 0;  ///< 'X' session request, 'I' by index, 'A' answer
  ByteView data;

  bool is(char t, char m) const { return type == t && mode == m; }
};

/// The telegram as bytes.
std::vector<std::uint8_t> encode_cola2(const Cola2Telegram& telegram);

/// Finds telegrams in a stream of chunks of any size; other bytes are skipped.
class Cola2Stream {
 public:
  void add(ByteView chunk) { buffer_.add(chunk); }
  /// False if there is no complete telegram. The view is valid until the next call of add() or clear().
  bool next(Cola2Telegram& telegram);
  void clear() { buffer_.clear(); }

 private:
  std::size_t garbage() const;

  StreamBuffer buffer_;
};

/// Indices of variables and methods of the safety scanners (SICK 8022708 p. 31-47 and
/// sick_safetyscanners_base, src/cola2).
namespace safety_index {
constexpr std::uint16_t serial_number = 3;
constexpr std::uint16_t firmware = 4;
constexpr std::uint16_t type_code = 13;
constexpr std::uint16_t user_action = 16;
constexpr std::uint16_t device_name = 17;
constexpr std::uint16_t project_name = 18;
constexpr std::uint16_t status_overview = 23;
constexpr std::uint16_t application_name = 33;
constexpr std::uint16_t current_output = 178;
constexpr std::uint16_t change_output = 176;  ///< a method
}  // namespace safety_index

/// Settings of a scanner's data output.
struct DataOutput {
  bool enabled = false;
  std::uint8_t interface = 0;  ///< 0 EFI-pro, 1 EtherNet/IP, 3 PROFINET, 4 non-safe Ethernet
  IpAddress host;
  std::uint16_t port = 0;
  std::uint16_t every = 1;          ///< every n-th scan is sent
  std::int32_t start = 0, end = 0;  ///< 1/4194304 deg, device frame; both 0: all beams
  std::uint16_t features =
      0;  ///< bit 0 system state, 1 derived values, 2 measurement, 3 intrusion, 4 application

  static constexpr std::uint16_t needed_features = 1U << 1U | 1U << 2U;
};

/// Reads the current configuration of a data output; empty if it is too short or of another version.
std::optional<DataOutput> read_output(ByteView variable);
/// The argument of the method that changes a data output, 28 bytes.
std::vector<std::uint8_t> encode_output(const DataOutput& output, std::uint8_t channel);
/// "192.168.0.1:6060, every scan".
std::string describe(const DataOutput& output);

/// A text variable: length of two bytes, then characters. Unprintable ones become '?'.
std::string read_text(ByteView variable);
/// A text variable with a version: four bytes of it, a length of four bytes, then characters.
std::string read_versioned_text(ByteView variable);
/// The interface that the characters 13 and 14 of a type code stand for; empty if unknown.
std::optional<std::uint8_t> interface_of(const std::string& type_code);
/// The measuring range in m that the characters 11 and 12 of a type code stand for; 0 if unknown.
double range_of(const std::string& type_code);

/// The status overview in words, for diagnostics. The meaning of the state numbers is not published.
std::string describe_status(ByteView variable);
/// The user action that the scanner requires, in words; "none".
std::string describe_action(ByteView variable);

/// Why a change of the data output was refused, with the remedy; empty if it was accepted.
std::string refusal_text(std::uint8_t result);

}  // namespace lidard::sick
