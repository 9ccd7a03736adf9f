// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Any text as a configuration: it is accepted, and then what `lidard check` prints is read back to the same,
// or rejected with a place. Corpus: config/*.yaml; -max_len=4096.
#include <cstdlib>
#include <string>

#include "daemon/config/config.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lidard;
  try {
    const Config config = parse_config(std::string(data, data + size), "text");
    if (to_yaml(parse_config(to_yaml(config), "text")) != to_yaml(config)) std::abort();
  } catch (const ConfigError& error) {
    if (std::string(error.what()).rfind("text:", 0) != 0) std::abort();
  }
  return 0;
}
