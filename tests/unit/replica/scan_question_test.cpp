#include "services/replica/scan_question.hpp"

#include "catch.hpp"
#include "map_owner.hpp"

namespace crsm {

TEST_CASE("the owner is asked about a scan until it has answered, and the answer is of that scan alone") {
  MapOwner owner;
  for (int i = 0; i < 3; ++i) owner.Answer();
  ScanQuestion question;
  for (const std::int64_t utime : {101, 5}) {  // one is in the map, the other is not
    CHECK_FALSE(question.AnswerAbout(utime));
    question.Ask(utime);
    question.Handle(owner.AnswerAbout(102));  // to another's question
    CHECK(question.asked() == utime);
    question.Handle(owner.AnswerAbout(utime));
    CHECK_FALSE(question.asked());
    REQUIRE(question.AnswerAbout(utime));
    CHECK(question.AnswerAbout(utime)->match == (utime == 101 ? std::optional(owner.history[1]) : std::nullopt));
  }
  CHECK_FALSE(question.AnswerAbout(101));
  question.Ask(5);
  CHECK_FALSE(question.asked());  // it is answered already
  question.Forget();
  question.Ask(5);
  CHECK(question.asked() == 5);
}

}  // namespace crsm
