/// Random linear bond graphs: trees of junctions with rings through them, TF and GY between them, R, C, I, Se and Sf at
/// them, in any half-arrow direction. The same seed gives the same graph everywhere.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace bgsim::test {

struct RandomGraphOptions {
  std::size_t most_junctions = 6;
  std::size_t most_rings = 2;        ///< connections beyond a tree
  std::size_t most_at_junction = 3;  ///< one-ports at each junction
  double sources = 0.2;              ///< share of one-ports that are sources
  std::size_t most_bonds = 40;       ///< graphs are cut off there
  double two_ports = 0.4;            ///< share of connections that go through a TF or GY
  double mixed_fields = 0.0;         ///< share of one-ports in whose place a port of a mixed field stands
  bool simple_moduli = false;        ///< 1/2, 1, 2 and their negatives: round a ring they often cancel
};

struct RandomElement {
  std::string name, kind;  ///< "Se", "0", ...
  double value = 0.0;      ///< effort, flow, resistance, ..., modulus; none for junctions and detectors
};

struct RandomGraph {
  std::vector<RandomElement> elements;
  std::vector<std::pair<std::string, std::string>> bonds;  ///< from, to as written

  /// Model format 1. Parameters "u_<source>" give the sources' values, all stores are outputs (e, f and q or p), fields
  /// port by port.
  [[nodiscard]] std::string json() const;
};

RandomGraph random_graph(std::uint64_t seed, const RandomGraphOptions& options = {});

/// The same graph with elements and bonds in another order.
RandomGraph shuffled(const RandomGraph& graph, std::uint64_t seed);

}  // namespace bgsim::test
