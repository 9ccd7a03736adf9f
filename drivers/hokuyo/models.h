// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "drivers/driver.h"
#include "drivers/hokuyo/scip_message.h"
#include "drivers/recognizer.h"

namespace lidard::hokuyo {

/// Properties of a SCIP sensor, used until the sensor reports its own.
struct ScipRow {
  std::string_view product;   ///< begin of its own name (MODL, PROD); empty: any
  ScipParameters parameters;  ///< its answer to PP
  CodeTable codes;
  bool has_percent;    ///< newer firmware knows the % extension
  bool sends_on_tick;  ///< answers leave with the next ms of its counter (as urg_stamped found out)
  bool any;            ///< the generic row: accepts the sensor's values without a remark
};

/// Adds the SCIP sensors and the UAM-05LP safety scanners to the table of models.
void append_models(std::vector<Model>& list);
std::unique_ptr<Recognizer> make_recognizer();
/// Asks a Hokuyo for its name (SCIP: VV).
const Discovery& discovery();
/// Name of the generic model.
constexpr std::string_view any_scip_name = "hokuyo_scip";
/// The SCIP sensors alone.
void append_scip_models(std::vector<Model>& list);
/// Name of the model whose product name begins `product`, the generic one if none does.
std::string_view scip_name_of(std::string_view product);

/// Driver of the sensors that speak SCIP 2; `config.model` must be one of append_scip_models().
///
/// On a connection it asks for name, parameters and state, compares the clocks and starts an endless stream;
/// without one (a capture) it reads the stream, from anywhere on.
std::unique_ptr<Driver> make_scip_driver(const DriverConfig& config);

/// Adds the UAM-05LP safety scanners, read by their AR protocol: scan and state come in the same frame.
void append_uam_models(std::vector<Model>& list);

/// Driver of those; `config.model` must be one of append_uam_models().
std::unique_ptr<Driver> make_uam_driver(const DriverConfig& config);

}  // namespace lidard::hokuyo
