/// Transfer functions of small models in symbols, and the causal paths and loops that they are made of (Mason).
#pragma once

#include <complex>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bgsim/linear.hpp"

namespace bgsim {

/// A coefficient over parameters: "R1*C1 + R2*C2".
struct SymbolicNumber {
  std::string text;
  double value = 0.0;  ///< at the point
};

/// By power of s from 0 on.
using SymbolicPolynomial = std::vector<SymbolicNumber>;

/// numerator/denominator, without common powers and without the sums that had stood in denominators; other common
/// factors may remain. Where laws are nonlinear, coefficients contain states: as values at the point.
struct TransferFunction {
  std::string input, output;
  SymbolicPolynomial numerator, denominator;
  std::vector<std::pair<std::string, double>> values;  ///< of what is no parameter in the coefficients, at the point
  std::vector<std::string> hidden;                     ///< states outside of the path from input to output
  double mismatch = 0.0;  ///< from the response of the matrices, as a part of the terms: rounding
  std::vector<std::string> notes;
};

/// The first output of @p point by @p input, from the determinants of the system with its loops not eliminated, exact
/// in rational numbers. Conditions and branches are those of the point.
/// @throws ModelError as linear_system(); BG410 no dependence; BG409 more states or terms than can be written out.
TransferFunction transfer_function(const std::shared_ptr<const Model>& model, const RunInputs& point,
                                   const std::string& input);

/// A path from the input to the output, or a loop, along the equations of bonds: through each variable once.
struct CausalPath {
  std::string gain;                            ///< "-R/(L*s)"
  std::vector<std::pair<int, double>> values;  ///< of the gain at the point, by power of s
  std::vector<std::string> elements;           ///< whose laws it goes through, in order; without junctions
  std::vector<std::uint32_t> nodes;            ///< variables; paths that share none do not touch
  [[nodiscard]] std::complex<double> at(std::complex<double> s) const;
};

/// Mason: G = sum of P_k D_k / D, with D = 1 - sum of loops + sum of products of two that do not touch - ...
struct CausalPaths {
  std::vector<CausalPath> paths, loops;
  bool all = true;  ///< false: there are more, and those that were found first are given
  std::vector<std::pair<std::string, double>> values;  ///< of what is no parameter in the gains, at the point
};

/// At most @p most of each kind.
/// @throws ModelError as linear_system().
CausalPaths causal_paths(const std::shared_ptr<const Model>& model, const RunInputs& point, const std::string& input,
                         std::size_t most = 200);

}  // namespace bgsim
