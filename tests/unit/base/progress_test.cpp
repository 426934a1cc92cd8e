#include "services/base/progress.hpp"

#include "catch.hpp"

namespace crsm {

TEST_CASE("progress is a bar with the time that is left where a terminal has room, and never longer than its line") {
  CHECK(FormatProgress("it", 0.25, 1000, 2.0, 60) == "it: [###.........]  25 %, 1000 scans, 500 scans/s, 6 s left");
  CHECK(FormatProgress("it", 0.25, 1000, 2.0, 0) == "it:  25 %, 1000 scans, 500 scans/s, 6 s left");
  CHECK(FormatProgress("it", 0.25, 1000, 2.0, 50) == "it:  25 %, 1000 scans, 500 scans/s, 6 s left");
  CHECK(FormatProgress("it", 0.25, 1000, 2.0, 20) == "it:  25 %, 1000 sca");
  CHECK(FormatProgress("it", 0.0, 1, 0.0, 0) == "it:   0 %, 1 scan, 1000 scans/s");
  CHECK(FormatProgress("it", 0.5, 10, 200.0, 0).ends_with("3 min left"));
  CHECK(FormatProgress("it", 0.01, 10, 200.0, 0).ends_with("5 h 30 min left"));
  CHECK(FormatProgress("it", 1.0, 10, 200.0, 80).ends_with("100 %, 10 scans, 0 scans/s, 0 s left"));
  for (int columns = 0; columns < 120; ++columns) {
    CHECK((columns == 0 || std::cmp_less(FormatProgress("it", 0.7, 123456, 99.0, columns).size(), columns)));
  }
}

}  // namespace crsm
