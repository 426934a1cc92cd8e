#include "services/diagnosis/several_senders.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

using namespace std::chrono_literals;

const SeveralSenders::Time kStart{1000s};
const Sender kOne{1, 1};
const Sender kOther{1, 2};

}  // namespace

TEST_CASE("two senders by turns are told, whichever is heard, and in one order") {
  SeveralSenders senders;
  CHECK_FALSE(senders.Hear(kOther, kStart));
  CHECK_FALSE(senders.Hear(kOne, kStart + 1ms));
  const auto both = std::pair(kOne, kOther);
  CHECK(senders.Hear(kOther, kStart + 100ms) == both);
  CHECK_FALSE(senders.Hear(kOther, kStart + 200ms));
  CHECK(senders.Hear(kOne, kStart + 201ms) == both);
}

TEST_CASE("a sender that takes the place of another, or sends again after long, is alone") {
  SeveralSenders senders;
  for (int second = 0; second < 20; ++second) {  // each a driver that was started anew
    const Sender sender{1, static_cast<std::uint16_t>(1 + second)};
    for (int i = 0; i < 3; ++i) CHECK_FALSE(senders.Hear(sender, kStart + second * 1s + i * 100ms));
  }
  CHECK_FALSE(senders.Hear(kOne, kStart + 1h));
  CHECK_FALSE(senders.Hear(kOther, kStart + 1h + 1s));
  CHECK_FALSE(senders.Hear(kOne, kStart + 1h + 2s));  // which was silent for 2 s
}

TEST_CASE("senders that are not known are none") {
  SeveralSenders senders;
  for (int i = 0; i < 10; ++i) CHECK_FALSE(senders.Hear(i % 2 == 0 ? Sender{} : kOne, kStart + i * 1ms));
}

}  // namespace crsm
