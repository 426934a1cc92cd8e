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
    question.Handle(owner.AnswerAbout({102, 78}));  // to another's question
    CHECK(question.asked() == utime);
    question.Handle(owner.AnswerAbout({utime, 77}));
    CHECK_FALSE(question.asked());
    REQUIRE(question.AnswerAbout(utime));
    CHECK(question.AnswerAbout(utime)->match == (utime == 101 ? std::optional(owner.history[1]) : std::nullopt));
  }
  CHECK_FALSE(question.AnswerAbout(101));
  question.Ask(5);
  CHECK_FALSE(question.asked());  // it is answered already
  question.NoteMatched(5);
  question.Ask(5);
  CHECK(question.asked() == 5);
}

TEST_CASE("where a clock has stepped back, the scans up to the next one of the map are known to be new") {
  MapOwner owner;
  for (int i = 0; i < 3; ++i) owner.Answer();  // of scans 100 to 102
  ScanQuestion question;
  CHECK_FALSE(question.IsKnownToBeNew(60));
  question.Ask(50);
  question.Handle(owner.AnswerAbout({50, 77}));
  for (const std::int64_t utime : {51, 60, 99}) CHECK(question.IsKnownToBeNew(utime));
  for (const std::int64_t utime : {49, 50, 100, 101, 103}) CHECK_FALSE(question.IsKnownToBeNew(utime));
  question.NoteMatched(60);
  CHECK(question.IsKnownToBeNew(61));
  CHECK_FALSE(question.IsKnownToBeNew(60));
  CHECK_FALSE(question.IsKnownToBeNew(55));  // a scan that comes again may be one that was matched
}

}  // namespace crsm
