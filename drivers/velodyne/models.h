// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/recognizer.h"
#include "drivers/velodyne/model_row.h"

namespace lidard::velodyne {

/// Destination ports of the factory setting: VLP-16 user manual 63-9243 Rev D, section 9.
constexpr std::uint16_t usual_data_port = 2368, usual_telemetry_port = 8308;

/// "HDL-32E" for a product byte of any Velodyne, also of those without a row; "unknown product 0x.."
/// otherwise.
std::string product_name(std::uint8_t product_id);
/// True if some Velodyne has this product byte.
bool is_product(std::uint8_t product_id);

/// Adds the Velodyne rows to the table of models.
void append_models(std::vector<Model>& list);
std::unique_ptr<Recognizer> make_recognizer();
/// A row of the family with such blocks; nullptr if the bytes are not a data packet.
const ModelRow* family_of(ByteView payload);

/// Driver of the spinning Velodynes; `config.model` must be one of velodyne::append_models().
///
/// Frames are revolutions, cut per firing sequence at `config.cut_angle`. A packet that comes after its
/// successor is reordered; a duplicate is dropped. The first and the last revolution of a stream are
/// published only with `keep_partial`.
std::unique_ptr<Driver> make_driver(const DriverConfig& config);

}  // namespace lidard::velodyne
