/// Reference solutions of the models with a mixed field, whose equations are written by hand and are not those of the
/// models: the double pendulum in Cartesian coordinates with its rods as constraints, the transducer by Newton's law.
/// Prints what two methods disagree by:
///   mixed_fields FOLDER [NAME]   writes FOLDER/NAME.SCENE.csv, of all models or those whose name begins with NAME
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>

#include "solve.hpp"

namespace {

using reference::Grid;
using reference::Rates;
using reference::Real;
using reference::solve;
using reference::Target;
using reference::Vector;

/// A decimal number as a model file gives it: rounded to double.
Real given(double value) { return value; }

/// Two masses on two rods: M v' = weight + G^T lambda, where lambda keeps G v = 0 for the constraints
/// (|r1|^2 = l1^2, |r2 - r1|^2 = l2^2). States x1, y1, x2, y2 and their rates; y is upwards.
void double_pendulum(const Target& target) {
  const Real m1 = 2, m2 = 1, l1 = 1, l2 = given(0.7), g = given(9.81);
  const Rates<8> rates = [=](const Vector<8>& y, Vector<8>& dydt, Real) {
    const Real x1 = y[0], y1 = y[1], dx = y[2] - y[0], dy = y[3] - y[1];
    const Real vx1 = y[4], vy1 = y[5], dvx = y[6] - y[4], dvy = y[7] - y[5];
    // Twice differentiated: r1.a1 = -v1^2, d.(a2 - a1) = -dv^2, with a1 = -g + (p r1 - s d)/m1, a2 = -g + s d/m2.
    const Real across = x1 * dx + y1 * dy, r2 = x1 * x1 + y1 * y1, d2 = dx * dx + dy * dy;
    const Real a11 = r2 / m1, a12 = -across / m1, a22 = d2 * (1 / m1 + 1 / m2);
    const Real b1 = g * y1 - vx1 * vx1 - vy1 * vy1, b2 = -dvx * dvx - dvy * dvy;
    const Real det = a11 * a22 - a12 * a12;
    const Real p = (a22 * b1 - a12 * b2) / det, s = (a11 * b2 - a12 * b1) / det;
    for (std::size_t i = 0; i < 4; ++i) dydt[i] = y[4 + i];
    dydt[4] = (p * x1 - s * dx) / m1;
    dydt[5] = (p * y1 - s * dy) / m1 - g;
    dydt[6] = s * dx / m2;
    dydt[7] = s * dy / m2 - g;
  };
  const Real a = 1, b = given(0.5), wb = 1;
  const Real x1 = l1 * std::sin(a), y1 = -l1 * std::cos(a);
  const Vector<8> start{x1, y1, x1 + l2 * std::sin(b), y1 - l2 * std::cos(b),
                        0,  0,  l2 * wb * std::cos(b), l2 * wb * std::sin(b)};
  const Vector<8> scale{1, 1, 1, 1, 1, 1, 1, 1};
  solve<8>(target, "double_pendulum.release", {"t", "a", "b", "omega_a", "omega_b"}, rates, start, scale,
           Grid{0, 5, 201}, [=](Real t, const Vector<8>& y) {
             const Real dx = y[2] - y[0], dy = y[3] - y[1];
             return std::vector<Real>{t, std::atan2(y[0], -y[1]), std::atan2(dx, -dy),
                                      (y[5] * y[0] - y[4] * y[1]) / (l1 * l1),
                                      ((y[7] - y[5]) * dx - (y[6] - y[4]) * dy) / (l2 * l2)};
           });
}

/// Capacitance eps A/(d - x), inductance c/(d + x). States: charge, current, x, x'.
void transducer(const Target& target, const std::string& scene, Real part, Real current) {
  const Real d = given(1e-5), area = given(1e-6), eps = given(8.854e-12), c = given(6e-9), k = 10, m = given(1e-8),
             r = given(1e-3), wire = given(1e6), coil = 50, tau = given(1e-3);
  const Real pull = std::sqrt(8 * k * d * d * d / (27 * eps * area));
  const Rates<4> rates = [=](const Vector<4>& y, Vector<4>& dydt, Real t) {
    const Real q = y[0], i = y[1], x = y[2], v = y[3], rise = -std::expm1(-t / tau);
    const Real inductance = c / (d + x);
    dydt[0] = (part * pull * rise - q * (d - x) / (eps * area)) / wire;
    // (L i)' = u - R i, and L' = -c v/(d + x)^2
    dydt[1] = (coil * (current * rise - i) + i * v * inductance / (d + x)) / inductance;
    dydt[2] = v;
    // The electrode pulls by Q^2/(2 eps A), the coil by i^2 c/(2 (d + x)^2).
    dydt[3] = (q * q / (2 * eps * area) - i * i * inductance / (2 * (d + x)) - k * x - r * v) / m;
  };
  const Vector<4> scale{1e-12L, 1e-4L, 1e-7L, 1e-4L};
  solve<4>(target, "transducer." + scene, {"t", "x", "u", "i"}, rates, {}, scale, Grid{0, given(0.02), 201},
           [=](Real t, const Vector<4>& y) {
             return std::vector<Real>{t, y[2], y[0] * (d - y[2]) / (eps * area), y[1]};
           },
           {0, 0, 0, 1e-4L});  // without current the last column is 0
}

}  // namespace

int main(int argc, char** argv) {
  const Target target{argc > 1 ? argv[1] : "models/reference", argc > 2 ? argv[2] : ""};
  try {
    double_pendulum(target);
    transducer(target, "hold", given(0.99), 0);
    transducer(target, "balance", given(1.02), given(4e-4));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
