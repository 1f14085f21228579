// Pulses, edges and oscillations that an adaptive step could pass over.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <iomanip>
#include <random>
#include <sstream>

#include "extremes.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

const char* const kTen = R"("stop": 10, "samples": 11)";

/// The end of a charge through 1 ohm into 1 F against its exact value.
std::string charge(const std::string& effort, double exact, double limit, const std::string& scene = kTen) {
  const Ran run = ran(charging(effort, "1", "1", scene));
  REQUIRE(run.completed());
  return within(std::abs(run.last("q") - exact) / std::abs(exact), limit) + " (relative)";
}

/// Charges by pulses that are symmetric about their times, so that each counts as a blow of its area would, but for the
/// square of its width over the time constant (1e-8 here).
std::string random_pulses(int cases) {
  std::mt19937 random(20261121);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 0x1p32;
  };
  double worst = 0.0;
  for (int i = 0; i < cases; ++i) {
    const double stop = std::pow(10.0, uniform(-6.0, 5.0)), tau = stop / uniform(1.0, 5.0);
    const int pulses = 1 + static_cast<int>(random() % 4);
    std::ostringstream flow;
    flow << std::setprecision(17);
    double exact = 0.0, largest = 0.0;
    for (int k = 0; k < pulses; ++k) {
      const double time = stop * uniform(0.05, 0.9), width = stop * std::pow(10.0, uniform(-10.0, -4.0));
      const double area = std::array{1.0, -1.0, 0.3}[random() % 3];
      std::ostringstream x;
      x << std::setprecision(17) << "(t - " << time << ")/" << width;
      const std::array<std::string, 4> shapes{"exp(-(" + x.str() + ")^2)/sqrt(pi)", "max(0, 1 - abs(" + x.str() + "))",
                                              "(step(" + x.str() + " + 0.5) - step(" + x.str() + " - 0.5))",
                                              "(tanh(" + x.str() + " + 2) - tanh(" + x.str() + " - 2))/8"};
      flow << (k > 0 ? " + " : "") << area / width << "*" << shapes[random() % shapes.size()];
      exact += area * std::exp(-(stop - time) / tau);
      largest = std::max(largest, std::abs(area) * std::exp(-(stop - time) / tau));
    }
    std::ostringstream constant, end;
    constant << std::setprecision(17) << tau;
    end << std::setprecision(17) << "\"stop\": " << stop << ", \"samples\": 3";
    const Ran run = ran(model_of(R"("source": { "kind": "Sf", "flow": ")" + flow.str() +
                                     R"(" }, "node": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1 },
        "r": { "kind": "R", "resistance": )" +
                                     constant.str() + " }",
                                 "source>node node>c node>r", R"("q": "c.q")", end.str()));
    CAPTURE(i, flow.str(), stop, tau);
    REQUIRE(run.completed());
    const double error = std::abs(run.last("q") - exact) / largest;
    // A blow far back counts little at the end, where errors of a tolerance of 1e-6 of the state's recent size do.
    CHECK(error < 1e-2);
    worst = std::max(worst, error);
  }
  return "all " + within(worst, 1e-2) + ", relative to the largest share";
}

