/// Reference solutions of the bellow and the actuator. The equations are written by hand from the paper (Bhandari,
/// Pathak, Yang: Bond Graph Modelling and Simulation of Pneumatic Soft Actuator, Eqs. 1-6, Table 1) and integrated by
/// two methods that share no code. Prints what the methods disagree by:
///   seed_models FOLDER [NAME]   writes FOLDER/NAME.SCENE.csv, of all models or those whose name begins with NAME
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

constexpr Real kPi = 3.141592653589793238462643383279502884L;

/// Table 1 of the paper and what its text leaves open. Decimal numbers as a model file gives them: rounded to double.
struct Packet {
  Real m = 0.015, damping = 0.4, k = 350, cd = 0.8, d = 0.008, area = 0.0096, amplitude = 0.3, rho = 1.225,
       gas = 8.31451, temperature = 300, kp = 40, kd = 10, omega = 1;
  Real delta = 1e-3, unit = 1e5, supply = 0, phase = 0, x0 = 0.45;
  Real orifice = Real(0.8) * Real(0.008);

  [[nodiscard]] Real x_ref(Real t) const { return amplitude * std::sin(omega * t + phase); }
  [[nodiscard]] Real p1(Real t, Real x, Real v) const {
    const Real slope = amplitude * omega * std::cos(omega * t + phase);
    return supply + unit * (kp * (x_ref(t) - x) + kd * (slope - v));
  }
  /// Volume flow through the orifice.
  [[nodiscard]] Real flow(Real drop) const {
    return orifice * drop / std::sqrt(std::sqrt(drop * drop + delta * delta));
  }
  [[nodiscard]] Real c2() const { return area * amplitude / (rho * gas * temperature); }
};

/// The paper's numbers with a sound orifice law and the specific gas constant of air.
Packet physical() {
  Packet packet;
  packet.gas = 287;
  packet.orifice = packet.cd * kPi * packet.d * packet.d / 4 * std::sqrt(2 / packet.rho);
  return packet;
}

/// One packet with a mass: q air taken in, x extension, v velocity of the wall.
void bellow(const Target& target, const std::string& scene, const Packet& b, const Grid& grid) {
  const Real c2 = b.c2();
  const Rates<3> rates = [=](const Vector<3>& y, Vector<3>& dydt, Real t) {
    const Real p2 = (y[0] - b.area * y[1]) / c2;
    dydt[0] = b.flow(b.p1(t, y[1], y[2]) - p2);
    dydt[1] = y[2];
    dydt[2] = (b.area * p2 - b.k * y[1] - b.damping * y[2]) / b.m;
  };
  const Vector<3> scale{1e-3L, 1e-2L, 1e-2L};
  solve<3>(target, "bellow." + scene, {"t", "x", "x_ref", "P1", "P2", "Q"}, rates, {}, scale, grid,
           [=](Real t, const Vector<3>& y) {
             const Real p1 = b.p1(t, y[1], y[2]), p2 = (y[0] - b.area * y[1]) / c2;
             return std::vector<Real>{t, y[1], b.x_ref(t), p1, p2, b.flow(p1 - p2)};
           });
}

/// Eqs. 3 and 4 as they are printed: the air side does not feel the wall's motion. p pressure P2.
void bellow_eq3(const Target& target, const std::string& scene, const Packet& b, const Grid& grid) {
  const Real capacity = b.area * b.area / b.k + b.c2();
  const Rates<3> rates = [=](const Vector<3>& y, Vector<3>& dydt, Real t) {
    dydt[0] = b.flow(b.p1(t, y[1], y[2]) - y[0]) / capacity;
    dydt[1] = y[2];
    dydt[2] = (b.area * y[0] - b.k * y[1] - b.damping * y[2]) / b.m;
  };
  const Vector<3> scale{1e3L, 1e-2L, 1e-2L};
  solve<3>(target, "bellow_paper_eq3." + scene, {"t", "x", "x_ref", "P1", "P2", "Q"}, rates, {}, scale, grid,
           [=](Real t, const Vector<3>& y) {
             const Real p1 = b.p1(t, y[1], y[2]);
             return std::vector<Real>{t, y[1], b.x_ref(t), p1, y[0], b.flow(p1 - y[0])};
           });
}

/// Compliance of the air that grows with the packet, C2(x) = A (x0 + x)/(rho R T), with the force that belongs to it.
void bellow_compliance(const Target& target, const std::string& scene, const Packet& b, const Grid& grid,
                       Real tolerance = 1e-15L) {
  const Real slope = b.area / (b.rho * b.gas * b.temperature);
  const auto pressure = [=](const Vector<3>& y) { return (y[0] - b.area * y[1]) / (slope * (b.x0 + y[1])); };
  const Rates<3> rates = [=](const Vector<3>& y, Vector<3>& dydt, Real t) {
    const Real p2 = pressure(y);
    dydt[0] = b.flow(b.p1(t, y[1], y[2]) - p2);
    dydt[1] = y[2];
    // dE/dx = k x - A P2 - P2^2 C2'(x)/2
    dydt[2] = (b.area * p2 + p2 * p2 * slope / 2 - b.k * y[1] - b.damping * y[2]) / b.m;
  };
  const Vector<3> scale{1e-3L, 1e-2L, 1e-2L};
  solve<3>(
      target, "bellow_compliance." + scene, {"t", "x", "x_ref", "P1", "P2", "Q"}, rates, {}, scale, grid,
      [=](Real t, const Vector<3>& y) {
        const Real p1 = b.p1(t, y[1], y[2]), p2 = pressure(y);
        return std::vector<Real>{t, y[1], b.x_ref(t), p1, p2, b.flow(p1 - p2)};
      },
      {}, tolerance);
}

