// Dry friction that is held beside ideal diodes and contacts: what holds it and what these carry follow from each
// other.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "support/run.hpp"

using namespace bgsim;
using namespace bgsim::test;

namespace {

constexpr Method kMethods[] = {Method::automatic, Method::bdf, Method::erk5, Method::rodas5p};

RunResult run_scene(const std::string& text, Method method, double relative) {
  return Study::from_text(text).scene("main", with_method(method, relative)).simulate(SimulateOptions{});
}

/// A mass of 1 that a force pulls, a clutch to another mass of 1, and there a backstop: a speed of 0 or less.
std::string clutch_and_backstop(const std::string& law, const std::string& force, const std::string& backstop) {
  return R"({ "bgsim": 1, "name": "backstop", "elements": {
      "n0": { "kind": "1" }, "m0": { "kind": "I", "inertance": 1 }, "F": { "kind": "Se", "effort": ")" +
         force + R"(" }, "h": { "kind": "0" }, "grip": { "kind": "R", "law": ")" + law + R"(" },
      "n1": { "kind": "1" }, "m1": { "kind": "I", "inertance": 1 }, "stop": )" +
         backstop + R"( },
    "bonds": [ { "from": "n0", "to": "m0" }, { "from": "F", "to": "n0" }, { "from": "n0", "to": "h" },
      { "from": "h", "to": "grip" }, { "from": "h", "to": "n1" }, { "from": "n1", "to": "m1" },
      { "from": "n1", "to": "stop" } ],
    "outputs": { "v0": "n0.f", "v1": "n1.f", "push": "stop.e" }, "scenes": { "main": { "stop": 7, "samples": 15 } } })";
}

const char* const kDiode = R"({ "kind": "D", "passes": "out" })";
const char* const kContact = R"({ "kind": "contact", "gap": 0, "initial": { "q": 0 } })";

/// Masses of a chain to the ground and to each other.
struct Chain {
  enum class Kind { spring, friction, diode };
  struct Link {
    Kind kind;
    int from, to;  ///< to: -1 is the ground
    double value;  ///< stiffness; limit
  };
  std::vector<double> masses, forces, amplitudes, frequencies;
  std::vector<Link> links;

  [[nodiscard]] double force(std::size_t mass, double t) const {
    return forces[mass] + amplitudes[mass] * std::sin(frequencies[mass] * t);
  }

