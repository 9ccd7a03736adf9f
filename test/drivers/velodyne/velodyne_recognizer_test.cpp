// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "drivers/model.h"
#include "drivers/registry/identifier.h"
#include "drivers/registry/registry.h"
#include "test/sim/world/rng.h"
#include "test/support/captures.h"
#include "test/support/collector.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using test::ModelMode;
using test::WirePacket;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

struct Found {
  std::string model;
  std::vector<std::string> others;
  std::string remark;
};

Found identify(const std::vector<WirePacket>& packets) {
  Identifier identifier;
  const Endpoint sensor{IpAddress::v4(192, 168, 1, 201), 2368};
  for (const WirePacket& packet : packets)
    identifier.add({{packet.bytes.data(), packet.bytes.size()}, packet.arrival, sensor, {{}, 2368}});
  Found found;
  if (const Model* model = identifier.verdict()) found.model = model->name;
  for (const Model* other : identifier.others()) found.others.emplace_back(other->name);
  found.remark = identifier.remark();
  return found;
}

Found identify(const std::string& model, const std::string& timing, bool status_stream, std::size_t packets,
               sim::ReturnMode mode = sim::ReturnMode::strongest) {
  sim::VelodyneOptions options;
  options.status_stream = status_stream;
  auto stream = test::spin({model, mode, timing}, 1.2, options);
  stream.resize(std::min(stream.size(), packets));
  return identify(stream);
}

constexpr std::size_t plenty = 10'000;

/// The remark on a telemetry packet.
std::string remark_on(std::uint16_t port, std::string_view sentence, std::size_t size = 512) {
  std::vector<std::uint8_t> bytes(size);
  if (size > 0xCE + sentence.size()) std::copy(sentence.begin(), sentence.end(), bytes.begin() + 0xCE);
  Identifier identifier;
  Packet packet;
  packet.payload = ByteView(bytes.data(), bytes.size());
  packet.arrival = Stamp{1'700'000'000'000'000'000};
  packet.from = {IpAddress::v4(10, 0, 0, 1), 8308};
  packet.to.port = port;
  identifier.add(packet);
  EXPECT_EQ(identifier.verdict(), nullptr);
  return identifier.remark();
}

TEST(VelodyneRecognizer, TelemetryWithoutDataIsNamedWithWhatToCheck) {
  const auto is_named = ::testing::AllOf(HasSubstr("telemetry of a Velodyne"), HasSubstr("laser and motor"),
                                         HasSubstr("port 2368"));
  EXPECT_THAT(remark_on(8308, ""), is_named) << "no receiver is connected";
  EXPECT_THAT(remark_on(8308, "$GPRMC,120000,A,"), is_named);
  EXPECT_THAT(remark_on(9999, "$GPGGA,120000,"), is_named) << "another port is configured";
  EXPECT_EQ(remark_on(9999, ""), "");
  EXPECT_EQ(remark_on(8308, "$GPRMC", 511), "");
}

TEST(VelodyneRecognizer, EveryModelAndModeIsTheVerdictOrAmongTheOthers) {
  for (const ModelMode& which : test::model_modes()) {
    SCOPED_TRACE(which.name());
    const Found found = identify(test::spin(which, 0.5));
    const bool among = std::count(found.others.begin(), found.others.end(), which.model) > 0;
    EXPECT_TRUE(found.model == which.model || among) << found.model;
    if (among) {
      EXPECT_THAT(found.remark, HasSubstr(which.model));
    }
  }
}

TEST(VelodyneRecognizer, ModelsAreRecognisedThoughHalfOfThePacketsAreMissing) {
  for (const ModelMode& which : test::model_modes()) {
    if (which.table().has_status()) continue;  // status bytes are spread over many packets
    auto packets = test::spin(which, 0.5);
    const Found whole = identify(packets);
    sim::Rng rng(5);
    packets.erase(
        std::remove_if(packets.begin(), packets.end(), [&](const auto&) { return rng.uniform() < 0.5; }),
        packets.end());
    EXPECT_EQ(identify(packets).model, whole.model) << which.name();
  }
}

