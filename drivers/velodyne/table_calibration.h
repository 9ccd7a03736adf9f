// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/model.h"
#include "drivers/velodyne/calibration.h"

namespace lidard::velodyne {

/// The angles of the model's table as a calibration with the equations of velodyne_pointcloud. Like the files
/// that velodyne_pointcloud ships it has no offsets: its users' clouds lack the height of the beam's origin.
Calibration table_calibration(const Model& model);

/// True if sensors of this model differ so much that a table tells little (HDL-64E).
bool needs_own_calibration(const Model& model);

}  // namespace lidard::velodyne
