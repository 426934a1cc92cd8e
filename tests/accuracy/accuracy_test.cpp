#include "accuracy/gate.hpp"
#include "catch.hpp"

namespace crsm {
namespace {

void CheckGate(const std::vector<Course>& courses) {
  for (const std::string& failure : RunGate(courses)) {
    INFO(failure);
    CHECK(failure.empty());
  }
}

}  // namespace

TEST_CASE("simulated drives are as accurate as they were measured to be, with the parameters that are shipped") {
  CheckGate(SimulatedCourses());
}

TEST_CASE("real drives are as accurate as they were measured to be, with the presets that are shipped", "[logs]") {
  const std::vector<Course> courses = RealCourses();
  if (!courses.empty()) CheckGate(courses);
}

}  // namespace crsm
