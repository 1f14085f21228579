/// Random bond graphs with nonlinear laws, and an oracle for them: all efforts, flows and stored quantities as one
/// implicit system, solved by Radau's collocation of order 5 with Newton's iteration. It reads the graph and not the
/// engine's model of it, and has laws and slopes of its own.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "support/random_graph.hpp"

namespace bgsim::test {

/// A strictly increasing function of one variable.
struct Curve {
  enum class Shape {
    linear,
    cubic,
    hyperbolic_sine,
    saturating,
    arc,
    root,
    diode,
    inverse_sine,
    stiffening
  } shape = Shape::linear;
  double scale = 1.0;

  [[nodiscard]] double value(double x) const;
  [[nodiscard]] double slope(double x) const;
  /// In the language of models.
  [[nodiscard]] std::string text(const std::string& x) const;
};

struct NonlinearGraphOptions {
  RandomGraphOptions graph;
  double nonlinear = 0.6;  ///< share of R, C and I with a law
  double modulated = 0.4;  ///< share of TF and GY whose modulus follows a store or the time
  double fields = 0.3;     ///< share of pairs of C, and of I, that become a field
  bool diodes = true;
};

/// Another way to write the same model.
struct Writing {
  std::uint64_t order = 0;  ///< elements, bonds and keys in another order; 0: as they are
  bool renamed = false;     ///< other names of elements
  bool reversed = false;    ///< half-arrows of one-ports at 0-junctions the other way, and of sources at 1-junctions
  double effort = 1.0, flow = 1.0;  ///< all efforts and flows times these: other units
};

/// A random graph whose one-ports have laws.
struct NonlinearGraph {
  struct Modulus {
    double mean = 1.0, swing = 0.0;
    std::string store;  ///< whose q or p it follows, by sine; empty: the time
  };
  struct Source {
    double mean = 0.0, swing = 0.0, frequency = 1.0, jump = 0.0;
  };
  /// Energy (q_a^2 + q_b^2)/(2 scale) + coupling q_a q_b/scale + (q_a + q_b)^4 stiffening.
  struct Field {
    std::string name, one, two;  ///< the elements that are its ports "a" and "b"
    bool displacements = true;
    double scale = 1.0, coupling = 0.0, stiffening = 0.0;
  };
  RandomGraph graph;
  std::map<std::string, Curve> curves;       ///< of R, C, I
  std::map<std::string, bool> gives_effort;  ///< of R: e = curve(f), otherwise f = curve(e)
  std::map<std::string, Modulus> moduli;     ///< of TF, GY
  std::map<std::string, Source> sources;     ///< of Se, Sf
  std::map<std::string, double> initial;     ///< of C, I
  std::vector<Field> fields;
  double stop = 4.0, jump_time = 2.0;
  std::size_t intervals = 20;

  /// Model format 1; outputs: "NAME_q" or "NAME_p", "NAME_e" and "NAME_f" of all one-ports but sources.
  [[nodiscard]] std::string json(const Writing& writing = {}) const;
};

NonlinearGraph random_nonlinear_graph(std::uint64_t seed, const NonlinearGraphOptions& options = {});

/// What the oracle says: each output at the ends of all intervals but the first.
struct OracleTrace {
  std::map<std::string, std::vector<double>> columns;
  double uncertainty = 0.0;  ///< largest change by the last halving of steps, relative to the range of each output
};

/// @param start  of each store, consistent with what depends on each other.
/// @return none if the steps that are tried, the finest of a hundredth of an interval, do not agree to @p agreement.
std::optional<OracleTrace> solve(const NonlinearGraph& graph, const std::map<std::string, double>& start,
                                 double agreement);

}  // namespace bgsim::test
