// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a device that speaks CoLa calls itself, beside what is configured.
#include <gmock/gmock.h>

#include "test/drivers/sick/cola/fake_cola_device.h"

namespace lidard::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// What is wrong with a device that calls itself so.
std::vector<std::string> warnings_of(const char* model, const std::string& name) {
  ColaBench bench(model);
  FakeDevice device(bench);
  device.answers["sRN DeviceIdent"] =
      ColaWords(Cola::binary, "sRA DeviceIdent").text(name, 2).text("V1.0", 2).bytes();
  device.answers["sRN LMDscandatacfg"] = refusal(Cola::binary, 3);
  device.connect();
  bench.send_next();
  return bench.driver->info().warnings;
}

TEST(ColaIdentity, ARefusedSettingDoesNotHideWhoAnswers) {
  EXPECT_THAT(warnings_of("sick_lms1xx", "TiM781S"),
              ElementsAre(HasSubstr("reports the name TiM781S, V1.0, which is a sick_tim7xx")));
  EXPECT_THAT(warnings_of("sick_lms1xx", "LMS111_FieldEval"), ::testing::IsEmpty());
}

TEST(ColaIdentity, ADeviceThatNoModelIsOfIsNamed) {
  for (const char* name : {"MRS6124", "RMS320", "LMC12x", "LRS4581R", "NAV350"}) {
    EXPECT_THAT(warnings_of("sick_lms1xx", name),
                ElementsAre(HasSubstr(std::string("reports the name ") + name +
                                      ", V1.0, which is not a supported model, but sick_lms1xx is")));
  }
}

TEST(ColaIdentity, BothKindsOfAnLrs36AreToldApart) {
  EXPECT_THAT(warnings_of("sick_lrs36x0", "LRS3611"), ElementsAre(HasSubstr("set model: sick_lrs36x1")));
  EXPECT_THAT(warnings_of("sick_lrs36x1", "LRS3600"), ElementsAre(HasSubstr("set model: sick_lrs36x0")));
  EXPECT_THAT(warnings_of("sick_lrs36x1", "LRS3601"), ::testing::IsEmpty());
  EXPECT_THAT(warnings_of("sick_lrs36x0", "LRS3610"), ::testing::IsEmpty());
}

TEST(ColaIdentity, TheInertialUnitIsSubscribedToWhereTheModelHasOne) {
  ColaBench bench("sick_mrs1000");
  FakeDevice device(bench);
  device.answers["sRN DeviceIdent"] =
      ColaWords(Cola::binary, "sRA DeviceIdent").text("MRS1xxxx", 2).text("1.3.0.0R", 2).bytes();
  device.answers["sEN InertialMeasurementUnit"] = refusal(Cola::binary, 15);
  device.connect();
  bench.send_next();
  EXPECT_THAT(device.commands(), ElementsAre("sRN DeviceIdent", "sRN LMPoutputRange", "sRN LMDscandatacfg",
                                             "sEN InertialMeasurementUnit", "sEN LMDscandata"));
  EXPECT_TRUE(bench.driver->info().warnings.empty()) << "a device without one is healthy";
}

}  // namespace
}  // namespace lidard::test
