// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/files/animation.h"

#include <fcntl.h>
#include <gif_lib.h>
#include <webp/encode.h>
#include <webp/mux.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "daemon/files/text_file.h"

namespace lidard {
namespace {

/// Lossless: lines and letters stay sharp.
class WebpAnimation final : public Animation {
 public:
  WebpAnimation(std::string path, double seconds)
      : path_(std::move(path)), milliseconds_(static_cast<int>(std::lround(1000 * seconds))) {}
  ~WebpAnimation() override { WebPAnimEncoderDelete(encoder_); }
  WebpAnimation(const WebpAnimation&) = delete;
  WebpAnimation& operator=(const WebpAnimation&) = delete;

  void add(const Pixels& picture) override {
    if (encoder_ == nullptr) begin(picture);
    WebPPicture frame;
    expect(WebPPictureInit(&frame) != 0);
    frame.use_argb = 1;
    frame.width = picture.width;
    frame.height = picture.height;
    expect(WebPPictureAlloc(&frame) != 0);
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x)
        frame.argb[y * frame.argb_stride + x] =
            0xff000000U | picture.rgb[static_cast<std::size_t>(y * picture.width + x)];
    }
    const bool taken = WebPAnimEncoderAdd(encoder_, &frame, milliseconds_ * frames_++, &config_) != 0;
    WebPPictureFree(&frame);
    expect(taken);
  }
  void finish() override {
    expect(encoder_ != nullptr &&
           WebPAnimEncoderAdd(encoder_, nullptr, milliseconds_ * frames_, nullptr) != 0);
    WebPData data;
    WebPDataInit(&data);
    const bool whole = WebPAnimEncoderAssemble(encoder_, &data) != 0;
    const std::string bytes(reinterpret_cast<const char*>(data.bytes), data.size);
    WebPDataClear(&data);
    expect(whole);
    TextFile file(path_);
    file.write(bytes);
    file.close();
  }

 private:
  void begin(const Pixels& picture) {
    WebPAnimEncoderOptions options;
    expect(WebPAnimEncoderOptionsInit(&options) != 0 && WebPConfigInit(&config_) != 0 &&
           WebPConfigLosslessPreset(&config_, 3) != 0);
    encoder_ = WebPAnimEncoderNew(picture.width, picture.height, &options);
    expect(encoder_ != nullptr);
  }
  void expect(bool well) const {
    if (!well)
      throw std::runtime_error(
          path_ + ": libwebp cannot make the animation" +
          (encoder_ == nullptr ? "" : std::string(": ") + WebPAnimEncoderGetError(encoder_)));
  }

  std::string path_;
  int milliseconds_;
  int frames_ = 0;
  WebPAnimEncoder* encoder_ = nullptr;
  WebPConfig config_{};
};

/// 256 colours, chosen for the first picture.
class GifAnimation final : public Animation {
 public:
  GifAnimation(std::string path, double seconds)
      : path_(std::move(path)), hundredths_(static_cast<int>(std::lround(100 * seconds))) {}
  ~GifAnimation() override {
    if (file_ != nullptr) EGifCloseFile(file_, nullptr);
  }
  GifAnimation(const GifAnimation&) = delete;
  GifAnimation& operator=(const GifAnimation&) = delete;

  void add(const Pixels& picture) override {
    if (file_ == nullptr) begin(picture);
    GraphicsControlBlock control{DISPOSE_DO_NOT, false, std::max(2, hundredths_), NO_TRANSPARENT_COLOR};
    std::array<GifByteType, 4> block{};
    const std::size_t size = EGifGCBToExtension(&control, block.data());
    expect(EGifPutExtension(file_, GRAPHICS_EXT_FUNC_CODE, static_cast<int>(size), block.data()));
    expect(EGifPutImageDesc(file_, 0, 0, picture.width, picture.height, false, nullptr));
    std::vector<GifByteType> row(static_cast<std::size_t>(picture.width));
    for (std::size_t y = 0; y < static_cast<std::size_t>(picture.height); ++y) {
      for (std::size_t x = 0; x < row.size(); ++x) row[x] = nearest(picture.rgb[y * row.size() + x]);
      expect(EGifPutLine(file_, row.data(), picture.width));
    }
  }
  void finish() override {
    GifFileType* file = file_;
    file_ = nullptr;
    expect(file == nullptr ? GIF_ERROR : EGifCloseFile(file, nullptr));
  }

