/// Cases with known answers from textbooks, papers and other tools' own tests (docs/known-answers.md lists them by the
/// same numbers). Conventions: a transformer's modulus is e1/e2 = f2/f1; sources count along the half-arrow; q' and p'
/// are counted into the store. Tolerances: numbers printed with n digits are held to half a unit of the last one;
/// closed forms to 1e-7, what the scenes' relative tolerance of 1e-9 or 1e-10 leaves after a run.
#include <catch2/catch.hpp>
#include <cmath>

#include "support/run.hpp"

namespace {

using namespace bgsim;
using test::at;
using test::column;
using test::linear;
using test::poles;
using test::run;
using test::study_of;

const std::string kFolder = "tests/data/models/";

/// An output equals a closed form at every record.
void check_form(const RunResult& result, const std::string& output, double scale,
                const std::function<double(double)>& form) {
  const std::vector<double> values = column(result, output);
  for (std::size_t i = 0; i < values.size(); ++i) {
    INFO(output << " at t = " << result.trace.times[i]);
    CHECK(std::abs(values[i] - form(result.trace.times[i])) <= 1e-7 * scale);
  }
}

void check_poles(const std::vector<std::complex<double>>& found, const std::vector<std::complex<double>>& expected,
                 double tolerance) {
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    INFO("pole " << found[i] << ", expected " << expected[i]);
    CHECK(std::abs(found[i] - expected[i]) <= tolerance);
  }
}

/// Printed numbers: {time, value} pairs to a relative tolerance of the column's size.
void check_values(const RunResult& result, const std::string& output,
                  const std::vector<std::pair<double, double>>& expected, double tolerance) {
  for (const auto& [time, value] : expected) {
    INFO(output << " at t = " << time);
    CHECK(at(result, output, time) == Approx(value).margin(tolerance).epsilon(0));
  }
}

TEST_CASE("P1: a capacitor discharges through a resistor as exp(-t/(R C))") {
  const auto study = study_of(kFolder + "rc_discharge.json");
  check_form(run(study, "two"), "q", 10, [](double t) { return 10 * std::exp(-t / 2); });
  check_form(run(study, "three"), "q", 5, [](double t) { return 5 * std::exp(-t / 3); });
}

TEST_CASE("P2: two resistors in series discharge a capacitor as their sum does") {
  check_form(run(study_of(kFolder + "series_resistors.json")), "q", 10, [](double t) { return 10 * std::exp(-t / 9); });
}

TEST_CASE("P3: the pi filter settles at q_a = 1, q_b = 0.5, p = 0.5") {
  const auto result = run(study_of(kFolder + "pi_filter.json"), "end");
  CHECK(at(result, "q_a", 100) == Approx(1).margin(1e-7));
  CHECK(at(result, "q_b", 100) == Approx(0.5).margin(1e-7));
  CHECK(at(result, "p_L", 100) == Approx(0.5).margin(1e-7));
}

TEST_CASE("P4: a 0-junction split over two submodels behaves as one") {
  const auto result = run(study_of(kFolder + "modular.json"));
  const double w = std::sqrt(3.0) / 2, root = std::sqrt(3.0);
  check_form(result, "q", 2, [&](double t) { return std::exp(-t / 2) * (std::cos(w * t) - root * std::sin(w * t)); });
  check_form(result, "p", 2, [&](double t) { return std::exp(-t / 2) * (std::cos(w * t) + root * std::sin(w * t)); });
}

TEST_CASE("P5: a filter follows a constant and a sine of time") {
  const auto study = study_of(kFolder + "driven_filter.json");
  check_values(run(study, "constant"), "q", {{5, 2.986524106}}, 5e-10);
  check_values(run(study, "wave"), "q", {{5, 0.2362575153}}, 5e-10);
}

TEST_CASE("P6: a decaying source charges a capacitor to t exp(-t)") {
  check_form(run(study_of(kFolder + "decaying_source.json")), "q", 1, [](double t) { return t * std::exp(-t); });
}

