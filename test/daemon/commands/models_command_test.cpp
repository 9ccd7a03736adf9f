// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/commands/commands.h"
#include "daemon/yaml/yaml.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(ModelsCommand, PrintsOneAlignedLinePerModel) {
  std::ostringstream out;
  EXPECT_EQ(run_models(false, out), 0);
  const std::vector<std::string> lines = lines_of(out.str());
  ASSERT_EQ(lines.size(), models().size() + 1);
  for (std::size_t i = 0; i < models().size(); ++i) {
    const Model& model = models()[i];
    EXPECT_EQ(lines[i + 1].rfind(std::string(model.name) + " ", 0), 0U);
    EXPECT_EQ(lines[i + 1].find(model.verified), lines[0].find("verified")) << lines[i + 1];
    EXPECT_EQ(lines[i + 1].find(model.protocol), lines[0].find("protocol")) << lines[i + 1];
  }
}

TEST(ModelsCommand, PrintsJson) {
  std::ostringstream out;
  EXPECT_EQ(run_models(true, out), 0);
  const auto list = nlohmann::json::parse(out.str());
  ASSERT_EQ(list.size(), models().size());
  for (const auto& entry : list) {
    const Model* model = find_model(entry.at("name").get<std::string>());
    ASSERT_NE(model, nullptr);
    EXPECT_EQ(entry.at("port"), model->port);
    EXPECT_EQ(entry.at("verified"), model->verified);
    EXPECT_EQ(entry.at("frames"), model->kind == FrameKind::cloud ? "cloud" : "scan");
  }
}

TEST(ModelsCommand, ThePageOfTruthNamesEveryModelOnce) {
  const std::string page = read_file(test::project_file("test/TRUTH.md"), "the page");
  for (const Model& model : models()) {
    const std::string name = "`" + std::string(model.name) + "`";
    const std::size_t at = page.find(name);
    ASSERT_NE(at, std::string::npos) << name;
    EXPECT_EQ(page.find(name, at + 1), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace lidard
