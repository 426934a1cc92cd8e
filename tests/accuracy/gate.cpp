#include "accuracy/gate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <thread>

namespace crsm {
namespace {

/// The runs of one course that have ended, as one.
struct Tally {
  std::vector<double> worst_m;  ///< of each run
  double sum_m = 0.0;
  double lost = 0.0;
  double fitness = 1.0;

  void Add(const Outcome& outcome) {
    worst_m.push_back(outcome.worst_m);
    sum_m += outcome.error_m;
    lost = std::max(lost, outcome.lost);
    fitness = std::min(fitness, outcome.mean_fitness);
  }
};

/// What `num_runs` runs come to, of which some may not have ended: these count as if they had no error.
Bounds Finalize(const Tally& tally, int num_runs) {
  std::vector<double> worst_m = tally.worst_m;
  worst_m.resize(std::max(worst_m.size(), static_cast<std::size_t>(num_runs)));
  return {*std::max_element(worst_m.begin(), worst_m.end()), Median(worst_m), tally.sum_m / num_runs, tally.lost,
          tally.fitness};
}

/// What is out of bounds, as it is said.
std::vector<std::string> FindFailures(const Course& course, const Tally& tally) {
  std::vector<std::string> failures;
  const auto CheckMost = [&](const char* what, double value, double bound) {
    if (value <= bound) return;
    failures.push_back(fmt::format("{}: {} is {:.4f}, may be {:.4f} at most", course.name, what, value, bound));
  };
  const Bounds found = Finalize(tally, course.num_seeds);
  const Bounds& bounds = course.bounds;
  CheckMost("the worst error [m]", found.worst_m, bounds.worst_m);
  CheckMost("the median of the runs' worst errors [m]", found.typical_m, bounds.typical_m);
  CheckMost("the mean of the runs' errors [m]", found.mean_m, bounds.mean_m);
  CheckMost("the share of lost scans", found.lost, bounds.lost);
  if (found.fitness < bounds.fitness) {
    failures.push_back(fmt::format("{}: the least mean fitness is {:.4f}, must be {:.4f} at least", course.name,
                                   found.fitness, bounds.fitness));
  }
  return failures;
}

class Gate {
 public:
  explicit Gate(std::vector<Course> courses) : courses_(std::move(courses)), tallies_(courses_.size()) {
    int most = 0;
    for (const Course& course : courses_) most = std::max(most, course.num_seeds);
    for (int seed = 1; seed <= most; ++seed) {
      for (std::size_t i = 0; i < courses_.size(); ++i) {
        if (seed <= courses_[i].num_seeds) jobs_.push_back({i, seed});
      }
    }
  }

  std::vector<std::string> Run() {
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) {
      threads.emplace_back([this] { Work(); });
    }
    for (std::thread& thread : threads) thread.join();
    if (error_) std::rethrow_exception(error_);
    PrintTable();
    std::vector<std::string> failures;
    for (std::size_t i = 0; i < courses_.size(); ++i) {
      const auto found = FindFailures(courses_[i], tallies_[i]);
      failures.insert(failures.end(), found.begin(), found.end());
    }
    return failures;
  }

 private:
  struct Job {
    std::size_t course = 0;
    int seed = 0;
  };

  void Work() {
    try {
      for (std::size_t next = next_job_++; next < jobs_.size() && !stop_; next = next_job_++) Do(jobs_[next]);
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!error_) error_ = std::current_exception();
      stop_ = true;
    }
  }

  void Do(const Job& job) {
    const Course& course = courses_[job.course];
    const Parameters parameters =
        ShippedParameters(course.drive.preset, static_cast<std::uint64_t>(job.seed), course.drive.flags);
    const Outcome outcome = Map(course.drive, parameters);
    const std::scoped_lock lock(mutex_);
    tallies_[job.course].Add(outcome);
    if (std::getenv("CRSM_STOP_AT_FIRST") && !FindFailures(course, tallies_[job.course]).empty()) stop_ = true;
  }

  void PrintTable() const {
    fmt::print("{:<11}{:>5}{:>18}{:>18}{:>18}{:>18}{:>18}\n", "course", "runs", "worst [m]", "median worst [m]",
               "mean error [m]", "lost", "fitness");
    for (std::size_t i = 0; i < courses_.size(); ++i) {
      const int num_runs = static_cast<int>(tallies_[i].worst_m.size());
      if (num_runs == 0) continue;
      const Bounds found = Finalize(tallies_[i], num_runs);
      const Bounds& bounds = courses_[i].bounds;
      fmt::print("{:<11}{:>5}", courses_[i].name, num_runs);
      for (const double Bounds::*value :
           {&Bounds::worst_m, &Bounds::typical_m, &Bounds::mean_m, &Bounds::lost, &Bounds::fitness}) {
        fmt::print("{:>9.4f} ({:>6.4f})", found.*value, bounds.*value);
      }
      fmt::print("\n");
    }
    std::fflush(stdout);
  }

  std::vector<Course> courses_;
  std::vector<Job> jobs_;
  std::atomic<std::size_t> next_job_{0};
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::vector<Tally> tallies_;  ///< of each course, behind the mutex until all threads have ended
  std::exception_ptr error_;    ///< the first, behind the mutex
};

}  // namespace

int NumSeeds(int usual) {
  const char* text = std::getenv("CRSM_ACCURACY_SEEDS");
  return text ? std::max(1, std::atoi(text)) : usual;
}

std::vector<std::string> RunGate(std::vector<Course> courses) {
  for (Course& course : courses) course.num_seeds = NumSeeds(course.num_seeds);
  return Gate(std::move(courses)).Run();
}

}  // namespace crsm
