// What a run says of the flags that SUNDIALS returns.

#include <catch2/catch.hpp>

#include "run/integrate/packages.hpp"

using namespace bgsim;

TEST_CASE("a flag that is known is given in words, any other with SUNDIALS' own text") {
  CHECK(flag_words<Cvode>(CV_ERR_FAILURE, "At t = 0.1, the error test failed.") ==
        "the estimated error stayed too large however small the step");
  CHECK(flag_words<Cvode>(CV_ILL_INPUT, "tout too close to t0") == "CVODE returned CV_ILL_INPUT: tout too close to t0");
  CHECK(flag_words<Arkode>(CV_MEM_NULL, "") == "ARKODE returned ARK_MEM_NULL");
  CHECK(flag_words<Ida>(IDA_TOO_MUCH_ACC, "") == "the tolerance is beyond double precision");
}
