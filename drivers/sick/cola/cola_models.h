// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "drivers/driver.h"
#include "drivers/recognizer.h"
#include "drivers/sick/cola/cola_row.h"

namespace lidard::sick {

/// Adds the scanners that speak CoLa A and B over TCP to the table of models.
void append_cola_models(std::vector<Model>& list);
/// Recognizes such a scanner by DeviceIdent, else by angles, rates and distances of its scans. If several
/// families fit, others() lists those that were not chosen.
std::unique_ptr<Recognizer> make_cola_recognizer();
/// The search telegram of SICK devices (UDP 30718, as sick_scan_xd sends it; unverified on a device): 24
/// bytes; the answer is XML.
const Discovery& discovery();
/// The model of a device with this `identity` (DeviceIdent); empty if it contains no known name.
std::string_view cola_model_named(std::string_view identity);

/// Topics of the messages beside the scans, in Model::messages.
constexpr std::string_view topic_fields = "lferec";
constexpr std::string_view topic_outputs = "lidoutputstate";
constexpr std::string_view topic_inputs = "lidinputstate";
constexpr std::string_view topic_encoder = "encoder";

/// The driver of every scanner that speaks CoLa A or B; config.model->row is a ColaRow.
std::unique_ptr<Driver> make_cola_driver(const DriverConfig& config);

}  // namespace lidard::sick
