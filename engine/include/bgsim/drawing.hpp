/// The bond graph as a picture: half-arrows, strokes, signals, frames around submodels. Where things stand is for a
/// program of Graphviz to say; what is drawn there is exact at any angle. Nothing here runs a program.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bgsim/causality.hpp"

namespace bgsim {

/// What a drawing shows of the causality, as far as it could be assigned: a model with errors is drawn as well.
struct DrawnCausality {
  std::vector<std::optional<BondEnd>> strokes;  ///< by BondId; none where nothing is assigned
  std::vector<std::string> reasons;             ///< by BondId: reason for the stroke, in words; "" without one
  std::vector<BondId> dependent;                ///< bonds at ports in derivative causality
  std::vector<BondId> free;                     ///< bonds whose stroke was a free choice: loops run through them
  std::vector<ElementId> faulty;                ///< elements at which a rule is broken, or that lack a bond
  std::vector<Diagnostic> problems;             ///< why causality is not complete; empty if it is
};

/// Causality as it is drawn. Throws for no fault of the model.
DrawnCausality drawn_causality(const Model& model);

struct DrawingOptions {
  bool bond_names = true;
  bool effort_flow = false;       ///< effort and flow at each bond, in place of its name
  std::string id_prefix = "bg-";  ///< of the ids: several drawings may stand on one page
};

/// The graph as Graphviz's language takes it, to be laid out from left to right by `dot` (or by force, by `sfdp` or
/// `neato`). One-ports that hang on a junction are part of its node: they stand above and below it, as textbooks have
/// them. Not meant to be looked at: see drawing_dot().
std::string layout_request(const Model& model);

/// Positions of elements, in px (1/96 in), y downwards.
struct Layout {
  struct Point {
    double x = 0.0, y = 0.0;
  };
  std::vector<Point> elements;  ///< by ElementId
};

/// Reads what Graphviz answered on layout_request() with -Tplain. A layout that is much wider than high is folded into
/// rows, alternately from left to right and back.
/// @throws std::invalid_argument  a text that is no such answer.
Layout read_layout(const Model& model, const std::string& plain);

/// The drawing as SVG, one root element, usable as a file and inside a page. Bonds are <g class="bond ..."
/// data-bond="NAME">, elements <g class="element ..." data-element="NAME">, frames <g class="frame"
/// data-submodel="NAME">, each with a <title>; colours are in one <style> under the class bg-drawing and follow
/// prefers-color-scheme. The same arguments give the same bytes.
std::string drawing_svg(const Model& model, const DrawnCausality& causality, const Layout& layout,
                        const DrawingOptions& options = {});

/// The drawing in Graphviz's language, to be worked on with Graphviz: half-arrows and strokes as arrow shapes,
/// submodels as clusters.
std::string drawing_dot(const Model& model, const DrawnCausality& causality);

}  // namespace bgsim
