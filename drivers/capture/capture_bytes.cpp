// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/capture_bytes.h"

#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include <array>
#include <new>

#include "core/base/bytes.h"

namespace lidard {
namespace {

/// RFC 1952, one member after the other.
class Gzip final : public Codec {
 public:
  Gzip() {
    // 15: the largest window; 16 more: a gzip header and its checksum (zlib.h, inflateInit2).
    if (inflateInit2(&stream_, 15 + 16) != Z_OK) throw std::bad_alloc();
  }
  ~Gzip() override { inflateEnd(&stream_); }
  Gzip(const Gzip&) = delete;
  Gzip& operator=(const Gzip&) = delete;

  const char* run(PackedBytes& b) override {
    if (complete_ && b.in_left == 0) return nullptr;
    if (complete_) inflateReset(&stream_);
    stream_.next_in = const_cast<Bytef*>(b.in);  // zlib has no const
    stream_.avail_in = static_cast<uInt>(b.in_left);
    stream_.next_out = b.out;
    stream_.avail_out = static_cast<uInt>(b.out_left);
    const int result = inflate(&stream_, Z_NO_FLUSH);
    b = {stream_.next_in, stream_.avail_in, stream_.next_out, stream_.avail_out};
    complete_ = result == Z_STREAM_END;
    if (complete_ || result == Z_OK || result == Z_BUF_ERROR) return nullptr;
    return stream_.msg != nullptr ? stream_.msg : zError(result);
  }
  bool complete() const override { return complete_; }
  const char* name() const override { return "gzip"; }

 private:
  z_stream stream_{};
  bool complete_ = false;
};

/// RFC 8878, one frame after the other.
class Zstd final : public Codec {
 public:
  Zstd() : stream_(ZSTD_createDStream()) {
    if (stream_ == nullptr) throw std::bad_alloc();
  }
  ~Zstd() override { ZSTD_freeDStream(stream_); }
  Zstd(const Zstd&) = delete;
  Zstd& operator=(const Zstd&) = delete;

  const char* run(PackedBytes& b) override {
    if (complete_ && b.in_left == 0) return nullptr;
    ZSTD_inBuffer in{b.in, b.in_left, 0};
    ZSTD_outBuffer out{b.out, b.out_left, 0};
    const std::size_t result = ZSTD_decompressStream(stream_, &out, &in);
    b = {b.in + in.pos, b.in_left - in.pos, b.out + out.pos, b.out_left - out.pos};
    complete_ = result == 0;
    return ZSTD_isError(result) != 0U ? ZSTD_getErrorName(result) : nullptr;
  }
  bool complete() const override { return complete_; }
  const char* name() const override { return "zstd"; }

 private:
  ZSTD_DStream* stream_;
  bool complete_ = false;
};

std::unique_ptr<Codec> codec_for(ByteView magic) {
  // RFC 1952 section 2.3.1; RFC 8878 sections 3.1.1 and 3.1.2 (skippable frames).
  if (magic.be16(0) == 0x1f8b) return std::make_unique<Gzip>();
  if (magic.le32(0) == 0xfd2fb528U || (magic.le32(0) & 0xfffffff0U) == 0x184d2a50U)
    return std::make_unique<Zstd>();
  return nullptr;
}

}  // namespace

CaptureBytes::CaptureBytes(int fd) : fd_(fd) {
  std::array<std::uint8_t, 4> magic{};
  if (::pread(fd_, magic.data(), magic.size(), 0) == 4) codec_ = codec_for({magic.data(), magic.size()});
  if (codec_ != nullptr) buffer_.resize(65'536);
}

ssize_t CaptureBytes::read(std::uint8_t* out, std::size_t size) {
  if (codec_ != nullptr) return read_packed(out, size);
  const ssize_t got = ::pread(fd_, out, size, static_cast<off_t>(position_));
  if (got > 0) position_ += static_cast<std::uint64_t>(got);
  return got;
}

ssize_t CaptureBytes::read_packed(std::uint8_t* out, std::size_t size) {
  if (!error_.empty()) return -1;
  bytes_.out = out;
  bytes_.out_left = size;
  while (bytes_.out_left == size) {
    if (bytes_.in_left == 0 && !file_ended_) {
      const ssize_t got = ::pread(fd_, buffer_.data(), buffer_.size(), static_cast<off_t>(position_));
      if (got < 0) return -1;
      file_ended_ = got == 0;
      position_ += static_cast<std::uint64_t>(got);
      bytes_.in = buffer_.data();
      bytes_.in_left = static_cast<std::size_t>(got);
    }
    const std::size_t before = bytes_.in_left;
    const char* wrong = codec_->run(bytes_);
    if (wrong != nullptr) return fail(std::string("is damaged, ") + wrong);
    if (bytes_.out_left < size) break;
    if (file_ended_) return codec_->complete() ? 0 : fail("was cut off");
    if (before > 0 && bytes_.in_left == before) return fail("is damaged, nothing can be unpacked");
  }
  return static_cast<ssize_t>(size - bytes_.out_left);
}

ssize_t CaptureBytes::fail(const std::string& what) {
  error_ = std::string("the ") + codec_->name() + " file " + what + ", at byte " +
           std::to_string(position_ - bytes_.in_left);
  return -1;
}

}  // namespace lidard
