// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <regex>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/offline/choice.h"
#include "daemon/yaml/yaml.h"
#include "drivers/calibration_file.h"

namespace lidard::test {

/// The calibration in `text`, as the file "f".
inline Calibration calibration_of(const std::string& text) {
  std::vector<std::string> warnings;
  return parse_calibration(text, "f", parse_yaml, warnings);
}

inline std::vector<std::string> calibration_warnings(const std::string& text) {
  std::vector<std::string> warnings;
  parse_calibration(text, "f", parse_yaml, warnings);
  return warnings;
}

/// The message of the mistake in `text`, as the file "f"; "no error" if there is none.
inline std::string calibration_error(const std::string& text) {
  try {
    calibration_of(text);
    return "no error";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

/// Spoils a text at up to three places, again and again: it is read still, or the error has that form.
inline void expect_placed_errors(const std::string& original, const std::string& alphabet, unsigned seed,
                                 const std::string& form) {
  const std::regex placed(form);
  std::mt19937 random(seed);
  int errors = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string text = original;
    for (std::size_t change = 0; change <= random() % 3; ++change)
      text[random() % text.size()] = alphabet[random() % alphabet.size()];
    if ((text.front() == '<') != (original.front() == '<')) continue;  // of the other format
    const std::string error = calibration_error(text);
    if (error == "no error") continue;
    ++errors;
    EXPECT_TRUE(std::regex_match(error, placed)) << error << "\n--- from:\n" << text;
  }
  EXPECT_GT(errors, 500);
}

}  // namespace lidard::test
