// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "test/sim/world/scene.h"
#include "test/sim/world/yaml_reader.h"

namespace lidard::sim {

/// Reads a scene file (described in pcaps/README.md); throws SceneError.
Scene load_scene(const std::string& path);
/// The same from text; `name` stands in the messages.
Scene parse_scene(const std::string& text, const std::string& name);

/// One entry of `sensors`.
SensorEntry parse_sensor(const std::string& name, const YamlReader& yaml);

}  // namespace lidard::sim