TEST_CASE("P7: a capacitor on a source has the source's derivative as its flow, and no state") {
  const auto study = study_of(kFolder + "source_on_store.json");
  CHECK(study.equations().states.empty());
  const auto result = run(study);
  const auto u = [](double t) { return 2 + std::sin(3 * t); };
  check_form(result, "q", 1, u);
  check_form(result, "flow", 1, [](double t) { return 3 * std::cos(3 * t); });
  check_form(result, "drawn", 1, [&](double t) { return u(t) + 3 * std::cos(3 * t); });
}

TEST_CASE("P8: Duffing's storage gives x0' = u - x1 and x1' = x0 + x0^3") {
  const auto result = run(study_of(kFolder + "duffing_from_energy.json"));
  const auto x0 = column(result, "x0"), x1 = column(result, "x1"), x0_rate = column(result, "x0_rate"),
             x1_rate = column(result, "x1_rate");
  for (std::size_t i = 0; i < x0.size(); ++i) {
    CHECK(x0_rate[i] == Approx(0.7 - x1[i]).margin(1e-12));
    CHECK(x1_rate[i] == Approx(x0[i] + x0[i] * x0[i] * x0[i]).margin(1e-12));
    // H + the work of the constant source: d(x0^2/2 + x0^4/4 + x1^2/2 - u x1)/dt = 0 since u x0' - ... = u x1'.
    const double h = x0[i] * x0[i] / 2 + std::pow(x0[i], 4) / 4 + x1[i] * x1[i] / 2 - 0.7 * x1[i];
    CHECK(h == Approx(0.08 + 0.0064 + 0.845 + 0.91).margin(1e-6));
  }
}

TEST_CASE("P9: a two-port storage gives the capacitor with a moving plate") {
  const auto result = run(study_of(kFolder + "moving_plate.json"));
  const auto q0 = column(result, "q0"), q1 = column(result, "q1"), e0 = column(result, "e0"), e1 = column(result, "e1");
  for (std::size_t i = 0; i < q0.size(); ++i) {
    CHECK(e0[i] == Approx(q0[i] / (0.5 + q1[i])).epsilon(1e-13));
    CHECK(e1[i] == Approx(-q0[i] * q0[i] / (2 * (0.5 + q1[i]) * (0.5 + q1[i]))).epsilon(1e-13));
  }
  check_form(result, "q0", 1, [](double t) { return 0.8 + 0.3 * t; });
}

TEST_CASE("P10: a closed cycle of reactions has the rows -4 2 9, 1 -6 6, 3 4 -15") {
  const auto a = linear(study_of(kFolder + "reaction_cycle.json"), "closed").a;
  const std::vector<double> expected{-4, 2, 9, 1, -6, 6, 3, 4, -15};
  for (std::size_t i = 0; i < expected.size(); ++i) CHECK(a[i] == Approx(expected[i]).epsilon(1e-12));
}

TEST_CASE("P11: chemostats drive the cycle, and none at equilibrium") {
  const auto study = study_of(kFolder + "reaction_cycle.json");
  CHECK(at(run(study, "low"), "v1", 10) == Approx(-3.0906200316489003).margin(1e-6));
  CHECK(at(run(study, "even"), "v1", 10) == Approx(0).margin(1e-6));
  CHECK(at(run(study, "high"), "v1", 10) == Approx(10.860335195530652).margin(1e-6));
}

TEST_CASE("P13: A + B = C and A = 2 B approach equilibrium at the rate of mass action") {
  const auto abc = run(study_of(kFolder + "reaction.json"), "run");
  CHECK(at(abc, "A", 3) == Approx(1.236067606).margin(5e-9));
  CHECK(at(abc, "B", 3) == Approx(2.236067606).margin(5e-9));
  CHECK(at(abc, "C", 3) == Approx(2.763932394).margin(5e-9));
  const auto ab = run(study_of(kFolder + "stoichiometry.json"));
  CHECK(at(ab, "A", 1) == Approx(0.6196882901).margin(5e-9));
  CHECK(at(ab, "B", 1) == Approx(0.7606234199).margin(5e-9));
}

