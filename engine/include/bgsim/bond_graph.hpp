/// BondGraph: typed elements, ports and half-arrows. No text, no strokes.
#pragma once

#include <vector>

#include "bgsim/model.hpp"

namespace bgsim {

/// One port, bonded exactly once.
struct Port {
  ElementId element;
  std::uint32_t number = 0;  ///< among the element's ports; for junctions the position among its bonds
  BondId bond;
  bool head = false;  ///< true if the half-arrow points at this port
};

/// A bond: power e*f is positive from tail to head.
struct Bond {
  PortId tail, head;
};

/// Ports of element i are the ids [first_port[i], first_port[i+1]).
struct BondGraph {
  std::vector<ElementKind> kinds;         ///< by ElementId
  std::vector<std::uint32_t> first_port;  ///< by ElementId, plus one at the end
  std::vector<Port> ports;                ///< by PortId
  std::vector<Bond> bonds;                ///< by BondId

  [[nodiscard]] std::size_t port_count(ElementId element) const {
    return first_port[element.index() + 1] - first_port[element.index()];
  }
  [[nodiscard]] PortId port(ElementId element, std::size_t number) const {
    return PortId(first_port[element.index()] + number);
  }
  [[nodiscard]] const Port& operator[](PortId id) const { return ports[id.index()]; }
  [[nodiscard]] const Bond& operator[](BondId id) const { return bonds[id.index()]; }
  /// The port at the other end of the bond at @p id.
  [[nodiscard]] PortId opposite(PortId id) const {
    const Bond& bond = bonds[ports[id.index()].bond.index()];
    return bond.tail == id ? bond.head : bond.tail;
  }
};

/// Places the elements: gives every end of every bond its port.
/// @throws ModelError BG201 port bonded twice, BG202 port without a bond, BG203 two-port whose ports the half-arrows do
///         not tell apart, BG204 element without bonds, BG205 bond from an element to itself. A graph of several
///         unconnected parts is legal and is reported by describe.
/// @throws std::invalid_argument  a bond's end is no port of its element: read_model lets no such model pass.
/// @note Time O(B + E).
BondGraph build_bond_graph(const Model& model);

/// The connected parts of the graph, each with its elements in model order (Boost.Graph connected_components).
std::vector<std::vector<ElementId>> connected_parts(const BondGraph& graph);

}  // namespace bgsim
