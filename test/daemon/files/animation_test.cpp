// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Loops of pictures, read by the libraries that others read them with.
#include <gif_lib.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <webp/mux.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "daemon/commands/commands.h"
#include "daemon/files/numbered_path.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

/// Three pictures of the demo as a loop; the file goes when this goes.
struct Loop {
  explicit Loop(const std::string& ending)
      : file(::testing::TempDir() + "lidard-loop-" + std::to_string(getpid()) + ending) {
    SnapshotOptions options;
    options.config = project_file("config/demo.yaml");
    options.captures = {project_file("pcaps/demo.pcap")};
    options.animation = file;
    options.frames = 3;
    std::ostringstream said;
    EXPECT_EQ(run_snapshot(options, said), exit_ok) << said.str();
  }
  ~Loop() { std::remove(file.c_str()); }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  const std::string file;
};

/// The colour of the left scanner's returns.
bool is_blue(const GifColorType& c) {
  return std::abs(c.Red - 0) <= 30 && std::abs(c.Green - 115) <= 30 && std::abs(c.Blue - 179) <= 30;
}

TEST(Animation, MovesInAGif) {
  const Loop loop(".gif");
  GifFileType* gif = DGifOpenFileName(loop.file.c_str(), nullptr);
  ASSERT_NE(gif, nullptr);
  ASSERT_EQ(DGifSlurp(gif), GIF_OK);
  EXPECT_EQ(gif->ImageCount, 3);
  for (int i = 0; i < gif->ImageCount; ++i) {
    std::size_t blue = 0;
    for (int at = 0; at < gif->SWidth * gif->SHeight; ++at)
      blue += is_blue(gif->SColorMap->Colors[gif->SavedImages[i].RasterBits[at]]) ? 1U : 0U;
    EXPECT_GT(blue, 500U) << "picture " << i;
  }
  DGifCloseFile(gif, nullptr);
}

TEST(Animation, MovesInAWebp) {
  const Loop loop(".webp");
  std::ifstream file(loop.file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const WebPData data{reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
  WebPMux* mux = WebPMuxCreate(&data, 0);
  ASSERT_NE(mux, nullptr);
  int count = 0;
  EXPECT_EQ(WebPMuxNumChunks(mux, WEBP_CHUNK_ANMF, &count), WEBP_MUX_OK);
  EXPECT_EQ(count, 3);
  WebPMuxAnimParams loop_of{};
  EXPECT_EQ(WebPMuxGetAnimationParams(mux, &loop_of), WEBP_MUX_OK);
  EXPECT_EQ(loop_of.loop_count, 0) << "for ever";
  WebPMuxDelete(mux);
}

TEST(NumberedPathTest, FillsItsPlaceAsPrintfDoes) {
  EXPECT_EQ(NumberedPath::parse("a/%06d.pcd")->of(42), "a/000042.pcd");
  EXPECT_EQ(NumberedPath::parse("%d.pcd")->of(1234567), "1234567.pcd");
  EXPECT_EQ(NumberedPath::parse("a%3db")->of(7), "a  7b");
  for (const char* none : {"a.pcd", "100%.pcd", "%s.pcd", "%5.2d"})
    EXPECT_FALSE(NumberedPath::parse(none)) << none;
}

}  // namespace
}  // namespace lidard::test
