// Very short and very long scenes, large models, tolerances, many scenes.
#include <catch2/catch.hpp>

#include "extremes.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

/// 1 ohm and a capacitance over one time constant.
std::string one_time_constant(const std::string& time) {
  const Ran run = ran(charging("1", "1", time, "\"stop\": " + time + ", \"samples\": 11"));
  REQUIRE(run.completed());
  return within(std::abs(run.last("u") - (1.0 - std::exp(-1.0))), 1e-5);
}

/// An oscillator over one period.
std::string period(double relative, double limit) {
  const Ran run =
      ran(oscillator("1", "1", "1", R"("stop": 6.283185307179586, "samples": 11)"), with_relative(relative));
  REQUIRE(run.completed());
  return within(std::max(std::abs(run.last("q") - 1.0), std::abs(run.last("p"))), limit);
}

/// A chain of @p n TF and GY of modulus 1 in turn, between a source and R, I: whatever the length, i(1) = 1 - 1/e.
std::string long_chain(int n) {
  std::string elements = R"("source": { "kind": "Se", "effort": 1 })", bonds, before = "source";
  for (int i = 0; i < n; ++i) {
    const std::string name = "x" + std::to_string(i);
    elements += ", \"" + name + R"(": { "kind": ")" + (i % 2 == 0 ? "GY" : "TF") + R"(", "modulus": 1 })";
    bonds += before + ">" + name + " ";
    before = name;
  }
  elements +=
      R"(, "end": { "kind": "1" }, "r": { "kind": "R", "resistance": 1 }, "i": { "kind": "I", "inertance": 1 })";
  const Ran run =
      ran(model_of(elements, bonds + before + ">end end>r end>i", R"("i": "i.f")", R"("stop": 1, "samples": 3)"));
  REQUIRE(run.completed());
  return within(std::abs(run.last("i") - (1.0 - std::exp(-1.0))), 1e-5);
}

/// A 0-junction with C, a charge through 1 ohm and @p n leaks of n ohm: u(1) = (1 - exp(-2))/2.
std::string large_junction(int n) {
  std::string elements = R"("source": { "kind": "Se", "effort": 1 }, "loop": { "kind": "1" },
      "r": { "kind": "R", "resistance": 1 }, "node": { "kind": "0" }, "c": { "kind": "C", "capacitance": 1 })";
  std::string bonds = "source>loop loop>r loop>node node>c";
  for (int i = 0; i < n; ++i) {
    const std::string name = "leak" + std::to_string(i);
    elements += ", \"" + name + R"(": { "kind": "R", "resistance": )" + std::to_string(n) + " }";
    bonds += " node>" + name;
  }
  const Ran run = ran(model_of(elements, bonds, R"("u": "c.e")", R"("stop": 1, "samples": 3)"));
  REQUIRE(run.completed());
  return within(std::abs(run.last("u") - (1.0 - std::exp(-2.0)) / 2.0), 1e-5);
}

const std::vector<Extreme> kEntries{
    {"a scene of 1e-15 s with a time constant as long", "u = 1 - exp(-1)", [] { return one_time_constant("1e-15"); }},
    {"a scene of 1e9 s likewise", "the same", [] { return one_time_constant("1e9"); }},
    {"a scene of 1e300 s likewise", "the same", [] { return one_time_constant("1e300"); }},
    {"a scene of 1e-320 s",
     "below the resolution of double precision: refused, where plain CVODE fails with NaN for a state",
     [] {
       return diagnosis(ran(charging("1", "1", "1", R"("stop": 1e-320, "samples": 11)")), "BG144",
                        {"cannot be distinguished"});
     }},
    {"a scene of 1e308 s with a time constant of 1 s", "refused: the motion cannot be resolved",
     [] { return diagnosis(ran(charging("1", "1", "1", R"("stop": 1e308, "samples": 3)")), "BG614", {"\"c.q\""}); }},
    {"stop = start = 3", "one record: the start",
     [] {
       const Ran run = ran(charging("1", "1", "1", R"("start": 3, "stop": 3)"));
       REQUIRE(run.completed());
       CHECK(run.result->trace.times == std::vector<double>{3.0});
       return std::string("one record at t = 3");
     }},
    {"a thousand scenes in one file", "the last one is found and run like the first",
     [] {
       std::string text = charging("1", "1", "1", R"("stop": 1, "samples": 2)");
       const std::string scene = R"("main": { "stop": 1, "samples": 2 })";
       const auto at = text.find(scene);
       REQUIRE(at != std::string::npos);
       std::string scenes = scene;
       for (int i = 2; i <= 1000; ++i)
         scenes += ", \"s" + std::to_string(i) + R"(": { "stop": )" + std::to_string(i) + R"(, "samples": 2 })";
       text.replace(at, scene.size(), scenes);
       const Ran run = ran(text, {}, "s1000");
       REQUIRE(run.completed());
       return "u(1000) = 1: " + within(std::abs(run.last("u") - 1.0), 1e-6);
     }},
    {"a chain of 1e5 TF and GY", "no recursion, time linear in the length: i(1) = 1 - exp(-1)",
     [] { return long_chain(100000); }, "[long]"},
    {"a 0-junction with 1e5 bonds", "u(1) = (1 - exp(-2))/2", [] { return large_junction(100000); }, "[long]"},
    {"an oscillator over one period, tolerance 1e-2", "q = 1, p = 0", [] { return period(1e-2, 0.1); }},
    {"tolerance 1e-4", "the same", [] { return period(1e-4, 1e-2); }},
    {"tolerance 1e-8", "the same", [] { return period(1e-8, 1e-5); }},
    {"tolerance 1e-12", "the same", [] { return period(1e-12, 1e-9); }},
    {"tolerance 1e-14", "the same; rounding leaves some 1e-12 after a thousand steps",
     [] { return period(1e-14, 1e-10); }},
    {"tolerance 1e-17", "beyond double precision: a message with the limit",
     [] {
       return diagnosis(
           ran(oscillator("1", "1", "1", R"("stop": 6.283185307179586, "samples": 11)"), with_relative(1e-17)), "BG609",
           {"beyond double precision"});
     }},
    {"a lossless oscillator over 1000 periods with BDF at 1e-6",
     "the method loses energy (plain CVODE 1.4 %): a note with the balance",
     [] {
       const Ran run =
           ran(oscillator("1", "1", "1", R"("stop": 6283.185307179586, "samples": 3)"), with_method(Method::bdf, 1e-6));
       REQUIRE(run.completed());
       CHECK(!run.note("the energy balance is off").empty());
       return std::string("note: the energy balance is off by some per cent");
     }},
    {"the same with Adams at 1e-10", "the energy is kept",
     [] {
       const Ran run = ran(oscillator("1", "1", "1", R"("stop": 6283.185307179586, "samples": 3)"),
                           with_method(Method::adams, 1e-10));
       REQUIRE(run.completed());
       return "energy balance: " + within(run.result->report.energy.relative, 1e-4);
     }},
};

const Section kSection("Time, size and tolerance", kEntries);

}  // namespace