TEST_CASE("P15: two resistors in series form one loop with the pole -1/(c (r1 + r2))") {
  const auto study = study_of(kFolder + "rr_series_loop.json");
  const auto lin = linear(study, {}, {"u"});
  check_poles(poles(lin), {-1 / (0.5 * 5)}, 1e-13);
  CHECK(lin.c[0] * lin.b[0] == Approx(1 / (0.5 * 5)).epsilon(1e-13));
  check_form(run(study), "y", 1, [](double t) { return 1 - std::exp(-t / 2.5); });
}

TEST_CASE("P16: two RC sections have the published poles and step response") {
  const auto study = study_of(kFolder + "rc2.json");
  check_poles(poles(linear(study)), {-2 - std::sqrt(2.0), -2 + std::sqrt(2.0)}, 1e-12);
  check_values(run(study), "y", {{1, 0.334856680634}, {2, 0.62616697426}, {5, 0.935475217582}}, 1e-9);
}

TEST_CASE("P17: motor and generator on an elastic shaft have the published matrices and steady state") {
  const auto study = study_of(kFolder + "motor_generator.json");
  {
    // States: motor's coil and rotor, shaft, generator's rotor and coil (the report lists the coil first).
    const double rm = 2, lm = 3, km = 5, jm = 7, bm = 11, cs = 13, jg = 17, bg = 19, kg = 23, lg = 29, rg = 31, rl = 37;
    const auto lin = linear(
        study, {}, {"u"},
        {"rm=2", "lm=3", "km=5", "jm=7", "bm=11", "cs=13", "jg=17", "bg=19", "kg=23", "lg=29", "rg=31", "rl=37"});
    const std::vector<double> a{
        -rm / lm, -km / jm, 0,       0,        0,                //
        km / lm,  -bm / jm, -1 / cs, 0,        0,                //
        0,        1 / jm,   0,       -1 / jg,  0,                //
        0,        0,        1 / cs,  -bg / jg, kg / lg,          //
        0,        0,        0,       -kg / jg, -(rg + rl) / lg,  //
    };
    for (std::size_t i = 0; i < a.size(); ++i) CHECK(lin.a[i] == Approx(a[i]).margin(1e-14));
    for (std::size_t i = 0; i < 5; ++i) {
      CHECK(lin.b[i] == Approx(i == 0 ? 1 : 0).margin(1e-14));
      CHECK(lin.c[i] == Approx(i == 4 ? rl / lg : 0).margin(1e-14));  // the first output is the load's voltage
    }
  }
  const auto lin = linear(study);
  check_poles(poles(lin),
              {{-1.285624088, -0.8404194198},
               {-1.285624088, 0.8404194198},
               {-1, 0},
               {-0.7143759122, -1.567436582},
               {-0.7143759122, 1.567436582}},
              5e-10);
  const auto result = run(study);
  const std::vector<double> rest{5, 2, 3, -1, 2};
  for (std::size_t i = 0; i < rest.size(); ++i)
    CHECK(at(result, "x" + std::to_string(i + 1), 60) == Approx(rest[i] / 7).margin(1e-8));
}

TEST_CASE("P18: the hinged rod has stiffness k l^2 cos^2(eta/2) at its equilibrium angle") {
  const auto study = study_of(kFolder + "hinged_rod.json");
  check_poles(poles(linear(study)), {{-0.5, -std::sqrt(0.5)}, {-0.5, std::sqrt(0.5)}}, 1e-12);
  CHECK(at(run(study), "theta", 5) == Approx(std::acos(-1.0) / 3).epsilon(1e-12));
}

TEST_CASE("P22: an integrator by an operational amplifier has y/u = -G/(1 + s C R (1 + G))") {
  const auto study = study_of(kFolder + "op_amp.json");
  const auto lin = linear(study, {}, {"u"});
  const double pole = -1.0 / (0.5 * 2 * 101);
  check_poles(poles(lin), {pole}, 1e-12);
  CHECK(lin.d[0] == Approx(0).margin(1e-12));
  CHECK(lin.c[0] * lin.b[0] == Approx(100 * pole).epsilon(1e-12));
  check_form(run(study), "y", 10, [&](double t) { return -100 * (1 - std::exp(pole * t)); });
}

