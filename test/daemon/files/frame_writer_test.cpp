// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What decode writes: numbers in the very characters of fmt, a document per line, points that others can
// read.
#include "daemon/files/frame_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "daemon/commands/commands.h"
#include "daemon/files/row_text.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class Written : public ::testing::Test {
 protected:
  Written() { fs::create_directories(folder_); }
  ~Written() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  std::string decode(const std::string& format, const std::string& name, int expected = exit_ok) {
    DecodeOptions options;
    options.capture = project_file("pcaps/vlp32c.pcap");
    options.format = format;
    options.output = path(name);
    std::ostringstream err;
    EXPECT_EQ(run_decode(options, err), expected) << err.str();
    return err.str();
  }
  const std::string folder_ = ::testing::TempDir() + "lidard-written-" + std::to_string(getpid());
};

TEST_F(Written, NumbersHaveTheCharactersOfFmt) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> mantissa(-1, 1);
  std::vector<double> values{0.0,
                             -0.0,
                             0.5,
                             1.5,
                             2.5,
                             0.00005,
                             0.000005,
                             1e5,
                             123456.7,
                             1e9,
                             -1e18,
                             0.03125,
                             99.999995,
                             std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()};
  for (int i = 0; i < 200'000; ++i) {
    const double scale = std::pow(10, static_cast<int>(random() % 9) - 3);
    values.push_back(mantissa(random) * scale);
    // In the middle between two numbers of four and five digits, where rounding is to the even one.
    values.push_back(static_cast<double>(static_cast<std::int64_t>(random() % 2'000'000) - 1'000'000) /
                     32768);
    values.push_back((static_cast<double>(random() % 20'000'000) + 0.5) / 1e5);
  }
  RowText rows(path("rows"));
  fmt::memory_buffer expected;
  for (const double value : values) {
    rows.fixed<4>(value).put(' ').fixed<5>(value).put(' ').fixed<7>(value).put(' ');
    rows.shortest(static_cast<float>(value))
        .put(' ')
        .shortest(std::round(static_cast<float>(value)))
        .put('\n');
    rows.flush_if_long();
    fmt::format_to(std::back_inserter(expected), "{:.4f} {:.5f} {:.7f} {:g} {:g}\n", value, value, value,
                   static_cast<float>(value), std::round(static_cast<float>(value)));
  }
  rows.integer(std::numeric_limits<std::int64_t>::min()).put(' ').integer(7U);
  rows.close();
  EXPECT_TRUE(content(path("rows")) == fmt::to_string(expected) + "-9223372036854775808 7");
}

TEST_F(Written, JsonIsADocumentPerLineWithTheRowsOfTheCsv) {
  decode("csv", "o.csv");
  decode("json", "o.json");
  std::istringstream rows(content(path("o.csv"))), documents(content(path("o.json")));
  std::string row, document;
  std::getline(rows, row);
  std::size_t frames = 0;
  while (std::getline(documents, document)) {
    const auto frame = nlohmann::json::parse(document);
    EXPECT_EQ(frame["frame"], frames++);
    for (const auto& cells : frame["rows"]) {
      ASSERT_TRUE(std::getline(rows, row));
      ASSERT_EQ(cells.size(), frame["columns"].size());
      const std::string x = fmt::format("{:.5f}", cells[8].get<float>());
      ASSERT_THAT(row, HasSubstr("," + x + ",")) << document.substr(0, 200);
    }
  }
  EXPECT_FALSE(std::getline(rows, row)) << "a row that JSON lacks";
  EXPECT_GT(frames, 1U);
}

TEST_F(Written, PcdHasAFileForEachFrameWhereTheNameIsAPattern) {
  const std::string said = decode("pcd", "%04d.pcd");
  std::size_t files = 0, points = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    const std::string text = content(entry.path());
    EXPECT_THAT(text.substr(0, 400), HasSubstr("DATA binary_compressed"));
    points += std::strtoul(text.c_str() + text.find("POINTS ") + 7, nullptr, 10);
    ++files;
  }
  EXPECT_THAT(said,
              HasSubstr(": " + std::to_string(files) + " frames, " + std::to_string(points) + " returns"));
  EXPECT_TRUE(fs::exists(path("0001.pcd")));
  EXPECT_THAT(decode("csv", "%04d.csv", exit_usage), HasSubstr("--format pcd alone"));
  EXPECT_THAT(decode("pcd", "no/%04d.pcd", exit_failed), HasSubstr("there is no such folder; make it first"));
}

TEST_F(Written, PcdOfManyPointsIsWrittenAsTheyCome) {
  Cloud cloud;
  constexpr std::size_t per_frame = 60'000, frames = 10;
  cloud.points_bytes.resize(per_frame * sizeof(CloudPoint));
  const auto writer = make_pcd_writer(path("big.pcd"));
  for (std::size_t frame = 0; frame < frames; ++frame) {
    for (std::size_t i = 0; i < per_frame; ++i) {
      const auto x = static_cast<float>(frame * per_frame + i);
      cloud.points()[i] = {x, -x, 1, 7, 3, 0.5F};
    }
    writer->cloud(frame, cloud);
  }
  writer->finish();
  const std::string text = content(path("big.pcd"));
  const std::size_t begin = text.find("DATA binary\n") + 12;
  ASSERT_LT(begin, 400U);
  EXPECT_THAT(text.substr(0, begin), HasSubstr("\nFIELDS x y z intensity ring time\nSIZE 4 4 4 4 2 4\n"));
  EXPECT_THAT(text.substr(0, begin), HasSubstr("\nWIDTH 600000\nHEIGHT 1\n"));
  EXPECT_THAT(text.substr(0, begin), HasSubstr("\nPOINTS 600000\n"));
  ASSERT_EQ(text.size(), begin + per_frame * frames * 22);
  for (const std::size_t i :
       {std::size_t{0}, std::size_t{499'999}, std::size_t{500'001}, per_frame * frames - 1}) {
    float xy[2];
    std::memcpy(xy, text.data() + begin + 22 * i, sizeof xy);
    EXPECT_EQ(xy[0], static_cast<float>(i));
    EXPECT_EQ(xy[1], -static_cast<float>(i));
  }
}

TEST(NumberedPathTest, FillsItsPlaceAsPrintfDoes) {
  EXPECT_EQ(numbered_path("a/%06d.pcd", 42), "a/000042.pcd");
  EXPECT_EQ(numbered_path("%d.pcd", 1234567), "1234567.pcd");
  EXPECT_EQ(numbered_path("a%3db", 7), "a  7b");
  for (const char* none : {"a.pcd", "100%.pcd", "%s.pcd", "%5.2d"})
    EXPECT_FALSE(numbered_path(none, 1)) << none;
}

}  // namespace
}  // namespace lidard::test
