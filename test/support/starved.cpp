// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/starved.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace lidard::test {
namespace {

/// s that each thread was ready to run and waited: the second number of its schedstat, in ns
/// (Documentation/scheduler/sched-stats.rst of Linux).
std::map<std::string, double> waited_by_thread() {
  std::map<std::string, double> waited;
  std::error_code none;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task", none)) {
    std::ifstream stat(thread.path() / "schedstat");
    double ran_ns = 0, waited_ns = 0;
    if (stat >> ran_ns >> waited_ns) waited[thread.path().filename()] = waited_ns * 1e-9;
  }
  return waited;
}

/// s that other guests of the host took from all processors: the eighth number of the line `cpu` of
/// /proc/stat (Documentation/filesystems/proc.rst).
double stolen_by_others() {
  std::ifstream stat("/proc/stat");
  std::string name;
  stat >> name;
  double ticks = 0;
  for (int field = 0; field < 8; ++field) stat >> ticks;
  return stat ? ticks / static_cast<double>(sysconf(_SC_CLK_TCK)) : 0;
}

}  // namespace

Starved::Starved() : waited_(waited_by_thread()), stolen_(stolen_by_others()) {}

double Starved::seconds() const {
  double sum = stolen_by_others() - stolen_;
  for (const auto& [thread, waited] : waited_by_thread()) {
    const auto before = waited_.find(thread);
    sum += waited - (before == waited_.end() ? 0 : before->second);
  }
  return sum;
}

std::chrono::nanoseconds Starved::time() const {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds()));
}

}  // namespace lidard::test
