// What a run says of the flags that SUNDIALS returns.

#include <cvode/cvode.h>

#include <catch2/catch.hpp>

#include "run/integrate/sundials.hpp"

using namespace bgsim;

TEST_CASE("a flag that is known is given in words, any other with SUNDIALS' own text") {
  CHECK(cvode_words(CV_ERR_FAILURE, "At t = 0.1, the error test failed.") ==
        "the estimated error stayed too large however small the step");
  CHECK(cvode_words(CV_ILL_INPUT, "tout too close to t0") == "CVODE returned CV_ILL_INPUT: tout too close to t0");
  CHECK(arkode_words(CV_MEM_NULL, "") == "ARKODE returned ARK_MEM_NULL");
}