/// Two packets that carry a body of mass M and moment of inertia J on arms l = 1/mu. `share` is the body's part of the
/// moment of inertia, and so of the torque, where the packets' own masses count as well.
void actuator(const Target& target, const std::string& name, const Packet& left, Real mass, Real inertia, Real share,
              Real right_phase, const Grid& grid, Real tolerance = 1e-15L) {
  Packet right = left;
  right.phase = right_phase;
  const Real l = 1 / Real(2.5);
  struct Sides {
    Real p1_left, p1_right, p2_left, p2_right, force_left, force_right;
  };
  // States: air taken in and extension left, the same right, heave velocity, pitch rate.
  const auto sides = [=](Real t, const Vector<6>& y) {
    const auto force = [](const Packet& b, Real p2, Real x, Real v) { return b.area * p2 - b.k * x - b.damping * v; };
    const Real v_left = y[4] + l * y[5], v_right = y[4] - l * y[5];
    const Real p2_left = (y[0] - left.area * y[1]) / left.c2(), p2_right = (y[2] - right.area * y[3]) / right.c2();
    return Sides{left.p1(t, y[1], v_left),           right.p1(t, y[3], v_right),           p2_left, p2_right,
                 force(left, p2_left, y[1], v_left), force(right, p2_right, y[3], v_right)};
  };
  const Rates<6> rates = [=](const Vector<6>& y, Vector<6>& dydt, Real t) {
    const Sides s = sides(t, y);
    dydt[0] = left.flow(s.p1_left - s.p2_left);
    dydt[1] = y[4] + l * y[5];
    dydt[2] = right.flow(s.p1_right - s.p2_right);
    dydt[3] = y[4] - l * y[5];
    dydt[4] = (s.force_left + s.force_right) / mass;
    dydt[5] = l * (s.force_left - s.force_right) / inertia;
  };
  const Vector<6> scale{1e-3L, 1e-2L, 1e-3L, 1e-2L, 1e-2L, 1e-2L};
  solve<6>(
      target, name,
      {"t", "x_L", "x_Lref", "x_R", "x_Rref", "theta", "z", "torque", "torque_air", "P1_L", "P1_R", "Q_L", "Q_R"},
      rates, {}, scale, grid,
      [=](Real t, const Vector<6>& y) {
        const Sides s = sides(t, y);
        return std::vector<Real>{t,
                                 y[1],
                                 left.x_ref(t),
                                 y[3],
                                 right.x_ref(t),
                                 (y[1] - y[3]) / (2 * l),
                                 (y[1] + y[3]) / 2,
                                 share * l * (s.force_left - s.force_right),
                                 l * (left.area * s.p2_left - right.area * s.p2_right),
                                 s.p1_left,
                                 s.p1_right,
                                 left.flow(s.p1_left - s.p2_left),
                                 right.flow(s.p1_right - s.p2_right)};
      },
      // Heave vanishes in bending, rotation and torques in extension: their magnitudes in the other scene.
      {0, 0, 0, 0, 0, 0.75L, 0.3L, 3.6e-3L, 80, 0, 0, 0, 0}, tolerance);
}

}  // namespace

int main(int argc, char** argv) {
  const Target target{argc > 1 ? argv[1] : "models/reference", argc > 2 ? argv[2] : ""};
  try {
    const Real two_periods = 12.566370614359172;  // as in the scenes
    const Grid whole{0, two_periods, 201};
    // The start from rest rings until 0.1474 s (other models: somewhat longer), with periods from 2.1 ms down to
    // 0.17 ms. It has tables of its own, whose records resolve it; other tables begin when it is over, or hold it at
    // some of their times.
    const Grid start{0, 0.15L, 751}, longer_start{0, 0.2L, 1001}, tracking{0.16L, two_periods, 201};
    Packet step;
    step.unit = 0;
    step.supply = 10937.5;
    Packet literal;
    literal.unit = 1;
    bellow(target, "tracking", {}, tracking);
    bellow(target, "start", {}, start);
    bellow(target, "step", step, {0, 0.5L, 201});
    bellow(target, "literal", literal, whole);
    bellow(target, "physical", physical(), whole);
    bellow_eq3(target, "tracking", {}, whole);
    bellow_eq3(target, "start", {}, longer_start);
    bellow_eq3(target, "step", step, {0, 0.5L, 201});
    bellow_compliance(target, "tracking", physical(), whole);
    bellow_compliance(target, "start", physical(), {0, 0.3L, 1501}, 2e-16L);
    const Real m = 0.015, l = 1 / Real(2.5);
    actuator(target, "actuator.bending", {}, 2 * m, 2 * m * l * l, 1, kPi, tracking);
    actuator(target, "actuator.start", {}, 2 * m, 2 * m * l * l, 1, kPi, start);
    actuator(target, "actuator.extension", {}, 2 * m, 2 * m * l * l, 1, 0, tracking);
    actuator(target, "actuator.physical", physical(), 2 * m, 2 * m * l * l, 1, kPi, whole, 2e-16L);
    const Real body = 0.02, inertia = 0.002, total = inertia + 2 * m * l * l;
    actuator(target, "actuator_masses.bending", {}, body + 2 * m, total, inertia / total, kPi, whole);
    actuator(target, "actuator_masses.start", {}, body + 2 * m, total, inertia / total, kPi, longer_start);
    actuator(target, "actuator_masses.quarter", {}, body + 2 * m, total, inertia / total, kPi / 2, whole);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
