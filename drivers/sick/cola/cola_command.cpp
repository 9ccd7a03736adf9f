// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_command.h"

#include "core/base/number_text.h"

namespace lidard::sick {

ColaWriter::ColaWriter(ColaDialect dialect, std::string_view command) : dialect_(dialect) {
  bytes_.assign(command.begin(), command.end());
}

/// Text: between all fields. Binary: between the name and its arguments only.
void ColaWriter::blank() {
  if (dialect_ == ColaDialect::a || !has_arguments_) bytes_.push_back(' ');
  has_arguments_ = true;
}

ColaWriter& ColaWriter::put(std::uint32_t value, std::size_t size) {
  blank();
  if (dialect_ == ColaDialect::b) {
    for (std::size_t i = size; i-- > 0;) bytes_.push_back(static_cast<std::uint8_t>(value >> 8U * i & 0xffU));
    return *this;
  }
  const std::string digits = printed("%X", value);
  bytes_.insert(bytes_.end(), digits.begin(), digits.end());
  return *this;
}

ColaWriter& ColaWriter::hash(std::uint32_t value) {
  if (dialect_ == ColaDialect::b) return u32(value);
  return letters(printed("%08X", value));
}

ColaWriter& ColaWriter::letters(std::string_view text) {
  blank();
  bytes_.insert(bytes_.end(), text.begin(), text.end());
  return *this;
}

std::vector<std::uint8_t> ColaWriter::finish() {
  // SICK 8014631 chapter 2.
  constexpr std::uint8_t stx = 2;
  constexpr std::uint8_t etx = 3;
  std::vector<std::uint8_t> frame;
  if (dialect_ == ColaDialect::a) {
    frame.push_back(stx);
    frame.insert(frame.end(), bytes_.begin(), bytes_.end());
    frame.push_back(etx);
    return frame;
  }
  frame.assign(4, stx);
  for (std::size_t i = 4; i-- > 0;)
    frame.push_back(static_cast<std::uint8_t>(bytes_.size() >> 8U * i & 0xffU));
  frame.insert(frame.end(), bytes_.begin(), bytes_.end());
  frame.push_back(ColaStream::checksum({bytes_.data(), bytes_.size()}));
  return frame;
}

std::uint8_t cola_error_code(const ColaTelegram& telegram) {
  // Binary: 16 bits right behind "sFA", recorded from an LMS511 without the blank that commands have.
  ByteView rest = telegram.payload.from(3);
  if (telegram.dialect == ColaDialect::a) {
    ColaTextReader in(rest);
    const std::uint16_t code = in.u16();
    return in.ok() ? static_cast<std::uint8_t>(code) : 0xff;
  }
  if (rest.size() == 3) rest = rest.from(1);
  return rest.size() == 2 ? rest.u8(1) : 0xff;
}

std::string cola_error_words(std::uint8_t code) {
  // Codes 0 to 26: SICK 8014631 chapter "Error codes" (names also in sick_scan_xd, SopasBase.cpp).
  constexpr std::array<const char*, 27> words = {
      "no error",
      "this user level may not do that; set user_level and user_level_password",
      "the device does not know that method; its firmware or its family lacks it: check `model`",
      "the device does not know that variable; its firmware or its family lacks it: check `model`",
      "the device's state does not allow it now (starting, measuring, or in another mode); wait, or stop "
      "what "
      "else controls it (SOPAS ET)",
      "the value is not allowed; check what this type of device supports",
      "an error without a name; restart the device if it stays",
      "the device's buffer is too small for that telegram; report it with the firmware version",
      "the telegram was too short for the device; its firmware expects other arguments, report its version",
      "a type is unknown to the device; report it with the firmware version",
      "the setting may not be written at this user level; set user_level and user_level_password, and look "
      "whether the device is locked",
      "the device's name service does not know that command; report it with the firmware version",
      "the device does not know that command; check `model` and ip_port (a device with two ports may speak "
      "another language on each)",
      "the device is busy with another method; it is asked again",
      "an array index is out of bounds; report it with the firmware version",
      "the device has no such event; its firmware or its family lacks it: check `model`",
      "a number was too large for the device's text dialect; report it with the firmware version",
      "the device found a character that its text dialect does not have; check that `ip_port` is the port of "
      "the text dialect",
      "the device's operating system sent no message; restart the device",
      "the device's operating system sent no answer; restart the device",
      "an internal error; restart the device",
      "the address of a hub is damaged; check the network between",
      "the address of a hub cannot be decoded; check the network between",
      "a hub's address is too long; check the network between",
      "a blank was expected in a hub's address; report it with the firmware version",
      "methods that take time are switched off; switch them on with SOPAS ET",
      "the device cannot handle arrays of that kind; report it with the firmware version"};
  if (code < words.size()) return words.at(code);
  return "an error code that SICK's telegram listing does not have; report it with the firmware version";
}

}  // namespace lidard::sick
