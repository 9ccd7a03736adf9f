// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_message.h"

#include <gtest/gtest.h>

namespace lidard::hokuyo {
namespace {

std::vector<std::string> echoes(ScipReader& reader, std::string_view bytes) {
  std::vector<std::string> all;
  reader.add(ByteView(bytes));
  for (ScipMessage message; reader.next(message);) all.emplace_back(message.echo);
  return all;
}

// Hokuyo C-42-03320B p. 6 and p. 7.
TEST(ScipMessage, ChecksumAndNumbersAreThoseOfTheSpecification) {
  EXPECT_EQ(scip_checksum("Hokuyo"), 'o');
  EXPECT_EQ(scip_number("CB"), 1234U);
  EXPECT_EQ(scip_number("1Dh"), 5432U);
  EXPECT_EQ(scip_number("m2@0"), 16'000'000U);
  EXPECT_EQ(scip_number(""), std::nullopt);
  EXPECT_EQ(scip_number("1D&"), std::nullopt) << "the mark of a further echo is no number";
  EXPECT_EQ(scip_number("0000000000?"), 15U);
  EXPECT_EQ(scip_number("000000000000"), std::nullopt);
}

TEST(ScipMessage, AnswersEndWithAnEmptyLine) {
  Counters counters;
  ScipReader reader(counters);
  EXPECT_TRUE(echoes(reader, "QT\n00P\n").empty());
  EXPECT_EQ(echoes(reader, "\nVV\n00P\nVEND:x;0\n"), std::vector<std::string>{"QT"});
  EXPECT_EQ(echoes(reader, "\nPP\n0Ee\n\n"), (std::vector<std::string>{"VV", "PP"}));
  EXPECT_EQ(counters.incomplete, 0U);
}

TEST(ScipMessage, RubbishIsCountedAndMemoryStaysBounded) {
  Counters counters;
  ScipReader reader(counters);
  EXPECT_EQ(echoes(reader, "QT\n00P\n\n").size(), 1U);
  EXPECT_EQ(echoes(reader, "QT\n00Q\n\n"), std::vector<std::string>{""}) << "an answer that is not readable";
  const std::string noise(100'000, 'x');
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(echoes(reader, noise).empty());
  EXPECT_EQ(echoes(reader, "\n\nQT\n00P\n\n"), std::vector<std::string>{"QT"});
  EXPECT_GE(counters.incomplete, 30U);
}

TEST(ScipMessage, RequestsAreReadWithAllTheirParts) {
  const auto md = parse_scan_request("MD0100011002301;MD00000222");
  ASSERT_TRUE(md);
  EXPECT_EQ(md->first_step, 100);
  EXPECT_EQ(md->last_step, 110);
  EXPECT_EQ(md->cluster, 2);
  EXPECT_EQ(md->skip, 3);
  EXPECT_TRUE(md->continuous);
  EXPECT_FALSE(md->intensities || md->multi_echo || md->percent || md->short_values);
  EXPECT_EQ(md->values(), 6U);
  const auto he = parse_scan_request("HE0000001000");
  ASSERT_TRUE(he);
  EXPECT_TRUE(he->multi_echo && he->intensities && !he->continuous);
  EXPECT_EQ(he->cluster, 1) << "00 means 01";
  EXPECT_TRUE(parse_scan_request("%ME0000108001000")->percent);
  EXPECT_TRUE(parse_scan_request("GS0000001001")->short_values);
  for (const char* wrong :
       {"", "M", "MX0000001001000", "NS0000001001000", "MD00000010010", "MD0010000001000", "MD000000100100x",
        "XD0000001001000", "00P", "MD0000001001000;aaaaaaaaaaaaaaaaaaaa"})
    EXPECT_FALSE(parse_scan_request(wrong)) << wrong;
}

// The answers of UTM-30LX-EW and URG-04LX as makers' documents and users print them; some firmware counts the
// semicolon in the checksum.
TEST(ScipMessage, ParametersAreReadWithEitherChecksum) {
  std::string text =
      "MODL:UTM-30LX-EW;I\nDMIN:23;7\nDMAX:60000;J\nARES:1440;^\nAMIN:0;?\nAMAX:1080;Z\nAFRT:540;0\n"
      "SCAN:2400;U\n";
  ScipParameters p;
  std::string product;
  ASSERT_TRUE(parse_parameters(text, p, product));
  EXPECT_EQ(product, "UTM-30LX-EW");
  EXPECT_EQ(p.range_min_mm, 23);
  EXPECT_EQ(p.range_max_mm, 60000);
  EXPECT_EQ(p.steps_per_turn, 1440);
  EXPECT_EQ(p.last_step, 1080);
  EXPECT_EQ(p.front_step, 540);
  EXPECT_EQ(p.rpm, 2400);
  EXPECT_NEAR(p.angle(0), -0.75 * 3.14159265358979, 1e-9);
  EXPECT_NEAR(p.step_seconds(), 0.025 / 1440, 1e-12);
  const std::string other = std::string("DMIN:23;") + scip_checksum("DMIN:23;") + "\n";
  ASSERT_TRUE(parse_parameters("MODL:UTM-30LX-EW;I\n" + other + text.substr(text.find("DMAX")), p, product));
  const auto with_line = [&](const std::string& key, const std::string& line) {
    const std::size_t at = text.find(key), end = text.find('\n', at);
    return text.substr(0, at) + line + ";" + scip_checksum(line) + text.substr(end);
  };
  ASSERT_TRUE(parse_parameters(with_line("AMAX", "AMAX:1"), p, product));
  EXPECT_FALSE(parse_parameters(with_line("AMAX", "AMAX:0"), p, product)) << "one step is no sweep";
  text.replace(text.find("60000"), 5, "70000");
  EXPECT_FALSE(parse_parameters(text, p, product)) << "checksum";
  EXPECT_FALSE(parse_parameters("DMIN:23;7\n", p, product)) << "lines are missing";
}

TEST(ScipMessage, CodesMeanWhatTheTablesSay) {
  EXPECT_EQ(status_of_code(CodeTable::utm, 1), BeamStatus::none);
  EXPECT_EQ(status_of_code(CodeTable::utm, 2), BeamStatus::near);
  EXPECT_EQ(status_of_code(CodeTable::utm, 4), BeamStatus::near);
  for (const unsigned code : {0U, 3U, 5U, 19U})
    EXPECT_EQ(status_of_code(CodeTable::utm, code), BeamStatus::invalid);
  EXPECT_EQ(status_of_code(CodeTable::urg, 0), BeamStatus::none);
  EXPECT_EQ(status_of_code(CodeTable::urg, 6), BeamStatus::none);
  for (const unsigned code : {1U, 2U, 7U, 19U})
    EXPECT_EQ(status_of_code(CodeTable::urg, code), BeamStatus::invalid);
  EXPECT_EQ(code_table_of("URG-04LX"), CodeTable::urg);
  EXPECT_EQ(code_table_of("UST-10LX"), CodeTable::utm);
}

TEST(ScipMessage, EveryStatusIsExplainedWithARemedy) {
  const char* of_both_generations[] = {"01", "02", "03", "04", "05", "06", "07", "0A", "0B",
                                       "0C", "0D", "0E", "0F", "0G", "0H", "0I", "0L", "0M",
                                       "10", "21", "49", "50", "97", "98", "xx"};
  for (const char* status : of_both_generations) {
    const std::string text = explain_status("MD", status);
    EXPECT_NE(text.find("status " + std::string(status)), std::string::npos) << text;
    EXPECT_NE(text.find("; "), std::string::npos) << text;
  }
  EXPECT_EQ(class_of("99"), StatusClass::data);
  EXPECT_EQ(class_of("21"), StatusClass::verifying);
  EXPECT_EQ(class_of("50"), StatusClass::fault);
  EXPECT_EQ(class_of("97"), StatusClass::fault);
  EXPECT_EQ(class_of("98"), StatusClass::resumed);
  EXPECT_EQ(class_of("0L"), StatusClass::refused);
  EXPECT_EQ(class_of("20"), StatusClass::refused);
}

}  // namespace
}  // namespace lidard::hokuyo