TEST_CASE("P23: the mass, spring and damper of Gawthrop and Bevan's figure 7 have their matrices") {
  const auto lin = linear(study_of(kFolder + "rci.json"), {}, {"u1", "u2"});
  const double m1 = 2, c1 = 0.25, r1 = 3;
  const std::vector<double> a{0, -1 / m1, 1 / c1, -r1 / m1}, b{1, 0, 0, -1}, c{0, 1 / m1, 1 / c1, 0};
  REQUIRE(lin.states == 2);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(lin.a[i] == Approx(a[i]).margin(1e-14));
    CHECK(lin.b[i] == Approx(b[i]).margin(1e-14));
    CHECK(lin.c[i] == Approx(c[i]).margin(1e-14));
    CHECK(lin.d[i] == Approx(0).margin(1e-14));
  }
}

TEST_CASE("P24: the mass behind a piston depends on the fluid's momentum and adds A^2 m to its inertia") {
  const auto study = study_of(kFolder + "fluid_piston.json");
  CHECK(study.equations().dependent.size() == 1);
  const double A = 0.7, If = 1.5, Rf = 0.4, m = 2, k = 5, b = 0.3, P = 3, total = A * A * m + If;
  const auto lin = linear(study, {}, {"P"});
  REQUIRE(study.equations().states.front().name == "fluid.p");
  const std::vector<double> a{-(A * A * b + Rf) / total, -A * If * k / total, A / If, 0};
  for (std::size_t i = 0; i < 4; ++i) CHECK(lin.a[i] == Approx(a[i]).margin(1e-13));
  CHECK(lin.b[0] == Approx(If / total).epsilon(1e-13));
  const auto result = run(study);
  const auto p = column(result, "p"), p_m = column(result, "p_m");
  for (std::size_t i = 0; i < p.size(); ++i) CHECK(p_m[i] == Approx(A * m * p[i] / If).margin(1e-12));
  CHECK(test::largest_magnitude(p) > 0.1 * P);
}

TEST_CASE("P25: a transformer's modulus d is e1/e2, so that a resistor beyond it looks d^2 times as large") {
  const auto inertia = study_of(kFolder + "transformer_on_inertia.json");
  check_poles(poles(linear(inertia)), {-0.4 * 9 / 0.5}, 1e-12);
  const double rate = 0.4 * 9 / 0.5;
  check_form(run(inertia), "p", 1, [&](double t) { return 2 / rate * (1 - std::exp(-rate * t)); });
  const auto capacitor = study_of(kFolder + "transformer_on_capacitor.json");
  check_poles(poles(linear(capacitor)), {-1 / (0.5 * 0.4 * 9)}, 1e-12);
}

TEST_CASE("C1: the lab's quarter car has the computed poles and states over its bump") {
  const auto study = study_of(kFolder + "lab_quarter_car.json");
  check_poles(poles(linear(study)), {{-2.61797752809, -7.9488141786}, {-2.61797752809, 7.9488141786}}, 1e-10);
  const auto result = run(study);
  check_values(result, "p",
               {{0.75, 72.9844130839},
                {1, 59.5893374686},
                {1.25, -100.460546121},
                {1.5, -64.1325542878},
                {2, 1.84732430026},
                {3, -1.59108509631}},
               1e-6);
  check_values(result, "q",
               {{0.75, 0.0119588901119},
                {1, -0.00502772742073},
                {1.25, -0.0250340483796},
                {1.5, 0.0118827077919},
                {2, -0.00897954731095},
                {3, -0.000215961812031}},
               1e-9);
}

TEST_CASE("C2: the two-mass quarter car has the computed poles and states after a pothole") {
  const auto study = study_of(kFolder + "pothole.json");
  check_poles(poles(linear(study)),
              {{-9.717795852, -44.91745968},
               {-9.717795852, 44.91745968},
               {-1.591937701, -5.861985779},
               {-1.591937701, 5.861985779}},
              5e-8);
  const auto result = run(study);
  check_values(result, "p2", {{1.06, 54.06171281}, {1.12, 65.94419258}, {1.5, -22.29189786}, {3, 1.997649561}}, 1e-6);
  check_values(result, "q6",
               {{1.06, -0.0482332433}, {1.12, -0.02241737712}, {1.5, 0.0001641258475}, {3, -0.0008612256045}}, 1e-8);
  check_values(result, "p8", {{1.06, 91.95294073}, {1.12, -126.2039471}, {1.5, 2.190674516}, {3, 0.04074522262}}, 2e-6);
  check_values(result, "q11",
               {{1.06, -0.02802032999}, {1.12, 0.04669434154}, {1.5, 0.0001876691938}, {3, -1.659607491e-05}}, 1e-8);
}

