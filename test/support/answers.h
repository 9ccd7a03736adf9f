// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

namespace lidard::test {

/// Compares what `answer` says of each text of a table, a file of the project, with what stands there. Lines
/// that begin with
///   ==  are a title, after which nothing stands around the texts
///   |   stand around the texts that follow, which go where the % is
///   =>  are what is answered to the lines before, all of it
///   ~>  are words of what is answered
///   !>  are words that are not answered
/// All other lines are a text.
void expect_answers(const std::string& table, const std::function<std::string(const std::string&)>& answer);

}  // namespace lidard::test
