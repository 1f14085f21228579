/// A drawing with everything in its place, before it is written in any language.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drawing_plan.hpp"

namespace bgsim {

enum class Anchor : std::uint8_t { start, middle, end };

struct PlacedText {
  Point at;  ///< on the base line, at the anchor
  Anchor anchor = Anchor::middle;
  double size = kNameSize;
  std::string text, subscript;
  Box box;
};

struct DrawnBond {
  Curve line;
  Point barb;  ///< the half-arrow's barb goes from the line's end to here
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

DrawnScene place_all(const Model& model, const DrawnCausality& causality, const Layout& layout,
                     const DrawingOptions& options);

}  // namespace bgsim
