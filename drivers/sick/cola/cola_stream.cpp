// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_stream.h"

#include <algorithm>

#include "core/base/float_bits.h"
#include "core/base/number_text.h"

namespace lidard::sick {
namespace {

// SICK 8014631 chapter 2: frames of both dialects.
constexpr std::uint8_t stx = 2;
constexpr std::uint8_t etx = 3;
constexpr std::size_t marks = 4;        // STX four times
constexpr std::size_t binary_head = 8;  // marks and length
constexpr std::size_t letters = 3;      // "sSN": the shortest begin of a command

bool is_upper(std::uint8_t c) { return c >= 'A' && c <= 'Z'; }

/// True if a command ("sRN", "sFA") may begin at `at`.
bool may_be_command(ByteView bytes, std::size_t at) {
  if (bytes.has(at, 1) && bytes.data()[at] != 's') return false;
  if (bytes.has(at + 1, 1) && !is_upper(bytes.data()[at + 1])) return false;
  return !bytes.has(at + 2, 1) || is_upper(bytes.data()[at + 2]);
}

}  // namespace

std::string_view ColaTelegram::name() const {
  const std::string_view text = payload.text();
  if (text.size() < 5 || text[3] != ' ') return {};
  const std::size_t end = text.find(' ', 4);
  return text.substr(4, end == std::string_view::npos ? end : end - 4);
}

ByteView ColaTelegram::arguments() const {
  const std::size_t begin = 4 + name().size() + 1;
  return begin < payload.size() ? payload.from(begin) : ByteView();
}

std::uint8_t ColaStream::checksum(ByteView payload) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : payload) sum = static_cast<std::uint8_t>(sum ^ byte);
  return sum;
}

void ColaStream::interrupt() {
  if (!buffer_.rest().empty()) ++counters_.incomplete;
  buffer_.clear();
  searched_ = 0;
  in_step_ = false;
  joined_ = true;
}

/// Counts consecutive bytes outside of telegrams as one rejection.
void ColaStream::skip_byte() {
  if (in_step_) {
    counters_.reject(Reject::magic);
  } else if (joined_) {
    ++counters_.incomplete;
  }
  in_step_ = false;
  joined_ = false;
  searched_ = 0;
  buffer_.drop(1);
}

bool ColaStream::next(ColaTelegram& telegram) {
  while (!buffer_.rest().empty()) {
    const ByteView rest = buffer_.rest();
    Find found = Find::nothing;
    std::size_t used = 0;
    if (rest.u8(0) == stx) {
      const bool text = rest.has(1, 1) && rest.u8(1) == 's';
      found = text ? find_text(rest, telegram, used) : find_binary(rest, telegram, used);
    }
    if (found == Find::more) return false;
    if (found == Find::telegram) {
      buffer_.drop(used);
      searched_ = 0;
      in_step_ = true;
      joined_ = false;
      return true;
    }
    skip_byte();
  }
  return false;
}

ColaStream::Find ColaStream::find_binary(ByteView rest, ColaTelegram& telegram, std::size_t& used) {
  for (std::size_t i = 0; i < std::min(marks, rest.size()); ++i) {
    if (rest.u8(i) != stx) return Find::nothing;
  }
  if (!may_be_command(rest, binary_head)) return Find::nothing;
  if (!rest.has(0, binary_head)) return Find::more;
  const std::size_t length = rest.be32(marks);
  if (length < letters || length > longest) return Find::nothing;
  if (!rest.has(binary_head, length + 1)) return Find::more;
  const ByteView payload = rest.sub(binary_head, length);
  if (checksum(payload) != rest.u8(binary_head + length)) {
    // A damaged length may span good telegrams: skip only the mark.
    counters_.reject(Reject::checksum);
    in_step_ = false;
    joined_ = false;
    return Find::nothing;
  }
  telegram = {ColaDialect::b, payload};
  used = binary_head + length + 1;
  return Find::telegram;
}

ColaStream::Find ColaStream::find_text(ByteView rest, ColaTelegram& telegram, std::size_t& used) {
  if (!may_be_command(rest, 1)) return Find::nothing;
  std::size_t end = std::max<std::size_t>(1, searched_);
  while (end < rest.size() && rest.data()[end] >= ' ') ++end;
  if (end > longest) return Find::nothing;
  if (end == rest.size()) {
    searched_ = end;
    return Find::more;
  }
  if (rest.u8(end) != etx || end < 1 + letters) return Find::nothing;
  telegram = {ColaDialect::a, rest.sub(1, end - 1)};
  used = end + 1;
  return Find::telegram;
}

namespace {

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : 99;
}

}  // namespace

std::uint32_t ColaBinaryReader::number(std::size_t size) {
  if (!bytes_.has(at_, size)) {
    ok_ = false;
    at_ = bytes_.size();
    return 0;
  }
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8U | bytes_.data()[at_ + i];
  at_ += size;
  return value;
}

float ColaBinaryReader::f32() { return float_of_bits<float>(number(4)); }

std::size_t ColaBinaryReader::text_size() {
  const std::uint8_t first = u8();
  return first != 0 ? first : u8();
}

