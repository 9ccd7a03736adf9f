// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/table_calibration.h"

#include "core/base/angle.h"
#include "drivers/velodyne/model_row.h"

namespace lidard::velodyne {
namespace {

const ModelRow& row_of(const Model& model) { return *static_cast<const ModelRow*>(model.row); }

}  // namespace

Calibration table_calibration(const Model& model) {
  const ModelRow& row = row_of(model);
  Calibration calibration;
  calibration.distance_step_m = row.distance_step_m;
  calibration.model = CalibrationModel::ros_drivers;
  for (std::size_t k = 0; k < row.lasers; ++k) {
    LaserCalibration laser;
    laser.rot_correction = row.laser[k].rot_correction_deg * rad_per_deg;
    laser.vert_correction = row.laser[k].elevation_deg * rad_per_deg;
    calibration.lasers.push_back(laser);
  }
  return calibration;
}

bool needs_own_calibration(const Model& model) { return row_of(model).banks == 2; }

}  // namespace lidard::velodyne
