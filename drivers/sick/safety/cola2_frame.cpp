// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/cola2_frame.h"

#include <algorithm>

namespace lidard::sick {
namespace {

// SICK 8022708 p. 28: four STX, length, then HubCntr, NoC, session, request, command, which the length
// counts.
constexpr std::uint8_t stx = 0x02;
constexpr std::size_t stx_count = 4;
constexpr std::size_t length_end = 8;
constexpr std::size_t counted_header = 10;
/// No known variable is longer; a longer length is a stream out of step.
constexpr std::size_t longest = 0x10000;

void put_be(std::vector<std::uint8_t>& out, std::uint32_t value, unsigned bytes) {
  while (bytes-- > 0) out.push_back(static_cast<std::uint8_t>(value >> (8U * bytes)));
}

}  // namespace

std::vector<std::uint8_t> encode_cola2(const Cola2Telegram& t) {
  std::vector<std::uint8_t> out(stx_count, stx);
  put_be(out, static_cast<std::uint32_t>(counted_header + t.data.size()), 4);
  put_be(out, 0, 2);
  put_be(out, t.session, 4);
  put_be(out, t.request, 2);
  out.push_back(static_cast<std::uint8_t>(t.type));
  out.push_back(static_cast<std::uint8_t>(t.mode));
  out.insert(out.end(), t.data.begin(), t.data.end());
  return out;
}

std::size_t Cola2Stream::garbage() const {
  static constexpr std::uint8_t start[stx_count] = {stx, stx, stx, stx};
  const ByteView rest = buffer_.rest();
  const auto found = std::search(rest.begin(), rest.end(), std::begin(start), std::end(start));
  // A shorter run of STX at the end may be the beginning of the next telegram.
  const std::size_t run = rest.text().find_last_not_of(static_cast<char>(stx)) + 1;
  return found != rest.end() ? static_cast<std::size_t>(found - rest.begin()) : run;
}

bool Cola2Stream::next(Cola2Telegram& telegram) {
  for (;; buffer_.drop(1)) {
    buffer_.drop(garbage());
    const ByteView view = buffer_.rest();
    if (!view.has(0, length_end)) return false;
    const std::size_t length = view.be32(stx_count);
    if (length < counted_header || length > longest) continue;
    if (!view.has(length_end, length)) return false;
    telegram.session = view.be32(10);
    telegram.request = view.be16(14);
    telegram.type = static_cast<char>(view.u8(16));
    telegram.mode = static_cast<char>(view.u8(17));
    telegram.data = view.sub(length_end + counted_header, length - counted_header);
    buffer_.drop(length_end + length);
    return true;
  }
}

namespace {

/// Variables begin with a version; 'R' and 'Y' mark those that hold something (sick_safetyscanners_base,
/// src/data_processing).
bool has_version(ByteView variable, std::size_t length) {
  return variable.has(0, length) && (variable.u8(0) == 'R' || variable.u8(0) == 'Y');
}

char printable(std::uint8_t byte) { return byte >= 0x20 && byte < 0x7f ? static_cast<char>(byte) : '?'; }

std::string clean_text(ByteView letters) {
  std::string text;
  for (const std::uint8_t letter : letters) text += printable(letter);
  while (!text.empty() && (text.back() == ' ' || text.back() == '?')) text.pop_back();
  return text;
}

void put_le(std::vector<std::uint8_t>& out, std::size_t at, std::uint32_t value, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; ++i) out[at + i] = static_cast<std::uint8_t>(value >> (8U * i));
}

}  // namespace

std::optional<DataOutput> read_output(ByteView v) {
  if (!has_version(v, 26)) return std::nullopt;
  DataOutput output;
  output.enabled = v.u8(4) != 0;
  output.interface = v.u8(5);
  // Little endian: the last number of the address comes first (SICK 8022708 p. 40).
  output.host = IpAddress::v4(v.u8(11), v.u8(10), v.u8(9), v.u8(8));
  output.port = v.le16(12);
  output.every = v.le16(14);
  output.start = v.le32s(16);
  output.end = v.le32s(20);
  output.features = v.le16(24);
  return output;
}

