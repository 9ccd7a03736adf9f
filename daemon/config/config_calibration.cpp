// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "daemon/config/calibration_file.h"
#include "daemon/config/sections.h"
#include "drivers/velodyne/calibration.h"

namespace lidard {
namespace {

velodyne::CalibrationModel read_calibration_model(const Value& value) {
  const std::string expected =
      "ros_drivers (the equations of velodyne_pointcloud), exact (the manual's) or veloview (the viewer's)";
  const auto equations = calibration_model_of(value.text(expected));
  if (equations) return *equations;
  value.fail("is " + value.quoted(), expected);
}

std::string in_folder_of(const std::string& config_file, const std::string& path) {
  const auto slash = config_file.rfind('/');
  return path.front() == '/' || slash == std::string::npos ? path : config_file.substr(0, slash + 1) + path;
}

/// `calibration_model:` without a file: which equations place the returns of the model's own table.
void apply_to_table(const Value& value, SensorConfig& sensor) {
  const velodyne::CalibrationModel equations = read_calibration_model(value);
  if (equations == velodyne::CalibrationModel::exact) return;
  if (equations == velodyne::CalibrationModel::veloview)
    value.fail_at_key("is veloview without calibration", "it with a calibration file");
  if (velodyne::needs_own_calibration(*sensor.model))
    value.fail_at_key("is given without calibration", "both: each HDL-64E is calibrated on its own");
  sensor.driver.calibration =
      std::make_shared<velodyne::Calibration>(velodyne::table_calibration(*sensor.model));
}

}  // namespace

void read_calibration(Mapping& yaml, SensorConfig& sensor, Reading& reading) {
  const auto file = yaml.find("calibration");
  const auto model = yaml.find("calibration_model");
  if (!file) {
    if (model) apply_to_table(*model, sensor);
    return;
  }
  const std::string expected = "a calibration file, relative to the configuration's folder";
  sensor.calibration = file->text(expected);
  const std::string path = in_folder_of(reading.config.file, sensor.calibration);
  if (::access(path.c_str(), R_OK) != 0)
    file->fail("is " + file->quoted() + ", which cannot be read: " + std::strerror(errno), expected);
  auto calibration = std::make_shared<velodyne::Calibration>(load_calibration(path, reading.config.warnings));
  calibration->model = model ? read_calibration_model(*model) : usual_equations(*calibration, *sensor.model);
  const std::string misfit = calibration_misfit(*calibration, *sensor.model);
  if (!misfit.empty()) file->fail(misfit, "the calibration of this sensor");
  const std::string doubt = calibration_doubt(*calibration, *sensor.model);
  if (!doubt.empty()) reading.warn(file->place(), file->path() + " " + doubt);
  sensor.driver.calibration = std::move(calibration);
}

}  // namespace lidard
