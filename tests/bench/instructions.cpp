// Runs one workload once, for a tool that counts instructions; without an argument lists the workloads.

#include <cstdio>
#include <string>

#include "bench/workloads.hpp"

/// The tool counts from where this is entered to where it is left.
extern "C" __attribute__((noinline)) void RunMeasured(const crsm::bench::Workload* workload) { workload->run(); }

int main(int argc, char** argv) {
  for (const crsm::bench::Workload& workload : crsm::bench::MakeWorkloads()) {
    if (argc < 2) {
      std::puts(workload.name.c_str());
    } else if (workload.name == argv[1]) {
      workload.run();  // what happens only the first time is not counted
      RunMeasured(&workload);
      return 0;
    }
  }
  return argc < 2 ? 0 : 1;
}