std::vector<std::uint8_t> encode_output(const DataOutput& o, std::uint8_t channel) {
  std::vector<std::uint8_t> out(28, 0);
  out[0] = channel;
  out[4] = o.enabled ? 1 : 0;
  out[5] = o.interface;
  for (std::size_t i = 0; i < 4; ++i) out[8 + i] = o.host.bytes[3 - i];
  put_le(out, 12, o.port, 2);
  put_le(out, 14, o.every, 2);
  put_le(out, 16, static_cast<std::uint32_t>(o.start), 4);
  put_le(out, 20, static_cast<std::uint32_t>(o.end), 4);
  // Bits above 4 are reserved and refused (SICK 8022708 p. 41).
  put_le(out, 24, o.features & 0x1fU, 2);
  return out;
}

std::string describe(const DataOutput& o) {
  if (!o.enabled) return "off";
  std::string text = Endpoint{o.host, o.port}.to_string();
  text += o.every == 1 ? ", every scan" : ", 1 of " + std::to_string(o.every) + " scans";
  constexpr auto needed = DataOutput::needed_features;
  if ((o.features & needed) != needed) text += ", without derived values or measurement data";
  return text;
}

std::string read_text(ByteView v) {
  if (!v.has(0, 2)) return {};
  return clean_text(v.sub(2, std::min<std::size_t>(v.le16(0), v.size() - 2)));
}

// sick_safetyscanners_base, src/data_processing/ParseApplicationNameData.cpp
std::string read_versioned_text(ByteView v) {
  if (!v.has(0, 8)) return {};
  return clean_text(v.sub(8, std::min<std::size_t>(v.le32(4), v.size() - 8)));
}

// sick_safetyscanners_base, src/data_processing/ParseTypeCodeData.cpp
std::optional<std::uint8_t> interface_of(const std::string& type_code) {
  struct Row {
    const char* letters;
    std::uint8_t interface;
  };
  static constexpr Row rows[] = {{"ZA", 0}, {"AA", 0}, {"IZ", 1}, {"PZ", 3}, {"LZ", 3}, {"AN", 4}, {"EN", 4}};
  if (type_code.size() < 14) return std::nullopt;
  for (const Row& row : rows) {
    if (type_code.compare(12, 2, row.letters) == 0) return row.interface;
  }
  return std::nullopt;
}

double range_of(const std::string& type_code) {
  if (type_code.size() < 12) return 0;
  const std::string digits = type_code.substr(10, 2);
  if (digits == "30" || digits == "40" || digits == "55") return 40;
  return digits == "90" ? 64 : 0;
}

std::string describe_status(ByteView v) {
  if (!has_version(v, 58)) return "unreadable";
  const std::uint32_t error = v.le32(24);
  return "device state " + std::to_string(v.u8(4)) + ", configuration state " + std::to_string(v.u8(5)) +
         ", application state " + std::to_string(v.u8(6)) + ", powered on " + std::to_string(v.le32(12)) +
         " times, " + (error == 0 ? "no error" : "error code " + std::to_string(error));
}

std::string describe_action(ByteView v) {
  static constexpr const char* words[] = {"confirm the configuration", "check the configuration",
                                          "check the environment",     "check the application interfaces",
                                          "check the device",          "run the setup procedure",
                                          "check the firmware",        "wait"};
  if (!v.has(0, 2)) return "unreadable";
  const unsigned bits = v.le16(0);
  std::string text;
  for (unsigned i = 0; i < std::size(words); ++i) {
    if ((bits >> i & 1U) != 0) text += (text.empty() ? "" : ", ") + std::string(words[i]);
  }
  return text.empty() ? "none" : text;
}

std::string refusal_text(std::uint8_t result) {
  // SICK 8022708 p. 42
  constexpr std::array<const char*, 7> words = {
      "",
      "general error; is the scanner configured, and may data output be changed in Safety Designer?",
      "no channel is free; switch a data output off in Safety Designer",
      "the interface is not supported; please report the type code",
      "the start angle is not possible for this scanner",
      "the end angle is not possible for this scanner",
      "a reserved bit was set; please report the firmware version"};
  if (result < words.size()) return words.at(result);
  return "result " + std::to_string(result) + " is unknown; please report the firmware version";
}

}  // namespace lidard::sick
