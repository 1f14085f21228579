// Circuits of transistors: laws with several regions, whose borders the run stays close to.
#include <catch2/catch.hpp>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

TEST_CASE("a gate of transistors runs at tight tolerances, and its errors are estimated beside borders of their laws",
          "[long]") {
  const std::string gate = "tests/data/models/nand_gate.json";
  const RunResult exact = compile_file(gate, with_method(Method::dirk5, 1e-9)).run();
  REQUIRE(exact.stop == StopReason::completed);
  CHECK(compile_file(gate, with_relative(1e-8)).run().stop == StopReason::completed);
  for (const double relative : {1e-4, 1e-6}) {
    INFO(relative);
    const RunResult run = compile_file(gate, with_relative(relative)).run();
    REQUIRE(run.stop == StopReason::completed);
    REQUIRE(run.report.errors.done);
    for (std::size_t k = 0; k < run.trace.names.size(); ++k) {
      INFO(run.trace.names[k]);
      const double range = run.report.errors.range[k];
      const double error = largest_difference(exact.trace.columns[k], run.trace.columns[k]) / range;
      CHECK(error < 100.0 * relative);  // some hundred steps between two pulses
      CHECK(run.report.errors.estimate[k] / range < 5.0 * error);
      CHECK(run.report.errors.estimate[k] / range > error / 5.0);
    }
  }
}