TEST_CASE("C4: the lab's motor has the computed poles, currents and speeds") {
  const auto study = study_of(kFolder + "lab_dc_motor.json");
  check_poles(poles(linear(study)), {-14.3588989435, -5.64110105646}, 1e-9);
  const auto result = run(study);
  check_values(result, "i", {{0.1, 0.0861806827547}, {0.5, 0.207273087226}, {10, 0.2222222222}}, 1e-9);
  check_values(result, "w", {{0.1, 0.040180558197}, {0.5, 0.167105830968}, {10, 0.185185185185}}, 1e-9);
}

TEST_CASE("C7: two dampers determine each other's velocities and ring as exp(-t/2)") {
  const auto study = study_of(kFolder + "two_dampers.json");
  check_poles(poles(linear(study)), {{-0.5, -0.5}, {-0.5, 0.5}}, 1e-13);
}

TEST_CASE("C8: an inductor behind a gyrator and a compliance follows the compliance") {
  const auto study = study_of(kFolder + "geared_motor.json");
  REQUIRE(study.equations().dependent.size() == 1);
  CHECK(study.equations().dependent.front().name == "coil.p");
  check_poles(poles(linear(study, "twelve")), {{-0.75, -0.661437827766}, {-0.75, 0.661437827766}}, 1e-11);
  const auto result = run(study, "twelve");
  CHECK(at(result, "q_k", 1) == Approx(-0.219334403298).margin(1e-9));
  CHECK(at(result, "p_J", 1) == Approx(0.263081902074).margin(1e-9));
  CHECK(at(result, "i_L", 1) == Approx(-0.219334403298).margin(1e-9));
}

TEST_CASE("C9: the geared motor with its published parameters has the computed poles") {
  check_poles(poles(linear(study_of(kFolder + "geared_motor.json"), "eight")),
              {{-0.05142857143, -0.2628105549}, {-0.05142857143, 0.2628105549}}, 5e-11);
}

TEST_CASE("C10: a nonlinear quarter car with lift-off and a two-slope spring crosses its bump as computed") {
  const auto result = run(study_of(kFolder + "bump_car.json"));
  // printed to 9 digits; the kinks of the laws are located, not smoothed
  check_values(result, "q2", {{0.25, 0.0391716}, {0.5, 0.0204730388}, {1, 0.026455148}, {2, 0.0325534697}}, 1e-7);
  check_values(result, "q9", {{0.25, 0.321755821}, {0.5, 0.200311648}, {1, 0.199773012}, {2, 0.265798121}}, 1e-7);
  check_values(result, "pus", {{0.25, 34.2780672}, {0.5, 8.81761024}, {1, -39.5564418}, {2, -2.19679663}}, 1e-5);
  check_values(result, "ps", {{0.25, 235.409815}, {0.5, 252.462293}, {1, -428.036564}, {2, -181.151001}}, 1e-4);
}

TEST_CASE("C13: an isentropic nozzle chokes, and a law without choking is wrong below the critical ratio") {
  const auto study = study_of(kFolder + "nozzle.json");
  const auto flow = [&](const std::vector<std::string>& set) { return at(run(study, "steady", set), "flow", 1); };
  CHECK(flow({}) == Approx(3.821455284e-4).epsilon(1e-9));
  CHECK(flow({"ratio=0.5282817877"}) == Approx(4.667117121e-4).epsilon(1e-9));
  CHECK(flow({"ratio=0.3"}) == Approx(4.667117121e-4).epsilon(1e-9));
  CHECK(flow({"ratio=0.3", "choking=0"}) == Approx(4.117067951e-4).epsilon(1e-9));
}

}  // namespace
