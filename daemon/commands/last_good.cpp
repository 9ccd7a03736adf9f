// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/last_good.h"

#include <cstdlib>
#include <filesystem>

#include "daemon/files/text_file.h"
#include "daemon/health/sentences.h"

namespace lidard {
namespace {

namespace fs = std::filesystem;

constexpr const char* kept_name = "lidard.yaml";

fs::path beside(const Config& config, const std::string& file) {
  const fs::path path = file;
  return path.is_absolute() ? path : fs::path(config.file).parent_path() / path;
}

}  // namespace

LastGood::LastGood(const std::string& config_file) {
  const char* const state = std::getenv("STATE_DIRECTORY");
  if (state == nullptr || *state == '\0') return;
  const std::string first = std::string(state).substr(0, std::string(state).find(':'));
  folder_ = fs::path(first) / "last-good" / fs::path(config_file).filename();
}

std::string LastGood::keep(const Config& config) const {
  if (folder_.empty()) return {};
  try {
    // Written to another folder first, so that an incomplete copy is never used.
    const fs::path part = folder_ + ".part";
    fs::remove_all(part);
    fs::create_directories(part);
    Config copy = config;
    for (SensorConfig& sensor : copy.sensors) {
      if (sensor.calibration.empty()) continue;
      const std::string name =
          sensor.name + ".calibration" + fs::path(sensor.calibration).extension().string();
      fs::copy_file(beside(config, sensor.calibration), part / name);
      sensor.calibration = name;
    }
    TextFile file(part / kept_name);
    file.write(to_yaml(copy));
    file.close();
    fs::remove_all(folder_);
    fs::rename(part, folder_);
  } catch (const std::exception& error) {
    return text<says::not_kept>(error.what());
  }
  return {};
}

std::optional<Config> LastGood::load() const {
  if (folder_.empty()) return std::nullopt;
  try {
    return load_config((fs::path(folder_) / kept_name).string());
  } catch (const ConfigError&) {
    return std::nullopt;
  }
}

}  // namespace lidard
