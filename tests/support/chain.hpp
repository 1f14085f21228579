/// Masses with springs, dry friction, diodes and contacts between them: as a model, and by time stepping.
#pragma once

#include <random>
#include <string>
#include <vector>

namespace bgsim::test {

/// Masses of a chain, tied to the ground and to each other.
struct Chain {
  enum class Kind { spring, friction, diode, contact };
  struct Link {
    Kind kind;
    int from, to;             ///< to: -1 is the ground
    double value;             ///< stiffness; limit; gap
    double second = 0.0;      ///< of a spring: by which its force grows with the cube; of a contact: restitution
    double ground_speed = 0;  ///< the ground's is that times sin(ground_frequency t)
    double ground_frequency = 1.0;

    [[nodiscard]] double ground(double t) const;
  };
  std::vector<double> masses, forces, amplitudes, frequencies;
  std::vector<Link> links;
  std::string direction = "sign(f)";  ///< of friction, as the model is to have it: -1 to 1

  [[nodiscard]] double force(std::size_t mass, double t) const;
  /// A model with the outputs v0, v1, ...: 31 rows of 3 s.
  [[nodiscard]] std::string text() const;
  /// The same rows by Moreau's time stepping: impulses within their sets, by Gauss-Seidel; Newton's law of impacts. Of
  /// first order in @p step, which divides the 0.1 s between rows.
  [[nodiscard]] std::vector<std::vector<double>> stepped(double step) const;
};

/// Of two to four masses.
/// @param contacts  among the links
Chain random_chain(std::mt19937& random, bool contacts);

}  // namespace bgsim::test
