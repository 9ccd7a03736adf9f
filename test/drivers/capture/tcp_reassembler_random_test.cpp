// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "test/drivers/capture/tcp_bench.h"

namespace lidard::test::segments {
namespace {

struct CutPiece {
  std::size_t begin, length;
};

/// Cuts `size` bytes into pieces, sends some twice or overlapping, and swaps them inside a window.
std::vector<CutPiece> pieces(std::size_t size, std::mt19937& rng) {
  const auto up_to = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n)(rng); };
  std::vector<CutPiece> out;
  for (std::size_t begin = 0; begin < size;) {
    const std::size_t length = std::min(size - begin, 1 + up_to(1500));
    out.push_back({begin, length});
    begin += length;
    if (up_to(4) == 0) out.push_back(out[out.size() - 1 - up_to(std::min<std::size_t>(out.size() - 1, 5))]);
    if (up_to(4) == 0) {  // put together anew, as a sender does that sends again
      const std::size_t from = begin - std::min(begin, up_to(4000));
      out.push_back({from, std::min(size - from, 1 + up_to(3000))});
    }
  }
  for (std::size_t i = 1; i + 1 < out.size(); ++i)
    std::swap(out[i], out[i + up_to(std::min<std::size_t>(8, out.size() - 1 - i))]);
  return out;
}

TEST(TcpReassembler, GivesTheSameBytesHoweverTheyWereSegmented) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937 rng(seed);
    std::string stream(20'000 + rng() % 60'000, '\0');
    for (char& c : stream) c = static_cast<char>(rng());
    const auto isn = static_cast<std::uint32_t>(seed % 3 == 0 ? 0xffffffffU - rng() % 60'000 : rng());
    TcpBench b;
    b.add(syn(isn - 1));
    double t = 0;
    for (const CutPiece& piece : pieces(stream.size(), rng)) {
      b.add(segment(isn + static_cast<std::uint32_t>(piece.begin),
                    std::string_view(stream).substr(piece.begin, piece.length)),
            t += 0.001);
    }
    ASSERT_TRUE(b.all() == stream) << "seed " << seed;
    EXPECT_EQ(b.streams.counters().missing, 0U) << "seed " << seed;
    EXPECT_EQ(b.streams.waiting(), 0U);
    EXPECT_TRUE(std::is_sorted(b.stamps.begin(), b.stamps.end()));
  }
}

TEST(TcpReassembler, PutsWhatIsThereInItsPlaceWhateverIsLost) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 rng(seed);
    std::string stream(50'000, '\0');
    for (char& c : stream) c = static_cast<char>(rng());
    TcpBench b;
    b.add(syn(41));
    for (const CutPiece& piece : pieces(stream.size(), rng)) {
      if (rng() % 10 == 0) continue;
      b.add(segment(42 + static_cast<std::uint32_t>(piece.begin),
                    std::string_view(stream).substr(piece.begin, piece.length)));
    }
    b.flush();
    std::size_t position = 0;
    std::uint64_t missing = 0;
    for (std::size_t i = 0; i < b.chunks.size(); ++i) {
      position += b.missing[i];
      missing += b.missing[i];
      ASSERT_EQ(stream.compare(position, b.chunks[i].size(), b.chunks[i]), 0) << "seed " << seed;
      position += b.chunks[i].size();
    }
    EXPECT_EQ(missing, b.streams.counters().missing);
    EXPECT_LE(position, stream.size());
  }
}

}  // namespace
}  // namespace lidard::test::segments