 private:
  void begin(const Pixels& picture) {
    std::vector<GifByteType> red, green, blue;
    for (const std::uint32_t pixel : picture.rgb) {
      red.push_back(static_cast<GifByteType>(pixel >> 16U));
      green.push_back(static_cast<GifByteType>(pixel >> 8U));
      blue.push_back(static_cast<GifByteType>(pixel));
    }
    std::vector<GifByteType> ignored(picture.rgb.size());
    int colors = static_cast<int>(palette_.size());
    expect(GifQuantizeBuffer(static_cast<unsigned>(picture.width), static_cast<unsigned>(picture.height),
                             &colors, red.data(), green.data(), blue.data(), ignored.data(),
                             palette_.data()));
    ColorMapObject* map = GifMakeMapObject(static_cast<int>(palette_.size()), palette_.data());
    // Opened here: giflib would make a file that its owner alone can read.
    const int fd = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    file_ = fd < 0 ? nullptr : EGifOpenFileHandle(fd, nullptr);
    if (file_ == nullptr) {
      GifFreeMapObject(map);
      throw std::runtime_error(path_ + ": cannot be opened for writing: " + std::strerror(errno));
    }
    EGifSetGifVersion(file_, true);
    const int written = EGifPutScreenDesc(file_, picture.width, picture.height, 8, 0, map);
    GifFreeMapObject(map);
    expect(written);
    // The loop, as browsers read it: extension NETSCAPE2.0, sub-block 1, 0 rounds: for ever.
    const std::array<GifByteType, 3> forever{1, 0, 0};
    expect(EGifPutExtensionLeader(file_, APPLICATION_EXT_FUNC_CODE));
    expect(EGifPutExtensionBlock(file_, 11, "NETSCAPE2.0"));
    expect(EGifPutExtensionBlock(file_, static_cast<int>(forever.size()), forever.data()));
    expect(EGifPutExtensionTrailer(file_));
  }
  /// The palette's colour for a pixel; what was looked up is kept, by five bits of each colour.
  GifByteType nearest(std::uint32_t pixel) {
    const std::uint32_t key = (pixel >> 9U & 0x7c00U) | (pixel >> 6U & 0x3e0U) | (pixel >> 3U & 0x1fU);
    if (known_[key] >= 0) return static_cast<GifByteType>(known_[key]);
    int best = 0;
    int least = 1 << 30;
    for (std::size_t i = 0; i < palette_.size(); ++i) {
      const int red = palette_[i].Red - static_cast<int>(pixel >> 16U & 255U);
      const int green = palette_[i].Green - static_cast<int>(pixel >> 8U & 255U);
      const int blue = palette_[i].Blue - static_cast<int>(pixel & 255U);
      const int distance = red * red + green * green + blue * blue;
      if (distance < least) least = distance, best = static_cast<int>(i);
    }
    known_[key] = static_cast<std::int16_t>(best);
    return static_cast<GifByteType>(best);
  }
  void expect(int result) const {
    if (result == GIF_ERROR)
      throw std::runtime_error(path_ + ": giflib cannot write the animation; is the disk full?");
  }

  std::string path_;
  int hundredths_;
  GifFileType* file_ = nullptr;
  std::array<GifColorType, 256> palette_{};
  std::vector<std::int16_t> known_ = std::vector<std::int16_t>(1U << 15U, -1);
};

}  // namespace

std::unique_ptr<Animation> make_animation(const std::string& path, double seconds) {
  const bool gif = path.size() > 4 && path.compare(path.size() - 4, 4, ".gif") == 0;
  if (gif) return std::make_unique<GifAnimation>(path, seconds);
  return std::make_unique<WebpAnimation>(path, seconds);
}

}  // namespace lidard
