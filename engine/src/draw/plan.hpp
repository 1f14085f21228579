/// Neighbours in a drawing, before anything has a position: elements that hang on junctions, signals.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "draw/shapes.hpp"

namespace bgsim {

/// Distance of an element from the junction it hangs on, centre to centre, in px.
inline constexpr double kDrop = 68.0;

enum class Side : std::uint8_t { none, above, below };

/// Place of an element: by itself, or above or below a junction.
struct Standing {
  ElementId host;  ///< the element itself, or the junction it hangs on
  Side side = Side::none;
};

/// Of the R, C and I at a junction of three bonds or more, one hangs above and one below: I rather above, C rather
/// below. By ElementId.
std::vector<Standing> standings(const Model& model);

/// On which side of its neighbour a one-port that does not hang is; its name is beyond it. Where its half-arrow
/// comes from or goes to, but at the ends of a chain of junctions: there it goes on with the chain.
enum class Hand : std::uint8_t { none, left, right };
/// By ElementId; none for all but one-ports with one bond.
std::vector<Hand> hands(const Model& model);

/// Clear space that an element and what hangs on it take around its centre, in px.
struct Extent {
  double left = 0.0, right = 0.0, top = 0.0, bottom = 0.0;
};
/// By ElementId; of hosts only.
std::vector<Extent> extents(const Model& model, const std::vector<Standing>& standings, const std::vector<Hand>& hands);

/// What Graphviz is asked to put one after the other: hosts, from left to right.
struct Rank {
  ElementId left, right;
  int weight = 1;  ///< how much it should be straight
};

/// A layout's order and the hands that go with it.
struct Flow {
  std::vector<Rank> ranks;  ///< one for each bond between different hosts
  std::vector<Hand> hands;  ///< by ElementId
};
/// Along the power; but what would be high and narrow then (a tree, whose leaves stand in one column) goes from its
/// middle to both sides.
Flow flow_of(const Model& model, const std::vector<Standing>& standings);

/// Turns a layout upside down where that brings what is declared first to the top, and moves hosts that may stand
/// anywhere between their neighbours to the middle: what is symmetrical looks so. @p at by ElementId; what hangs goes
/// along.
void centre(const Model& model, const std::vector<Standing>& standings, const std::vector<Extent>& extents,
            std::vector<Layout::Point>& at);

/// An element's law, energy or coefficient reads something of another element or of a bond, itself or through signals.
struct ReadSignal {
  ElementId from;  ///< or
  BondId from_bond;
  ElementId to;
  std::string label;  ///< the variable read ("wall.q"), or the named signal through which
  std::string about;  ///< in words
};
/// At most one for each pair, in model order.
std::vector<ReadSignal> read_signals(const Model& model);

}  // namespace bgsim
