// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "drivers/hokuyo/scip_parameters.h"
#include "drivers/recognizer.h"

namespace lidard::hokuyo {

/// What the protocol needs to know of one SCIP sensor before it told.
struct ScipRow {
  std::string_view product;   ///< begin of its own name (MODL, PROD); empty: any
  ScipParameters parameters;  ///< its answer to PP
  CodeTable codes;
  bool has_percent;    ///< newer firmware knows the % extension
  bool sends_on_tick;  ///< answers leave with the next ms of its counter (as urg_stamped found out)
  bool any;            ///< the generic row: takes what the sensor says without a remark
};

/// Adds the SCIP sensors and the UAM-05LP safety scanners to the table of models.
void append_models(std::vector<Model>& list);
std::unique_ptr<Recognizer> make_recognizer();
/// Name of the generic model.
constexpr std::string_view any_scip_name = "hokuyo_scip";
/// The SCIP sensors alone.
void append_scip_models(std::vector<Model>& list);
/// Name of the model whose product name begins `product`, the generic one if none does.
std::string_view scip_name_of(std::string_view product);

}  // namespace lidard::hokuyo
