// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "daemon/calibration_file.h"
#include "daemon/config_parts.h"

namespace lidard {
namespace {

velodyne::CalibrationModel read_calibration_model(const Value& value) {
  const std::string expected = "ros_drivers (the equations of velodyne_pointcloud) or exact (the manual's)";
  const std::string word = value.text(expected);
  if (word == "ros_drivers") return velodyne::CalibrationModel::ros_drivers;
  if (word == "exact") return velodyne::CalibrationModel::exact;
  value.fail("is " + value.quoted(), expected);
}

std::string in_folder_of(const std::string& config_file, const std::string& path) {
  const auto slash = config_file.rfind('/');
  return path.front() == '/' || slash == std::string::npos ? path : config_file.substr(0, slash + 1) + path;
}

}  // namespace

void read_calibration(Mapping& yaml, SensorConfig& sensor, Config& config) {
  if (!takes_calibration(*sensor.model)) return;  // the keys stay unread, which is refused
  const auto file = yaml.find("calibration");
  const auto model = yaml.find("calibration_model");
  if (model && !file)
    model->fail_at_key("is given without calibration", "both: the model says how the file is applied");
  if (!file) return;
  const std::string expected = "a calibration file, relative to the configuration's folder";
  sensor.calibration = file->text(expected);
  const std::string path = in_folder_of(config.file, sensor.calibration);
  if (::access(path.c_str(), R_OK) != 0)
    file->fail("is " + file->quoted() + ", which cannot be read: " + std::strerror(errno), expected);
  auto calibration = std::make_shared<velodyne::Calibration>(load_calibration(path, config.warnings));
  if (model) calibration->model = read_calibration_model(*model);
  const std::string misfit = calibration_misfit(*calibration, *sensor.model);
  if (!misfit.empty()) file->fail(misfit, "the calibration of this sensor");
  const std::string doubt = calibration_doubt(*calibration, *sensor.model);
  if (!doubt.empty()) warn(config, file->place(), file->path() + " " + doubt);
  sensor.driver.calibration = std::move(calibration);
}

}  // namespace lidard
