/// Passivity: whether the stored energy of a model can only fall when its sources are at zero.
#pragma once

#include <string>
#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

enum class Proof {
  proved,
  refuted,    ///< a counterexample was found
  undecided,  ///< neither
};

/// What was found of one element.
struct PassivityFinding {
  std::string element;
  Proof proof = Proof::undecided;
  std::string reason;  ///< in words, without the numbers below
  /// An interval of the law's own variable: where e f < 0 (refuted), or the widest one that is not decided.
  std::string variable;  ///< "f", "e", "q", "p"; empty if there is none
  double from = 0.0, to = 0.0;
};

struct Passivity {
  std::vector<PassivityFinding> resistors;  ///< R and RR: e f >= 0
  std::vector<PassivityFinding> stores;     ///< energy bounded below, and a function of the state alone
  std::vector<PassivityFinding> others;     ///< diodes with a threshold, events
  std::vector<std::string> sources;         ///< given over time, or constant: zero in the unforced model
  std::vector<std::string> driven;          ///< sources that signals of the model's states drive: they may add energy
  /// All resistors, stores and others are proved, and nothing is driven: the stored energy of the unforced model falls
  /// or stays, and is a Lyapunov function where it has a minimum.
  [[nodiscard]] bool holds() const;
};

/// By interval arithmetic over all numbers that a double holds, with the parameters of @p inputs: what is proved holds
/// for each value that the law gives when it is evaluated. Junctions, TF and GY conserve power whatever their moduli.
/// What modulates a law may take any value that its expression can have, signals of states any at all.
/// @note At most some 1e5 evaluations of each law.
Passivity passivity(const Model& model, const RunInputs& inputs);

}  // namespace bgsim
