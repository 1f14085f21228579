// Sides of diodes found by trying: how many modes are entered for them.
#include "run/tried_sides.hpp"

#include <catch2/catch.hpp>

#include "bgsim/bgsim.hpp"
#include "study/mode_programs.hpp"

using namespace bgsim;

namespace {

/// A source of effort before @p n sections of diode and resistor in series and capacitor, all empty.
std::string ladder(int n) {
  std::string elements = R"("s": { "kind": "Se", "effort": "1 + t" })", bonds, from = "s";
  for (int i = 0; i < n; ++i) {
    const std::string k = std::to_string(i);
    elements += ", \"j" + k + R"(": { "kind": "1" }, "d)" + k + R"(": { "kind": "D" }, "r)" + k +
                R"(": { "kind": "R", "resistance": 1 }, "n)" + k + R"(": { "kind": "0" }, "c)" + k +
                R"(": { "kind": "C", "capacitance": 1 })";
    for (const auto& [a, b] :
         {std::pair{from, "j" + k}, {"j" + k, "d" + k}, {"j" + k, "r" + k}, {"j" + k, "n" + k}, {"n" + k, "c" + k}})
      bonds += (bonds.empty() ? "" : ", ") + (R"({ "from": ")" + a + R"(", "to": ")" + b + "\" }");
    from = "n" + k;
  }
  return R"({ "bgsim": 1, "name": "ladder", "elements": { )" + elements + R"( }, "bonds": [ )" + bonds +
         R"( ], "outputs": { "u": "c0.e" }, "scenes": { "run": { "stop": 1 } } })";
}

/// Tries the sides of the ladder's diodes from @p present on.
struct Tried {
  std::optional<TriedSides> sides;
  std::size_t entered = 0;  ///< modes
};
Tried try_ladder(int n, const std::vector<bool>& present) {
  const auto model = std::make_shared<const Model>(read_model_text("ladder.json", ladder(n)));
  ModePrograms programs(model, {});
  const RunInputs inputs = prepare_scene(*model, "run");
  const Stored stored = programs.start(inputs).stored;
  Tried tried;
  const auto count = static_cast<std::size_t>(n);
  std::vector<DiodeState> before(count);
  for (std::size_t i = 0; i < count; ++i) {
    before[i].conducts = present[i];
    before[i].may_begin = true;
  }
  const ProgramOfMode program_of = [&](const Mode& mode, const Mode& settling) -> const Program& {
    ++tried.entered;
    return programs.at(mode, inputs.parameters, settling);
  };
  tried.sides = tried_sides(program_of, present, std::vector<bool>(count, true), before, std::vector<bool>(count, true),
                            inputs, stored, [](const StateInfo&) { return 1e-12; }, {});
  return tried;
}

}  // namespace

TEST_CASE("modes are entered until one holds for all small times without a loss, the nearest first") {
  // Sixty of these took 20 s at the start, all of it in 256 modes of which the third was right.
  const int n = 10;
  std::vector<bool> none(n, false), first = none, all(n, true);
  first[0] = true;
  // Where all conduct all flows are positive from the start on.
  const Tried right = try_ladder(n, all);
  REQUIRE(right.sides);
  CHECK(right.sides->conducts == all);
  CHECK(right.entered == 1);
  CHECK(right.sides->flow_error.size() == n);
  CHECK(right.sides->effort_error.size() == n);
  // Where none does, the first is at its effort of 1 at once. That the second has to follow shows within the small
  // times, 1e-4 of the scene at most: an effort of 1e-4, above what it may be off by.
  const Tried blocked = try_ladder(n, none);
  REQUIRE(blocked.sides);
  CHECK(blocked.sides->conducts[0]);
  CHECK(blocked.sides->conducts[1]);
  CHECK(blocked.entered < 256);
}
