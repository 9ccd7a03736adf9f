// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Every echo of a recorded device comes out of `decode`, in each format. How many distances of each echo the
// telegrams hold was counted by other programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/commands/commands.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using ::testing::HasSubstr;

class DecodedFile {
 public:
  DecodedFile(const std::string& capture, const std::string& format)
      : path_(testing::TempDir() + "decode_echoes_" + std::to_string(getpid()) + "." + format) {
    DecodeOptions options;
    options.capture = capture;
    options.format = format;
    options.output = path_;
    std::ostringstream err;
    EXPECT_EQ(run_decode(options, err), 0) << err.str();
    summary = err.str();
  }
  DecodedFile(const DecodedFile&) = delete;
  DecodedFile& operator=(const DecodedFile&) = delete;
  ~DecodedFile() { std::remove(path_.c_str()); }

  std::string text() const { return test::content(path_); }
  const std::string& path() const { return path_; }

  std::string summary;

 private:
  std::string path_;
};

/// How often each value of a column occurs, in rows whose `status` (if there is one) is "hit".
std::map<std::string, std::size_t> column_of_csv(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  const auto split = [](const std::string& row) {
    std::vector<std::string> fields;
    std::istringstream in(row);
    for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
    return fields;
  };
  const std::vector<std::string> names = split(line);
  std::map<std::string, std::size_t> count;
  while (std::getline(lines, line)) {
    const std::vector<std::string> fields = split(line);
    bool hit = true;
    std::string value;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == name) value = fields.at(i);
      if (names[i] == "status") hit = fields.at(i) == "hit";
    }
    if (hit) ++count[value];
  }
  return count;
}

std::map<std::string, std::size_t> column_of_json(const std::string& text, const std::string& name) {
  std::map<std::string, std::size_t> count;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto frame = nlohmann::json::parse(line);
    const auto names = frame["columns"].get<std::vector<std::string>>();
    const auto place = [&](const std::string& of) {
      return static_cast<std::size_t>(std::find(names.begin(), names.end(), of) - names.begin());
    };
    const std::size_t column = place(name), status = place("status");
    for (const auto& row : frame["rows"]) {
      if (status < names.size() && row[status] != "hit") continue;
      ++count[std::to_string(row[column].get<int>())];
    }
  }
  return count;
}

struct Recorded {
  const char* capture;
  const char* column;
  std::size_t first, second;  // echoes
};
const Recorded picoscan{"sick/picoscan150_compact_frag.pcap", "echo", 21235, 372};
const Recorded mrs{"sick/mrs1000_test01.pcap", "return", 39139, 3107};

class DecodeEchoes : public ::testing::TestWithParam<Recorded> {};
INSTANTIATE_TEST_SUITE_P(Recorded, DecodeEchoes, ::testing::Values(picoscan, mrs),
                         [](const auto& each) { return std::string(each.param.column); });

TEST_P(DecodeEchoes, ComeOutInEachFormatAndAreCountedAsReturns) {
  LIDARD_NEED_CAPTURE(path, GetParam().capture);
  const std::map<std::string, std::size_t> expected = {{"0", GetParam().first}, {"1", GetParam().second}};
  const std::size_t all = GetParam().first + GetParam().second;
  const std::string returns = " frames, " + std::to_string(all) + " returns\n";
  const DecodedFile csv(path, "csv"), json(path, "json"), pcd(path, "pcd");
  EXPECT_EQ(column_of_csv(csv.text(), GetParam().column), expected);
  EXPECT_EQ(column_of_json(json.text(), GetParam().column), expected);
  EXPECT_THAT(pcd.text().substr(0, 500), HasSubstr("POINTS " + std::to_string(all) + "\n"));
  for (const DecodedFile* file : {&csv, &json, &pcd}) EXPECT_THAT(file->summary, HasSubstr(returns));
}

TEST(DecodePlanar, CountsReturnsAndNotBeams) {
  LIDARD_NEED_CAPTURE(path, "sick/microscan3_398.pcap");
  const DecodedFile csv(path, "csv");
  // 129 * 715 beams, of which 7662 have the flag for "no echo"; 1798 of the others are nearer than 0.1 m.
  EXPECT_THAT(csv.summary, HasSubstr(": 129 frames, 82775 returns\n"));
}

TEST(DecodePlanar, GivesTheFlagsOfASafetyScannersBeamsInJson) {
  LIDARD_NEED_CAPTURE(path, "sick/microscan3_398.pcap");
  const DecodedFile json(path, "json");
  // Of those that are hits, 0x41, 0x81 and 0xc1 are as many as in the recording, less the ones
  // nearer than 0.1 m.
  const std::map<std::string, std::size_t> flags = column_of_json(json.text(), "device_flags");
  EXPECT_EQ(flags.size(), 4U);
  EXPECT_EQ(flags.count("3"), 0U) << "no echo";
  std::size_t hits = 0;
  for (const auto& [value, count] : flags) hits += count;
  EXPECT_EQ(hits, 82775U);
  EXPECT_EQ(flags.at("65"), 2699U);
}

}  // namespace
}  // namespace lidard::test
