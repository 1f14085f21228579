#include "base/strong_parts.hpp"

#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/graph/strong_components.hpp>
#include <utility>

namespace bgsim {

StrongParts strong_parts(const std::vector<std::vector<std::uint32_t>>& depends_on) {
  using Graph = boost::compressed_sparse_row_graph<boost::directedS>;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> arcs;
  for (std::uint32_t i = 0; i < depends_on.size(); ++i)
    for (const std::uint32_t j : depends_on[i]) arcs.emplace_back(i, j);
  const Graph graph(boost::edges_are_sorted, arcs.begin(), arcs.end(), depends_on.size());
  StrongParts parts;
  parts.part_of.resize(depends_on.size());
  // Tarjan's numbering puts what others depend on first.
  parts.count = boost::strong_components(
      graph, boost::make_iterator_property_map(parts.part_of.begin(), get(boost::vertex_index, graph)));
  return parts;
}

}  // namespace bgsim