  [[nodiscard]] std::string text() const {
    std::string elements, bonds, outputs;
    const auto bond = [&bonds](const std::string& from, const std::string& to) {
      bonds += std::string(bonds.empty() ? "" : ", ") + R"({ "from": ")" + from + R"(", "to": ")" + to + R"(" })";
    };
    const auto element = [&elements](const std::string& name, const std::string& keys) {
      elements += std::string(elements.empty() ? "\"" : ", \"") + name + R"(": { )" + keys + " }";
    };
    for (std::size_t i = 0; i < masses.size(); ++i) {
      const std::string n = "n" + std::to_string(i), m = "m" + std::to_string(i), F = "F" + std::to_string(i);
      element(n, R"("kind": "1")");
      element(m, R"("kind": "I", "inertance": )" + number_text(masses[i], 17));
      const std::string sine = number_text(amplitudes[i], 17) + "*sin(" + number_text(frequencies[i], 17) + "*t)";
      element(F, R"("kind": "Se", "effort": ")" + number_text(forces[i], 17) + " + " + sine + "\"");
      bond(n, m);
      bond(F, n);
      outputs += std::string(outputs.empty() ? "\"v" : ", \"v") + std::to_string(i) + R"(": ")" + n + R"(.f")";
    }
    for (std::size_t k = 0; k < links.size(); ++k) {
      const Link& link = links[k];
      const std::string name = "e" + std::to_string(k), n = "n" + std::to_string(link.from);
      const std::string value = number_text(link.value, 17);
      if (link.kind == Kind::spring)
        element(name, R"("kind": "C", "capacitance": "1/)" + value + "\"");
      else if (link.kind == Kind::friction)
        element(name, R"("kind": "R", "law": "e = )" + value + "*sign(f)\"");
      else
        element(name, R"("kind": "D", "passes": "out")");
      if (link.to < 0) {
        bond(n, name);
        continue;
      }
      const std::string h = "h" + std::to_string(k);
      element(h, R"("kind": "0")");
      bond(n, h);
      bond(h, "n" + std::to_string(link.to));
      bond(h, name);
    }
    return R"({ "bgsim": 1, "name": "chain", "elements": { )" + elements + R"( }, "bonds": [ )" + bonds +
           R"( ], "outputs": { )" + outputs + R"( }, "scenes": { "main": { "stop": 3, "samples": 31 } } })";
  }

  /// Moreau's time stepping: impulses within their sets, by Gauss-Seidel, at steps of 1e-4. Of first order.
  [[nodiscard]] std::vector<std::vector<double>> stepped() const {
    constexpr double kStep = 1e-4;
    constexpr int kStepsARow = 1000, kRows = 31, kSweeps = 400;
    std::vector<double> v(masses.size(), 0.0), stretch(links.size(), 0.0);
    std::vector<std::vector<double>> rows{v};
    const auto speed = [&](const Link& link) {
      return v[static_cast<std::size_t>(link.from)] - (link.to < 0 ? 0.0 : v[static_cast<std::size_t>(link.to)]);
    };
    const auto push = [&](const Link& link, double impulse) {
      const auto from = static_cast<std::size_t>(link.from);
      v[from] -= impulse / masses[from];
      if (link.to >= 0) v[static_cast<std::size_t>(link.to)] += impulse / masses[static_cast<std::size_t>(link.to)];
    };
    for (int step = 0; step < kStepsARow * (kRows - 1); ++step) {
      const double t = kStep * (step + 0.5);
      for (std::size_t i = 0; i < v.size(); ++i) v[i] += kStep * force(i, t) / masses[i];
      for (std::size_t k = 0; k < links.size(); ++k)
        if (links[k].kind == Kind::spring) push(links[k], kStep * links[k].value * stretch[k]);
      std::vector<double> impulse(links.size(), 0.0);
      for (int sweep = 0; sweep < kSweeps; ++sweep) {
        double most = 0.0;
        for (std::size_t k = 0; k < links.size(); ++k) {
          const Link& link = links[k];
          if (link.kind == Kind::spring) continue;
          const double inverse = 1.0 / masses[static_cast<std::size_t>(link.from)] +
                                 (link.to < 0 ? 0.0 : 1.0 / masses[static_cast<std::size_t>(link.to)]);
          const double wanted = impulse[k] + speed(link) / inverse, limit = kStep * link.value;
          const double next = link.kind == Kind::diode ? std::max(0.0, wanted) : std::clamp(wanted, -limit, limit);
          push(link, next - impulse[k]);
          most = std::max(most, std::abs(next - impulse[k]));
          impulse[k] = next;
        }
        if (most < 1e-14) break;
      }
      for (std::size_t k = 0; k < links.size(); ++k) stretch[k] += kStep * speed(links[k]);
      if ((step + 1) % kStepsARow == 0) rows.push_back(v);
    }
    return rows;
  }
};

}  // namespace

TEST_CASE("a backstop beside friction that is held opens where the force turns") {
  // Both masses go back together, with a quarter of the force. The effort of the backstop is that of friction, which a
  // network with its sign at 0 knows nothing of: it pulled.
  const struct {
    std::string force;
    double (*speed)(double);
  } members[] = {
      {"0.5*cos(t)", [](double t) { return t < M_PI_2 ? 0.0 : 0.25 * (std::sin(t) - 1.0); }},
      {"if(t < 1, 0.5, -0.5)", [](double t) { return -0.25 * std::max(0.0, t - 1.0); }},
      {"-0.5", [](double t) { return -0.25 * t; }},
  };
  for (const std::string law :
       {"e = sign(f)", "e = if(f >= 0, 1, -1)", "e = 2*step(f) - 1", "e = if(f > 0, 1, if(f < 0, -1, 0))"})
    for (const auto& member : members)
      for (const char* const backstop : {kDiode, kContact})
        for (const Method method : kMethods) {
          INFO(law << ", " << member.force << ", " << backstop << " by " << method_name(method));
          const RunResult run = run_scene(clutch_and_backstop(law, member.force, backstop), method, 1e-8);
          REQUIRE(run.stop == StopReason::completed);
          for (std::size_t i = 0; i < run.trace.times.size(); ++i) {
            // A hundred tolerances of the largest speed, 0.5.
            const double exact = member.speed(run.trace.times[i]);
            CHECK(column(run, "v0")[i] == Approx(exact).margin(5e-7));
            CHECK(column(run, "v1")[i] == Approx(exact).margin(5e-7));
            CHECK(column(run, "push")[i] >= -1e-9);
          }
        }
}

