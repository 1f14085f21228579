/// A drawing with everything in its place, before it is written in any language.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "draw/labels.hpp"
#include "draw/plan.hpp"

namespace bgsim {

struct DrawnBond {
  Curve line;
  Point tip;                 ///< of the arrow: the line's end, or its beginning if a detector is there
  std::vector<Point> barbs;  ///< from the tip to here: one of a half-arrow, two at a detector, which takes no power
  std::optional<std::pair<Point, Point>> stroke;
  std::vector<PlacedText> names;  ///< its name, or its effort and flow
  std::vector<PlacedText> ports;  ///< of fields at its ends
};

struct DrawnElement {
  Point at;
  Letters letters;
  PlacedText name;
};

struct DrawnSignal {
  ReadSignal signal;
  Curve line;
  std::optional<PlacedText> label;
};

struct DrawnFrame {
  std::string scope;  ///< "left."
  Box box;
  PlacedText name;
};

struct DrawnScene {
  std::vector<DrawnBond> bonds;        ///< by BondId
  std::vector<DrawnElement> elements;  ///< by ElementId
  std::vector<DrawnSignal> signals;
  std::vector<DrawnFrame> frames;  ///< outer ones first
  Box bounds;
};

struct PlacedBonds {
  std::vector<DrawnBond> bonds;  ///< by BondId, without texts
  std::vector<Point> towards;    ///< by ElementId: sum of the directions of its bonds
  double trouble = 0.0;          ///< px of bonds that go through letters, by weight
};
PlacedBonds place_bonds(const Model& model, const DrawnCausality& causality, const Layout& layout, Taken& taken);

/// Where texts may stand. @p towards: the sum of the directions of the element's bonds.
std::vector<Candidate> name_places(const Element& element, Point at, Point towards);
/// A field's port, near the end of the bond there.
std::vector<Candidate> port_places(const Curve& line, bool head, const std::string& name);
/// @p preferred: 1 on the side of the flow, -1 on the other.
std::vector<Candidate> beside_line(const Curve& line, double preferred, bool either_side, const std::string& text,
                                   const std::string& subscript = {});

/// Everything in its place. Where names do not find room, the layout is stretched, up to twice in each direction.
DrawnScene place_all(const Model& model, const DrawnCausality& causality, const Layout& layout,
                     const DrawingOptions& options);

}  // namespace bgsim