std::string_view ColaBinaryReader::text(std::size_t size) {
  if (!bytes_.has(at_, size)) {
    ok_ = false;
    at_ = bytes_.size();
    return {};
  }
  const std::string_view found = bytes_.sub(at_, size).text();
  at_ += size;
  return found;
}

void ColaBinaryReader::values(std::size_t count, bool wide, std::vector<std::uint16_t>& out) {
  const std::size_t width = wide ? 2 : 1;
  out.clear();
  if (!bytes_.has(at_, count * width)) {
    ok_ = false;
    at_ = bytes_.size();
    return;
  }
  out.resize(count);
  const std::uint8_t* from = bytes_.data() + at_;
  for (std::size_t i = 0; i < count; ++i) {
    out[i] = wide ? static_cast<std::uint16_t>(from[2 * i] << 8U | from[2 * i + 1]) : from[i];
  }
  at_ += count * width;
}

std::string_view ColaTextReader::field() {
  while (!text_.empty() && text_.front() == ' ') text_.remove_prefix(1);
  const std::size_t end = std::min(text_.find(' '), text_.size());
  const std::string_view found = text_.substr(0, end);
  text_.remove_prefix(end);
  if (found.empty()) ok_ = false;
  return found;
}

/// Negative values are sent as the two's complement of their type, or with a sign.
std::uint32_t ColaTextReader::number(std::uint32_t highest) {
  std::string_view digits = field();
  const bool has_sign = !digits.empty() && (digits.front() == '+' || digits.front() == '-');
  const bool negative = has_sign && digits.front() == '-';
  if (has_sign) digits.remove_prefix(1);
  const int base = has_sign ? 10 : 16;
  std::uint64_t value = 0;
  if (digits.empty() || digits.size() > 10) ok_ = false;
  for (const char c : digits.substr(0, 10)) {
    const int digit = digit_of(c);
    if (digit >= base) ok_ = false;
    value = value * static_cast<std::uint64_t>(base) + static_cast<std::uint64_t>(digit);
  }
  if (value > highest) ok_ = false;
  if (!ok_) return 0;
  return static_cast<std::uint32_t>(negative ? 0 - value : value) & highest;
}

float ColaTextReader::f32() { return float_of_bits<float>(number(0xffffffff)); }

/// A text comes after its length and one blank; it may contain blanks.
std::string_view ColaTextReader::text(std::size_t size) {
  if (size == 0) return {};
  if (text_.size() < size + 1 || text_.front() != ' ') {
    // A name of fixed length is the first of the arguments, or comes after one blank.
    ok_ = false;
    return {};
  }
  const std::string_view found = text_.substr(1, size);
  text_.remove_prefix(size + 1);
  return found;
}

void ColaTextReader::values(std::size_t count, bool wide, std::vector<std::uint16_t>& out) {
  out.clear();
  // Every value has at least two characters, so a wrong count allocates no memory.
  if (count > text_.size()) {
    ok_ = false;
    return;
  }
  out.resize(count);
  const std::uint32_t highest = wide ? 0xffff : 0xff;
  for (std::size_t i = 0; i < count && ok_; ++i) out[i] = static_cast<std::uint16_t>(number(highest));
}

std::size_t ColaTextReader::left() const {
  std::size_t fields = 0;
  bool inside = false;
  for (const char c : text_) {
    if (c != ' ' && !inside) ++fields;
    inside = c != ' ';
  }
  return fields;
}

ColaWriter::ColaWriter(ColaDialect dialect, std::string_view command) : dialect_(dialect) {
  bytes_.assign(command.begin(), command.end());
}

/// Writes a blank; binary: only between the name and its arguments.
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
  std::vector<std::uint8_t> frame;
  if (dialect_ == ColaDialect::a) {
    frame.push_back(stx);
    frame.insert(frame.end(), bytes_.begin(), bytes_.end());
    frame.push_back(etx);
    return frame;
  }
  frame.assign(marks, stx);
  for (std::size_t i = 4; i-- > 0;)
    frame.push_back(static_cast<std::uint8_t>(bytes_.size() >> 8U * i & 0xffU));
  frame.insert(frame.end(), bytes_.begin(), bytes_.end());
  frame.push_back(ColaStream::checksum({bytes_.data(), bytes_.size()}));
  return frame;
}

std::uint8_t cola_error_code(const ColaTelegram& telegram) {
  // Binary: 16 bits directly after "sFA" without a blank (recorded from an LMS511).
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
      "the user level has no permission; set user_level and user_level_password",
      "the device does not know that method; its firmware or its family lacks it: check `model`",
      "the device does not know that variable; its firmware or its family lacks it: check `model`",
      "the device's state does not allow it now (starting, measuring, or in another mode); wait, or stop "
      "what else controls it (SOPAS ET)",
      "the value is not allowed; check what this type of device supports",
      "an error without a name; restart the device if it stays",
      "the device's buffer is too small for that telegram; report it with the firmware version",
      "the telegram was too short for the device; its firmware expects other arguments, report its version",
      "a type is unknown to the device; report it with the firmware version",
      "the setting may not be written at this user level; set user_level and user_level_password, and check "
      "whether the device is locked",
      "the device's name service does not know that command; report it with the firmware version",
      "the device does not know that command; check `model` and ip_port (a device with two ports may speak "
      "another language on each)",
      "the device is busy with another method; the request is repeated",
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