TEST_CASE("a ratchet beside friction that is held drags nothing along") {
  // m2 is pulled back and holds m0 by friction; m1 may go faster than m0, not slower.
  const std::string text = R"j({ "bgsim": 1, "name": "ratchet", "elements": {
      "n0": { "kind": "1" }, "m0": { "kind": "I", "inertance": 1 }, "n1": { "kind": "1" },
      "m1": { "kind": "I", "inertance": 1 }, "n2": { "kind": "1" }, "m2": { "kind": "I", "inertance": 1 },
      "F": { "kind": "Se", "effort": -0.08 }, "h": { "kind": "0" }, "ratchet": { "kind": "D", "passes": "out" },
      "k": { "kind": "0" }, "grip": { "kind": "R", "law": "e = sign(f)" } },
    "bonds": [ { "from": "n0", "to": "m0" }, { "from": "n1", "to": "m1" }, { "from": "n2", "to": "m2" },
      { "from": "F", "to": "n2" }, { "from": "n0", "to": "h" }, { "from": "h", "to": "n1" },
      { "from": "h", "to": "ratchet" }, { "from": "n0", "to": "k" }, { "from": "k", "to": "n2" },
      { "from": "k", "to": "grip" } ],
    "outputs": { "v0": "n0.f", "v1": "n1.f", "v2": "n2.f" }, "scenes": { "main": { "stop": 4, "samples": 5 } } })j";
  for (const Method method : kMethods) {
    INFO(method_name(method));
    const RunResult run = run_scene(text, method, 1e-8);
    REQUIRE(run.stop == StopReason::completed);
    CHECK(column(run, "v0").back() == Approx(-0.16).epsilon(1e-9));
    CHECK(column(run, "v2").back() == Approx(-0.16).epsilon(1e-9));
    CHECK(std::abs(column(run, "v1").back()) <= 1e-12);
  }
}

TEST_CASE("random chains with friction and diodes agree with time stepping", "[long]") {
  std::mt19937 random(3);
  const auto between = [&random](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const auto below = [&random](int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); };
  int refused = 0;
  constexpr int kModels = 30;
  for (int model = 0; model < kModels; ++model) {
    Chain chain;
    const int count = 2 + below(2);
    for (int i = 0; i < count; ++i) {
      chain.masses.push_back(between(0.5, 3.0));
      chain.forces.push_back(below(2) == 0 ? between(-2.0, 2.0) : 0.0);
      chain.amplitudes.push_back(below(3) > 0 ? between(1.0, 6.0) : 0.0);
      chain.frequencies.push_back(between(1.0, 8.0));
    }
    const auto link = [&](int from, int to) {
      using Kind = Chain::Kind;
      const Kind kinds[] = {Kind::spring, Kind::friction, Kind::friction, Kind::diode, Kind::diode};
      const Kind kind = kinds[below(5)];
      chain.links.push_back({kind, from, to, kind == Kind::spring ? between(5.0, 60.0) : between(0.3, 3.0)});
    };
    for (int i = 0; i < count; ++i) link(i, -1);
    for (int i = 0; i + 1 < count; ++i) link(i, i + 1);
    if (below(2) == 0) link(0, 1);
    INFO(chain.text());
    const RunResult run = run_scene(chain.text(), Method::automatic, 1e-7);
    if (run.stop != StopReason::completed) {
      // Where diodes lock what rubs on each other no speed says what the friction is.
      REQUIRE(run.failure->code == "BG622");
      ++refused;
      continue;
    }
    const std::vector<std::vector<double>> rows = chain.stepped();
    double largest = 0.1;
    for (const std::vector<double>& row : rows)
      for (const double v : row) largest = std::max(largest, std::abs(v));
    for (std::size_t row = 0; row < rows.size(); ++row)
      for (std::size_t i = 0; i < rows[row].size(); ++i) {
        INFO("row " << row << ", v" << i);
        // Steps of 1e-4 under accelerations of up to 10 a unit of mass.
        CHECK(column(run, "v" + std::to_string(i))[row] == Approx(rows[row][i]).margin(3e-3 * largest));
      }
  }
  CHECK(refused <= kModels / 20);
}
