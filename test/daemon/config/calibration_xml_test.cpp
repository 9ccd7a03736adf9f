// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "test/daemon/config/calibration_support.h"

namespace lidard {
namespace {

using test::calibration_error;
using test::calibration_of;
using test::calibration_warnings;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string list_of(const std::string& name, int count, const std::function<int(int)>& value) {
  std::string xml = "\t<" + name + ">\n\t\t<count>" + std::to_string(count) +
                    "</count>\n\t\t<item_version>0</item_version>\n";
  for (int i = 0; i < count; ++i) xml += "\t\t<item>" + std::to_string(value(i)) + "</item>\n";
  return xml + "\t</" + name + ">\n";
}

/// One laser's entry, with the attributes that boost::serialization writes.
std::string point_of(int id) {
  const auto element = [](const char* name, double value) {
    return "\t\t\t\t<" + std::string(name) + ">" + std::to_string(value) + "</" + name + ">\n";
  };
  return std::string(id == 0 ? "\t\t<item class_id=\"8\" tracking_level=\"0\" version=\"1\">\n"
                             : "\t\t<item>\n") +
         (id == 0 ? "\t\t\t<px class_id=\"9\" tracking_level=\"1\" version=\"1\" object_id=\"_1\">\n"
                  : "\t\t\t<px class_id_reference=\"9\" object_id=\"_" + std::to_string(id + 1) + "\">\n") +
         "\t\t\t\t<id_>" + std::to_string(id) + "</id_>\n" + element("rotCorrection_", -4.5 + id) +
         element("vertCorrection_", -15 + 0.25 * id) + element("distCorrection_", 140 + id) +
         element("distCorrectionX_", id % 2 == 0 ? 141.5 : 0) + element("distCorrectionY_", 142.25) +
         element("vertOffsetCorrection_", 21.5) + element("horizOffsetCorrection_", -2.6) +
         element("focalDistance_", 1200) + element("focalSlope_", 1.4) + element("closeSlope_", 1) +
         "\t\t\t</px>\n\t\t</item>\n";
}

/// A db.xml with `enabled` lasers of 64 and a distance step in cm.
std::string db_xml(int enabled, const std::string& step, int points = 64) {
  std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\" ?>\n"
      "<!DOCTYPE boost_serialization>\n"
      "<boost_serialization signature=\"serialization::archive\" version=\"4\">\n"
      "<DB class_id=\"0\" tracking_level=\"1\" version=\"0\" object_id=\"_0\">\n";
  if (!step.empty()) xml += "\t<distLSB_>" + step + "</distLSB_>\n";
  xml +=
      "\t<position_ class_id=\"1\"><xyz><count>3</count><item>0</item></xyz></position_>\n"
      "\t<colors_ class_id=\"3\"><item><rgb><item>0.84018773</item></rgb></item></colors_>\n";
  xml += list_of("enabled_", 64, [&](int i) { return i < enabled ? 1 : 0; });
  xml += list_of("intensity_", 64, [&](int i) { return i < enabled ? 1 : 0; });
  xml += list_of("minIntensity_", 64, [](int i) { return i; });
  xml += list_of("maxIntensity_", 64, [](int i) { return 255 - i; });
  xml += "\t<points_ class_id=\"7\" tracking_level=\"0\" version=\"0\">\n\t\t<count>64</count>\n";
  for (int id = points - 1; id >= 0; --id) xml += point_of(id);
  return xml + "\t</points_>\n</DB>\n</boost_serialization>\n";
}

class DbXml : public ::testing::TestWithParam<int> {};

TEST_P(DbXml, GivesItsEnabledLasersInRadAndMetres) {
  const auto lasers = static_cast<std::size_t>(GetParam());
  const std::string text = db_xml(GetParam(), "0.2");
  EXPECT_THAT(calibration_warnings(text), IsEmpty());
  const Calibration calibration = calibration_of(text);
  EXPECT_NEAR(calibration.distance_step_m, 0.002, 1e-15);
  EXPECT_EQ(calibration.model, CalibrationModel::ros_drivers);
  ASSERT_EQ(calibration.lasers.size(), lasers);
  for (std::size_t i = 0; i < lasers; ++i) {
    const LaserCalibration& laser = calibration.lasers[i];
    const auto id = static_cast<double>(i);
    EXPECT_NEAR(laser.rot_correction, (-4.5 + id) * M_PI / 180, 1e-9);
    EXPECT_NEAR(laser.vert_correction, (-15 + 0.25 * id) * M_PI / 180, 1e-9);
    EXPECT_NEAR(laser.dist_correction, 1.40 + 0.01 * id, 1e-9);
    EXPECT_NEAR(laser.dist_correction_x, i % 2 == 0 ? 1.415 : 0, 1e-9);
    EXPECT_NEAR(laser.dist_correction_y, 1.4225, 1e-9);
    EXPECT_NEAR(laser.vert_offset, 0.215, 1e-9);
    EXPECT_NEAR(laser.horiz_offset, -0.026, 1e-9);
    EXPECT_NEAR(laser.focal_distance, 12, 1e-9);
    EXPECT_NEAR(laser.focal_slope, 1.4, 1e-9);
    EXPECT_EQ(laser.min_intensity, static_cast<int>(i));
    EXPECT_EQ(laser.max_intensity, 255 - static_cast<int>(i));
    EXPECT_EQ(laser.two_point, i % 2 == 0 ? TwoPoint::on : TwoPoint::off);
  }
}

INSTANTIATE_TEST_SUITE_P(Lasers, DbXml, ::testing::Values(64, 16),
                         [](const auto& each) { return "of_" + std::to_string(each.param); });

TEST(CalibrationXml, TheStepIsTwoMillimetresWhereTheFileIsOlderThanTheElement) {
  EXPECT_NEAR(calibration_of(db_xml(64, "")).distance_step_m, 0.002, 1e-15);
  EXPECT_NEAR(calibration_of(db_xml(32, " 0.4\n")).distance_step_m, 0.004, 1e-15);
}

TEST(CalibrationXml, TheByteOrderMarkAndBlanksBeforeItAreNoContent) {
  EXPECT_EQ(calibration_of("\xEF\xBB\xBF" + db_xml(16, "0.2")).lasers.size(), 16U);
  EXPECT_EQ(calibration_of("\n  " + db_xml(16, "0.2").substr(57)).lasers.size(), 16U);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos);
  return text.replace(at, from.size(), to);
}

/// "f:LINE: " for the line where `part` begins.
std::string at(const std::string& text, const std::string& part) {
  const auto position = static_cast<std::ptrdiff_t>(text.find(part));
  return "f:" + std::to_string(1 + std::count(text.begin(), text.begin() + position, '\n')) + ": ";
}

TEST(CalibrationXml, WhatIsNoCalibrationIsToldWithItsLine) {
  EXPECT_EQ(calibration_error("<DB>\n<a></b>\n</DB>"),
            "f:2: not XML: XML_ERROR_MISMATCHED_ELEMENT; expected a db.xml as it came with the sensor");
  EXPECT_EQ(calibration_error("<html>\n</html>"), "f:1: no DB element; expected boost_serialization/DB");
  EXPECT_EQ(calibration_error("<a>\n<DB>\n</DB></a>"),
            "f:2: DB has no points_; expected points_ with an item per laser");
  const std::string good = db_xml(16, "0.2");
  EXPECT_THAT(calibration_error(replaced(good, "</points_", "</pointz_")), HasSubstr("not XML"));
}

TEST(CalibrationXml, WrongNumbersAreToldWithTheirLine) {
  const std::string good = db_xml(16, "0.2");
  EXPECT_EQ(calibration_error(replaced(good, "<distLSB_>0.2<", "<distLSB_>0.002<")),
            "f:5: distLSB_ is \"0.002\"; expected a number from 0.1 to 2");
  EXPECT_EQ(calibration_error(replaced(good, "<distLSB_>0.2<", "<distLSB_>x\ny<")),
            "f:5: distLSB_ is \"x?y\"; expected a number from 0.1 to 2");
  EXPECT_EQ(calibration_error(replaced(good, "<id_>7</id_>", "<id_>7.5</id_>")),
            at(good, "<id_>7<") + "id_ is a fraction; expected the laser's number, from 0");
  EXPECT_EQ(calibration_error(replaced(good, "<vertCorrection_>-13.250000", "<vertCorrection_>-113.25")),
            at(good, "<vertCorrection_>-13.25") +
                "vertCorrection_ is \"-113.25\"; expected a number from -90 to 90");
}

TEST(CalibrationXml, DoubledAndMissingLasersAreToldWithTheirLine) {
  const std::string good = db_xml(16, "0.2");
  const std::string px_of_7 = "<px class_id_reference=\"9\" object_id=\"_8\">";
  const std::string px_of_6 = "<px class_id_reference=\"9\" object_id=\"_7\">";
  const std::string first = at(good, px_of_7);
  EXPECT_EQ(calibration_error(replaced(good, "<id_>7</id_>", "<id_>6</id_>")),
            at(good, px_of_6) + "laser 6 again, first in line " + first.substr(2, first.size() - 4) +
                "; expected each id_ once");
  EXPECT_EQ(calibration_error(replaced(good, "<id_>7</id_>", "")),
            first + "px has no id_; expected it in each px");
  const std::string expected = "; expected one for each laser, numbered from 0, that enabled_ has";
  EXPECT_EQ(calibration_error(replaced(good, "<id_>7</id_>", "<id_>77</id_>")),
            at(good, "<points_") + "points_ has no laser 7" + expected);
  EXPECT_EQ(calibration_error(db_xml(16, "0.2", 15)),
            at(good, "<points_") + "points_ has no laser 15" + expected);
  EXPECT_EQ(calibration_error(db_xml(0, "0.2")),
            at(good, "<points_") + "points_ has no enabled laser; expected at least one");
}

TEST(CalibrationXml, DeepNestingIsAnErrorAndNoCrash) {
  std::string text;
  for (int i = 0; i < 100000; ++i) text += "<a>";
  EXPECT_THAT(calibration_error(text), HasSubstr("f:1: not XML: "));
}

TEST(CalibrationXml, MutatedFilesAreReadOrGiveAnErrorWithItsLine) {
  const std::string original = db_xml(2, "0.2", 2);
  test::expect_placed_errors(original, " \n<>/=\"!?&;-.0123456789ax_", 37,
                             "^f:[1-9][0-9]*: [^\\n]+; expected [^\\n]+$");
}

}  // namespace
}  // namespace lidard
