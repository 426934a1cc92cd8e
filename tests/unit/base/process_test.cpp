#include "services/base/process.hpp"

#include "catch.hpp"

using namespace crsm;

TEST_CASE("an identity is the same until the machine starts anew, and each is another one") {
  CHECK(IdentityOfThisBoot(5) == IdentityOfThisBoot(5));
  CHECK(IdentityOfThisBoot(5) != 5);
  CHECK(IdentityOfThisBoot(5) != IdentityOfThisBoot(6));
  const std::int64_t mixed = IdentityOfThisBoot(5) ^ 5;
  CHECK(IdentityOfThisBoot(mixed) != 0);  // which stands for no map
}
