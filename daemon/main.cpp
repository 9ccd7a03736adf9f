// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/cli.h"

int main(int argc, char** argv) { return lidard::run_cli(argc, argv); }
