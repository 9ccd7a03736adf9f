// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/calibration.h"

namespace lidard {

/// The equations by their names in a configuration and on the command line.
constexpr std::pair<std::string_view, velodyne::CalibrationModel> calibration_models[] = {
    {"ros_drivers", velodyne::CalibrationModel::ros_drivers},
    {"exact", velodyne::CalibrationModel::exact},
    {"veloview", velodyne::CalibrationModel::veloview}};
std::optional<velodyne::CalibrationModel> calibration_model_of(std::string_view name);
std::string_view name_of(velodyne::CalibrationModel equations);

/// Reads the calibration of a Velodyne: a YAML file of velodyne_pointcloud, or the db.xml that came with the
/// sensor or from VeloView; the content tells which. Throws ConfigError `file:line:column: what; expected …`
/// (from XML without a column). Remarks that are no errors are added to `warnings`, each with its place. The
/// model is `ros_drivers`, as users of such files expect.
velodyne::Calibration load_calibration(const std::string& path, std::vector<std::string>& warnings);
/// The same from text; `name` stands in messages where a file name would.
velodyne::Calibration parse_calibration(const std::string& text, const std::string& name,
                                        std::vector<std::string>& warnings);

}  // namespace lidard