const std::vector<Extreme> kEntries{
    {"`1000*(step(t - 5) - step(t - 5.001))` on R = C = 1, 10 s",
     "q(10) = 1000 (exp(-4.999) - exp(-5)) = 6.741317e-3; plain CVODE reports success with 0 after 3 steps",
     [] { return charge("1000*(step(t - 5) - step(t - 5.001))", 1000.0 * std::exp(-5.0) * std::expm1(1e-3), 1e-4); }},
    {"a step pulse 1e-9 of the scene wide: 1e9 V for 1e-8 s", "q(10) = 10 exp(-5) (1 + 5e-9): the impulse counts",
     [] {
       return charge("1e9*(step(t - 5) - step(t - 5 - 1e-8))", 1e9 * std::exp(-5.0) * std::expm1(5.00000001 - 5.0),
                     1e-4);
     }},
    {"a bell 1e-9 of the scene wide, `exp(-((t - 5)/1e-8)^2)` of area 1: no edge is declared",
     "q(10) = exp(-5); plain CVODE steps over it and reports 0",
     [] { return charge("1e8/sqrt(pi)*exp(-((t - 5)/1e-8)^2)", std::exp(-5.0), 1e-4); }},
    {"a triangle of the same width, `1e8*max(0, 1 - abs(t - 5)/1e-8)`", "q(10) = exp(-5)",
     [] { return charge("1e8*max(0, 1 - abs(t - 5)/1e-8)", std::exp(-5.0), 1e-4); }},
    {"a pulse with broad feet, `1/(1 + ((t - 5)/1e-8)^2)`, of area 1", "q(12) = exp(-7), and 2e-9 from the feet",
     [] { return charge("1e8/pi/(1 + ((t - 5)/1e-8)^2)", std::exp(-7.0), 1e-2, R"("stop": 12, "samples": 11)"); }},
    {"a hundred sources, each the sum of up to four pulses of areas 1, -1 and 0.3: bells, triangles, steps, hats, "
     "1e-10 to 1e-4 of the scene wide, scenes of 1e-6 to 1e5 s",
     "low and broad pulses count as much as high and narrow ones: q = sum of area exp(-(stop - time)/tau)",
     [] { return random_pulses(100); }},
    {"a triangle of area 1 and width 1e-10, 1e-11 of the scene", "q(10) = exp(-5)",
     [] { return charge("1e10*max(0, 1 - abs(t - 5)/1e-10)", std::exp(-5.0), 1e-3); }},
    {"a step pulse of area 1 and 1e-12 s", "q(10) = exp(-5), within the 1e-3 by which doubles near 5 round the width",
     [] { return charge("1e12*(step(t - 5) - step(t - 5 - 1e-12))", std::exp(-5.0), 1e-3); }},
    {"a bell of 1e-12 s, `exp(-((t - 5)/1e-12)^2)`: 5000 neighbouring doubles", "a message that it cannot be followed",
     [] {
       return diagnosis(ran(charging("exp(-((t - 5)/1e-12)^2)", "1", "1", kTen)), "BG615",
                        {"exp(-((t - 5)/1e-12)^2)", "t = 5"});
     }},
    {"a step pulse of 1e-14 s: 11 doubles", "the same",
     [] {
       return diagnosis(ran(charging("step(t - 5) - step(t - 5 - 1e-14)", "1", "1", kTen)), "BG615",
                        {"step(t - 5)", "t = 5"});
     }},
    {"a flank of 1e-14 s, `1 + tanh((t - 5)/1e-14)`", "equivalent to a jump: q(10) = 2 (1 - exp(-5))",
     [] { return charge("1 + tanh((t - 5)/1e-14)", -2.0 * std::expm1(-5.0), 1e-5); }},
    {"1 kHz square wave `sign(sin(2*pi*1000*t))`, 1 s: 1999 edges",
     "q(1) = -tanh(T/4)(1 - exp(-1)), T = 1e-3; plain CVODE takes 62540 steps",
     [] {
       return charge("sign(sin(2*pi*1000*t))", -std::tanh(0.25e-3) * (1.0 - std::exp(-1.0)), 2e-3,
                     R"("stop": 1, "samples": 11)");
     }},
    {"`sin(2*pi*1e3*t)^2` integrated over 10 s: ten thousand periods", "q(10) = 5",
     [] {
       const Ran run = ran(filling("sin(2*pi*1e3*t)^2", "0", kTen), with_relative(1e-4));
       REQUIRE(run.completed());
       return within(std::abs(run.last("q") - 5.0) / 5.0, 5e-2) + " (relative, at tolerance 1e-4)";
     }},
    {"`sin(2*pi*1e6*t)^2` over 10 s at tolerance 1e-3: 1e7 periods, far fewer steps",
     "the mean, 1/2, or a note that the source was only sampled: more than 0.2 periods a step",
     [] {
       const Ran run = ran(charging("sin(2*pi*1e6*t)^2", "1e6", "1", kTen), with_relative(1e-3));
       REQUIRE(run.completed());
       const std::string note = run.note("a source goes up and down");
       CHECK(!note.empty());
       return "note: " + note.substr(0, note.find(", of which")) + " ... the steps saw samples only";
     }},
    {"discontinuities on output times: steps at 0.3, 0.6, 0.7 with outputs every 0.1",
     "outputs are continuous from the right: 1, 2, 3 from these times on",
     [] {
       const Ran run = ran(model_of(R"("source": { "kind": "Se", "effort": "step(t - 0.3) " }, "loop": { "kind": "1" },
           "r": { "kind": "R", "resistance": 1 }, "c": { "kind": "C", "capacitance": 1 })",
                                    "source>loop loop>r loop>c",
                                    R"("v": "step(t - 0.3) + step(t - 0.6) + step(t - 0.7) ", "u": "source.e")",
                                    R"("stop": 2, "samples": 21)"));
       REQUIRE(run.completed());
       const std::vector<double> v = column(*run.result, "v");
       for (std::size_t i = 0; i < v.size(); ++i) CHECK(v[i] == (i >= 3) + (i >= 6) + (i >= 7));
       return std::string("exact at all 21 output times");
     }},
};

const Section kSection("Sources", kEntries);

}  // namespace
