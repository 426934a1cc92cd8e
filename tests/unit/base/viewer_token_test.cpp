#include "services/base/viewer_token.hpp"

#include <cstdlib>

#include "catch.hpp"
#include "services/base/usage_error.hpp"

namespace crsm {
namespace {

/// A value of the variable, as long as the object lives.
class Variable {
 public:
  explicit Variable(const char* value) { setenv(kViewerTokenVariable, value, 1); }
  ~Variable() { unsetenv(kViewerTokenVariable); }
};

}  // namespace

TEST_CASE("a token has 32 hexadecimal digits, and each is another one") {
  CHECK(IsViewerToken(DrawViewerToken()));
  CHECK(DrawViewerToken() != DrawViewerToken());
  for (const char* text :
       {"", "0123456789abcdef", "0123456789abcdef0123456789abcde", "0123456789ABCDEF0123456789ABCDEF",
        "0123456789abcdef0123456789abcdef0", "0123456789abcdef0123456789abcdeg", "0123456789abcdef0123456789abcde\n"}) {
    INFO(text);
    CHECK_FALSE(IsViewerToken(text));
  }
}

TEST_CASE("a token is taken from the environment, and what is none is refused without being repeated") {
  unsetenv(kViewerTokenVariable);
  CHECK_FALSE(ReadViewerToken());
  {
    const Variable empty("");
    CHECK_FALSE(ReadViewerToken());
  }
  {
    const Variable token("0123456789abcdef0123456789abcdef");
    CHECK(ReadViewerToken() == "0123456789abcdef0123456789abcdef");
  }
  const Variable wrong("secret");
  try {
    ReadViewerToken();
    FAIL("was taken");
  } catch (const UsageError& error) {
    CHECK(std::string(error.what()) == "CRSM_VIEWER_TOKEN: is not a token of 32 hexadecimal digits in lower case");
  }
}

}  // namespace crsm
