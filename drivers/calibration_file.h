// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/calibration.h"
#include "drivers/document.h"

// The file formats of calibrations. drivers/velodyne defines the functions.
namespace lidard {

/// Names of the equations in a configuration and on the command line.
constexpr std::pair<std::string_view, CalibrationModel> calibration_models[] = {
    {"ros_drivers", CalibrationModel::ros_drivers},
    {"exact", CalibrationModel::exact},
    {"veloview", CalibrationModel::veloview}};
std::optional<CalibrationModel> calibration_model_of(std::string_view name);
std::string_view name_of(CalibrationModel equations);

/// What is expected of a file, for messages.
constexpr const char* calibration_files = "a calibration of velodyne_pointcloud (YAML) or a db.xml";

/// Reads the calibration of a Velodyne: a YAML file of velodyne_pointcloud, which `parse_yaml` parses, or the
/// db.xml of the sensor or of VeloView, recognized by the content. `name` stands for the file in messages.
/// Throws ConfigError `file:line:column: what; expected …` (for XML without a column). Appends warnings with
/// their locations to `warnings`. The model of the result is `ros_drivers`.
Calibration parse_calibration(const std::string& text, const std::string& name, DocumentParser parse_yaml,
                              std::vector<std::string>& warnings);

struct CalibrationFile {
  std::string path, text;
};
/// The calibration that `calibration:` (with `file`) and `calibration_model:` of a sensor ask for; nullptr:
/// that of the model. Throws ConfigError where they contradict each other or the model.
std::shared_ptr<const Calibration> check_calibration(const Mapping& yaml, const Model& model,
                                                     const std::optional<CalibrationFile>& file,
                                                     DocumentParser parse_yaml,
                                                     std::vector<std::string>& warnings);

}  // namespace lidard
