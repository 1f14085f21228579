// The drawing in SVG.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "bgsim/xml.hpp"
#include "draw/scene.hpp"

namespace bgsim {

namespace {

// Colours of the light page, then of the dark one. Every rule begins with .bg-drawing: the style of an SVG inside a
// page is the whole page's.
constexpr const char* kStyle = R"(
.bg-drawing{color:#1b1f24;font-family:"Liberation Sans",Arial,Arimo,Helvetica,sans-serif}
.bg-drawing .paper{fill:#ffffff}
.bg-drawing path,.bg-drawing line{fill:none;stroke:currentColor;stroke-width:1.4;stroke-linecap:round}
.bg-drawing .stroke{stroke-width:2.3;stroke-linecap:butt}
.bg-drawing .hit{stroke:#000000;stroke-opacity:0;stroke-width:14}
.bg-drawing text{fill:currentColor}
.bg-drawing .letter{font-family:"Liberation Serif","Times New Roman",Times,serif}
.bg-drawing .halo{stroke:#ffffff;stroke-width:3;stroke-linejoin:round;paint-order:stroke}
.bg-drawing .name{fill:#3d4650}
.bg-drawing .bond-name,.bg-drawing .port{fill:#6a737d}
.bg-drawing .effort-flow,.bg-drawing .port,.bg-drawing .signal-name{font-style:italic}
.bg-drawing .frame rect{fill:#64748b;fill-opacity:0.06;stroke:#94a3b8;stroke-width:1}
.bg-drawing .frame text{fill:#52606d;font-weight:bold}
.bg-drawing .signal{color:#0f766e}
.bg-drawing .signal path{stroke-width:1}
.bg-drawing .mark{fill:none;stroke:none}
.bg-drawing .dependent{color:#c2410c}
.bg-drawing .element.dependent .mark{fill:#c2410c;fill-opacity:0.14}
.bg-drawing .free{color:#1d4ed8}
.bg-drawing .free .line{stroke-width:2.4}
.bg-drawing .faulty{color:#c81e1e}
.bg-drawing .element.faulty .mark{fill:#c81e1e;fill-opacity:0.14;stroke:#c81e1e;stroke-width:1.4}
@media (prefers-color-scheme:dark){
.bg-drawing{color:#e6e8eb}
.bg-drawing .paper{fill:#16191d}
.bg-drawing .halo{stroke:#16191d}
.bg-drawing .name{fill:#c0c7cf}
.bg-drawing .bond-name,.bg-drawing .port{fill:#98a2ad}
.bg-drawing .frame rect{stroke:#5b6775}
.bg-drawing .frame text{fill:#a9b4c0}
.bg-drawing .signal{color:#4fd1c5}
.bg-drawing .dependent{color:#fb923c}
.bg-drawing .free{color:#7aa2ff}
.bg-drawing .faulty{color:#ff6b6b}
}
)";

/// A coordinate, to a hundredth of a pixel.
std::string px(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f", value);
  std::string out = text.data();
  out.erase(out.find_last_not_of('0') + 1);
  if (out.back() == '.') out.pop_back();
  return out == "-0" ? "0" : out;
}
std::string px(Point p) { return px(p.x) + " " + px(p.y); }

std::string path(const Curve& line) {
  if (line.straight()) return "M" + px(line.begin) + "L" + px(line.end);
  return "M" + px(line.begin) + "Q" + px(line.control) + " " + px(line.end);
}

/// @param d  in SVG's path language.
std::string path_element(const std::string& d) { return xml_empty("path", {{"d", d}}); }
std::string path_element(const char* css, const std::string& d) {
  return xml_empty("path", {{"class", css}, {"d", d}});
}

XmlAttributes operator+(XmlAttributes a, const XmlAttributes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

XmlAttributes at(Point p) { return {{"x", px(p.x)}, {"y", px(p.y)}}; }
XmlAttributes at(const Box& box) {
  return at(box.low) + XmlAttributes{{"width", px(box.width())}, {"height", px(box.height())}};
}

class SvgWriter {
 public:
  SvgWriter(const Model& model, const DrawnCausality& causality, const DrawingOptions& options, DrawnScene scene)
      : model_(model), causality_(causality), options_(options), scene_(std::move(scene)) {
    mark(bond_marks_, model.bonds.size(), causality.dependent, "dependent");
    mark(bond_marks_, model.bonds.size(), causality.free, "free");
    mark(element_marks_, model.elements.size(), causality.faulty, "faulty");
    for (const BondId bond : causality.dependent)
      for (const ElementId id : {model.bonds[bond.index()].from.element, model.bonds[bond.index()].to.element})
        if (is_store(model.elements[id.index()].kind) && element_marks_[id.index()].empty())
          element_marks_[id.index()] = " dependent";
  }

  std::string run() {
    const Box drawing = scene_.bounds;
    const std::string legend = write_legend();
    Box& all = scene_.bounds;
    if (legend_height_ > 0.0)
      all.high = {std::max(all.high.x, all.low.x + legend_width_), drawing.high.y + legend_height_};
    write_head(all);
    write_frames();
    group("bonds", [&] {
      for (std::size_t i = 0; i < scene_.bonds.size(); ++i) write_bond(i);
    });
    group("signals", [&] {
      for (const DrawnSignal& signal : scene_.signals) write_signal(signal);
    });
    group("elements", [&] {
      for (std::size_t i = 0; i < scene_.elements.size(); ++i) write_element(i);
    });
    return out_ + legend + "</svg>\n";
  }

 private:
  template <class Ids>
  static void mark(std::vector<std::string>& marks, std::size_t size, const Ids& ids, const char* name) {
    marks.resize(size);
    for (const auto id : ids) marks[id.index()] = std::string(" ") + name;
  }

  template <class Work>
  void group(const char* name, const Work& work) {
    out_ += xml_begin("g", {{"class", name}}) + "\n";
    work();
    out_ += "</g>\n";
  }

  /// The begin of a group for one part of the model, which scripts find by its name.
  std::string part(const std::string& css, const char* data, const std::string& what, const std::string& name) const {
    return xml_begin("g", {{"class", css}, {"id", options_.id_prefix + what + "-" + name}, {data, name}});
  }

  void write_text(const PlacedText& text, const std::string& css) {
    if (text.text.empty()) return;
    const char* anchor = text.anchor == Anchor::middle ? "middle" : text.anchor == Anchor::start ? "start" : "end";
    const std::string below = text.subscript.empty() ? "" : subscript(text.subscript, text.size, 0.75);
    out_ += xml_element("text",
                        XmlAttributes{{"class", "halo " + css}} + at(text.at) +
                            XmlAttributes{{"font-size", px(text.size)}, {"text-anchor", anchor}} +
                            fitted(text.text + text.subscript, text.width),
                        xml_text(text.text) + below);
  }
  /// Keeps a text as wide as it was laid out where a viewer takes another font.
  static XmlAttributes fitted(const std::string& text, double width) {
    if (!exact_width(text)) return {};
    return {{"textLength", px(width)}, {"lengthAdjust", "spacingAndGlyphs"}};
  }
  static std::string subscript(const std::string& text, double size, double scale) {
    return xml_element("tspan", {{"dy", px(0.22 * size)}, {"font-size", px(scale * size)}}, xml_text(text));
  }

  std::string described() const {
    std::size_t junctions = 0;
    for (const Element& element : model_.elements) junctions += is_junction(element.kind) ? 1U : 0U;
    return std::to_string(model_.elements.size() - junctions) + " elements, " + std::to_string(junctions) +
           " junctions, " + std::to_string(model_.bonds.size()) + " bonds. " + model_.about;
  }

  void write_head(const Box& all) {
    const std::string& prefix = options_.id_prefix;
    const std::string width = px(all.width()), height = px(all.height());
    out_ += xml_begin("svg", {{"xmlns", "http://www.w3.org/2000/svg"},
                              {"class", "bg-drawing"},
                              {"role", "img"},
                              {"aria-labelledby", prefix + "title " + prefix + "desc"},
                              {"viewBox", px(all.low) + " " + width + " " + height},
                              {"width", width},
                              {"height", height}}) +
            "\n" + xml_element("title", {{"id", prefix + "title"}}, xml_text("Bond graph of " + model_.name)) + "\n" +
            xml_element("desc", {{"id", prefix + "desc"}}, xml_text(described())) + "\n" +
            xml_element("style", kStyle) + "\n" + xml_empty("rect", XmlAttributes{{"class", "paper"}} + at(all)) + "\n";
  }

  void write_frames() {
    if (scene_.frames.empty()) return;
    group("frames", [&] {
      for (const DrawnFrame& frame : scene_.frames) {
        const std::string name = frame.scope.substr(0, frame.scope.size() - 1);
        out_ += part("frame", "data-submodel", "submodel", name) + xml_text_element("title", "submodel " + name) +
                xml_empty("rect", at(frame.box) + XmlAttributes{{"rx", "8"}});
        write_text(frame.name, "frame-name");
        out_ += "</g>\n";
      }
    });
  }

  std::string end_text(const BondEndText& end) const {
    const Element& element = model_.elements[end.element.index()];
    return end.port && port_count(element) > 1 ? port_name(element, *end.port) : element.name;
  }

  std::string bond_title(std::size_t i) const {
    const ModelBond& bond = model_.bonds[i];
    std::string text = bond.name + ": from " + end_text(bond.from) + " to " + end_text(bond.to);
    if (scene_.bonds[i].barbs.size() > 1) return text + "; takes no power";
    if (!scene_.bonds[i].stroke) return text + "; no stroke assigned";
    const bool head = *causality_.strokes[i] == BondEnd::head;
    text += "; stroke at " + end_text(head ? bond.to : bond.from);
    if (!causality_.reasons[i].empty()) text += ", because " + causality_.reasons[i];
    return text;
  }

  static std::string arrow(const DrawnBond& bond) {
    if (bond.barbs.size() == 1) return "M" + px(bond.tip) + "L" + px(bond.barbs.front());
    return "M" + px(bond.barbs[0]) + "L" + px(bond.tip) + "L" + px(bond.barbs[1]);
  }

  void write_bond(std::size_t i) {
    const DrawnBond& bond = scene_.bonds[i];
    const std::string unassigned = bond.stroke || bond.barbs.size() > 1 ? "" : " unassigned";
    out_ += part("bond" + bond_marks_[i] + unassigned, "data-bond", "bond", model_.bonds[i].name) +
            xml_text_element("title", bond_title(i)) + path_element("hit", path(bond.line)) +
            path_element("line", path(bond.line)) + path_element("arrow", arrow(bond));
    if (bond.stroke) out_ += path_element("stroke", "M" + px(bond.stroke->first) + "L" + px(bond.stroke->second));
    for (const PlacedText& port : bond.ports) write_text(port, "port");
    for (const PlacedText& name : bond.names) write_text(name, options_.effort_flow ? "effort-flow" : "bond-name");
    out_ += "</g>\n";
  }

  void write_signal(const DrawnSignal& drawn) {
    const Curve& line = drawn.line;
    const auto [left, right] = signal_barbs(line);
    out_ += xml_begin("g", {{"class", "signal"}, {"data-to", model_.elements[drawn.signal.to.index()].name}}) +
            xml_text_element("title", drawn.signal.about) + path_element(path(line)) +
            path_element("M" + px(left) + "L" + px(line.end) + "L" + px(right));
    if (drawn.label) write_text(*drawn.label, "signal-name");
    out_ += "</g>\n";
  }

  void write_element(std::size_t i) {
    const DrawnElement& drawn = scene_.elements[i];
    const Element& element = model_.elements[i];
    const Capsule shape = capsule(element, drawn.at);
    const std::string kind = kind_text(element.kind, element.modulated);
    const Box disc = grown(shape.box(), -1.5);
    const std::string below =
        drawn.letters.subscript.empty() ? "" : subscript(drawn.letters.subscript, kLetterSize, 0.7);
    out_ +=
        part("element kind-" + kind + element_marks_[i], "data-element", "element", element.name) +
        xml_text_element("title", kind + " " + element.name + (element.about.empty() ? "" : ": " + element.about)) +
        xml_empty("rect", XmlAttributes{{"class", "mark"}} + at(disc) + XmlAttributes{{"rx", px(disc.height() / 2)}}) +
        xml_element("text",
                    XmlAttributes{{"class", "letter"}} + at(drawn.at + Point{0.0, 0.355 * kLetterSize}) +
                        XmlAttributes{{"font-size", px(kLetterSize)}, {"text-anchor", "middle"}},
                    xml_text(drawn.letters.base) + below);
    write_text(drawn.name, "name");
    out_ += "</g>\n";
  }

  // --- the legend: what is marked, and only that ---

  void legend_line(std::string& text, const std::string& css, const std::string& sample, const std::string& words) {
    const Point at_line{scene_.bounds.low.x + 14.0, scene_.bounds.high.y + legend_height_ + 8.0};
    text += xml_element("g", {{"class", css}, {"transform", "translate(" + px(at_line.x) + "," + px(at_line.y) + ")"}},
                        sample) +
            xml_element("text",
                        XmlAttributes{{"class", "name"}} + at(at_line + Point{40.0, 4.0}) +
                            XmlAttributes{{"font-size", "11.5"}} + fitted(words, text_width(words, 11.5)),
                        xml_text(words)) +
            "\n";
    legend_height_ += 19.0;
    legend_width_ = std::max(legend_width_, 70.0 + text_width(words, 11.5));
  }

  std::string write_legend() {
    std::string lines;
    const std::string disc =
        xml_empty("rect", {{"class", "mark"}, {"x", "4"}, {"y", "-9"}, {"width", "18"}, {"height", "18"}, {"rx", "9"}});
    const std::string line = path_element("line", "M0 0L28 0");
    if (!causality_.dependent.empty())
      legend_line(lines, "element dependent", disc + line,
                  "derivative causality: a dependent store, no state of its own");
    if (!causality_.free.empty())
      legend_line(lines, "bond free", line, "stroke freely chosen: an algebraic loop runs through this bond");
    if (!causality_.faulty.empty()) legend_line(lines, "element faulty", disc, "a rule is broken here");
    if (!causality_.problems.empty())
      legend_line(lines, "bond faulty", "",
                  causality_.problems.front().code + ": " + causality_.problems.front().situation);
    if (std::any_of(scene_.bonds.begin(), scene_.bonds.end(),
                    [](auto& bond) { return !bond.stroke && bond.barbs.size() == 1; }))
      legend_line(lines, "bond", line + path_element("M28 0L19 5"), "bond without a stroke: causality went no further");
    if (!scene_.signals.empty()) {
      const std::vector<ReadSignal> signals = read_signals(model_);
      const auto of_condition = [this](const ReadSignal& signal) {
        return is_switch(model_.elements[signal.to.index()].kind);
      };
      const bool some = std::any_of(signals.begin(), signals.end(), of_condition);
      const bool all = std::all_of(signals.begin(), signals.end(), of_condition);
      legend_line(lines, "signal", path_element("M0 0L28 0") + path_element("M21 -3.2L28 0L21 3.2"),
                  std::string("signal: a ") +
                      (all    ? "condition"
                       : some ? "law or condition"
                              : "law") +
                      " reads this, no power flows");
    }
    if (legend_height_ > 0.0) legend_height_ += 8.0;
    return lines.empty() ? lines : xml_element("g", {{"class", "legend"}}, "\n" + lines) + "\n";
  }

  const Model& model_;
  const DrawnCausality& causality_;
  const DrawingOptions& options_;
  DrawnScene scene_;
  std::vector<std::string> bond_marks_, element_marks_;
  std::string out_;
  double legend_height_ = 0.0, legend_width_ = 0.0;
};

}  // namespace

std::string drawing_svg(const Model& model, const DrawnCausality& causality, const Layout& layout,
                        const DrawingOptions& options) {
  return SvgWriter(model, causality, options, place_all(model, causality, layout, options)).run();
}

}  // namespace bgsim