// 63-HDL64ES3 Rev K, appendix E: warning bytes come from an S3 alone.
TEST(VelodyneRecognizer, StatusBytesTellAnHdl64eS3FromItsElders) {
  for (const char* timing : {"48", "57.6"}) {
    const Found s3 = identify("velodyne_hdl64e_s3", timing, true, plenty);
    EXPECT_EQ(s3.model, "velodyne_hdl64e_s3");
    EXPECT_THAT(s3.others, IsEmpty());
    EXPECT_THAT(s3.remark, IsEmpty());
    const Found s2 = identify("velodyne_hdl64e_s2", timing, true, plenty);
    EXPECT_EQ(s2.model, "velodyne_hdl64e_s2");
    EXPECT_THAT(s2.others, ElementsAre("velodyne_hdl64e_s21"));
    EXPECT_THAT(s2.remark, HasSubstr("velodyne_hdl64e_s21"));
  }
  EXPECT_EQ(identify("velodyne_hdl64e_s3", "57.6", true, plenty, sim::ReturnMode::dual).model,
            "velodyne_hdl64e_s3");
}

TEST(VelodyneRecognizer, WithoutStatusBytesThePeriodOfAnHdl64eIsAGuessThatNamesTheOthers) {
  const Found fast = identify("velodyne_hdl64e_s2", "48", false, plenty);
  EXPECT_EQ(fast.model, "velodyne_hdl64e_s2");
  EXPECT_THAT(fast.others, ElementsAre("velodyne_hdl64e_s21", "velodyne_hdl64e_s3"));
  const Found slow = identify("velodyne_hdl64e_s3", "57.6", false, plenty);
  EXPECT_EQ(slow.model, "velodyne_hdl64e_s3");
  EXPECT_THAT(slow.others, ElementsAre("velodyne_hdl64e_s2", "velodyne_hdl64e_s21"));
  EXPECT_THAT(slow.remark,
              StartsWith("taken for velodyne_hdl64e_s3, but nothing in the packets tells it from "
                         "velodyne_hdl64e_s2, velodyne_hdl64e_s21; set the model"));
  EXPECT_EQ(identify("velodyne_hdl64e_s3", "57.6", true, 1).others.size(), 2U) << "one packet tells little";
}

TEST(VelodyneRecognizer, AVlp32aAndAVlp32bAreNotToldApartAndTheNoteSaysSo) {
  const Found found = identify("velodyne_vlp32b", "", true, plenty);
  EXPECT_EQ(found.model, "velodyne_vlp32a");
  EXPECT_THAT(found.others, ElementsAre("velodyne_vlp32b"));
  EXPECT_THAT(found.remark, HasSubstr("velodyne_vlp32b"));
}

TEST(VelodyneRecognizer, ProductsThatAreDecodedAlikeAreNamedWithoutANote) {
  const Found found = identify("velodyne_vlp16", "", true, plenty);
  EXPECT_EQ(found.model, "velodyne_vlp16");
  EXPECT_THAT(found.others, ElementsAre("velodyne_puck_lite"));
  EXPECT_THAT(found.remark, IsEmpty());
  EXPECT_THAT(identify("velodyne_vls128", "b", true, plenty).others, ElementsAre("velodyne_alpha_prime"));
}

TEST(VelodyneRecognizer, AnHdl64eS1IsToldByTheOrderOfItsBlocksFromOnePacket) {
  const Found found = identify("velodyne_hdl64e_s1", "", true, 1);
  EXPECT_EQ(found.model, "velodyne_hdl64e_s1");
  EXPECT_THAT(found.others, IsEmpty());
}

TEST(VelodyneRecognizer, AnotherGenerationOfHdl64eIsRefused) {
  for (const auto& [configured, sent] : {std::pair("velodyne_hdl64e_s1", "velodyne_hdl64e_s3"),
                                         std::pair("velodyne_hdl64e_s3", "velodyne_hdl64e_s1")}) {
    DriverConfig config;
    config.model = find_model(configured);
    const auto driver = config.model->make(config);
    const std::string timing(sim::velodyne_table(sent).timings.front().name);
    test::Columns out;
    for (const WirePacket& packet : test::spin({sent, sim::ReturnMode::strongest, timing}, 0.1))
      EXPECT_EQ(give(*driver, packet, out), Reject::model);
  }
}

}  // namespace
}  // namespace lidard
