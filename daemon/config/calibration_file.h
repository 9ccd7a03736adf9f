// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/model.h"
#include "drivers/velodyne/calibration.h"

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

/// The equations to use with that file if nobody asks for others: those of velodyne_pointcloud, as users of
/// such files expect, but with the db.xml of an HDL-64E S1 the viewer's, which its published frame proves.
velodyne::CalibrationModel usual_equations(const velodyne::Calibration& calibration, const Model& model);

/// What keeps this calibration from being that of a sensor of the model: "has 32 lasers, VLP-16 has 16";
/// empty if nothing does.
std::string calibration_misfit(const velodyne::Calibration& calibration, const Model& model);
/// What is suspicious about it, but no reason to refuse it; else empty.
std::string calibration_doubt(const velodyne::Calibration& calibration, const Model& model);
/// True if sensors of this model can be given a calibration.
bool takes_calibration(const Model& model);

}  // namespace lidard
