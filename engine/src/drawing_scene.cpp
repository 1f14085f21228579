// Puts everything of a drawing in its place: first what cannot give way (letters, bonds), then what can (names), each
// where it covers least of what is there.
#include "drawing_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace bgsim {

namespace {

constexpr double kStroke = 7.0;                   // half length of a causal stroke, in px
constexpr double kBarb = 10.5, kBarbAngle = 0.5;  // the half-arrow's, in px and rad
constexpr double kMargin = 14.0;

// How bad it is to cover something; what counts more than kSolid is gone round by bonds.
constexpr double kLetterWeight = 10.0, kSolid = 9.0, kNameWeight = 6.0, kLineWeight = 4.0, kSignalWeight = 1.5;

Point turned(Point a) { return {-a.y, a.x}; }

/// The side of a line on which its flow is written and its barb stands: below, or right of an upright one.
Point flow_side(Point tangent) {
  const Point n = turned(tangent);
  const double low = n.x + n.y;
  return low > 1e-9 || (std::abs(low) <= 1e-9 && n.y > 0.0) ? n : -1.0 * n;
}

Curve between(const Capsule& a, const Capsule& b, double bulge) {
  const Point middle = 0.5 * (a.centre + b.centre);
  if (bulge == 0.0) {
    const Point begin = a.edge(b.centre - a.centre), end = b.edge(a.centre - b.centre);
    return {begin, 0.5 * (begin + end), end};
  }
  const Point control = middle + bulge * turned(b.centre - a.centre);
  return {a.edge(control - a.centre), control, b.edge(control - b.centre)};
}

PlacedText text_at(Point centre, Anchor anchor, double size, std::string text, std::string subscript = {}) {
  PlacedText placed;
  const double width = text_width(text, size) + text_width(subscript, 0.75 * size);
  const double left = anchor == Anchor::middle  ? centre.x - width / 2
                      : anchor == Anchor::start ? centre.x
                                                : centre.x - width;
  placed.box = {{left, centre.y - 0.5 * size}, {left + width, centre.y + 0.5 * size}};
  placed.at = {centre.x, centre.y + 0.35 * size};
  placed.anchor = anchor;
  placed.size = size;
  placed.text = std::move(text);
  placed.subscript = std::move(subscript);
  return placed;
}

class Placing {
 public:
  Placing(const Model& model, const DrawnCausality& causality, const Layout& layout, const DrawingOptions& options)
      : model_(model), causality_(causality), layout_(layout), options_(options) {
    scene_.bonds.resize(model.bonds.size());
    scene_.elements.resize(model.elements.size());
    towards_.resize(model.elements.size());
  }

  DrawnScene run() {
    place_letters();
    place_bonds();
    for (std::size_t i = 0; i < model_.elements.size(); ++i) place_name(i);
    place_signals();
    place_frames();
    for (std::size_t i = 0; i < model_.bonds.size(); ++i) place_ports(i);
    for (std::size_t i = 0; i < model_.bonds.size(); ++i) place_bond_names(i);
    for (DrawnSignal& signal : scene_.signals) place_signal_label(signal);
    scene_.bounds = bounds();
    return std::move(scene_);
  }

 private:
  Capsule capsule_of(ElementId id) const { return capsule(model_.elements[id.index()], layout_.elements[id.index()]); }

  void place_letters() {
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      DrawnElement& drawn = scene_.elements[i];
      drawn.at = layout_.elements[i];
      drawn.letters = letters(model_.elements[i]);
      taken_.add(grown(capsule_of(ElementId(i)).box(), -3.0), kLetterWeight);
    }
  }

  // --- bonds ---

  void place_bonds() {
    find_clearances();
    std::map<std::pair<ElementId, ElementId>, std::vector<std::size_t>> pairs;
    for (std::size_t i = 0; i < model_.bonds.size(); ++i)
      pairs[std::minmax(model_.bonds[i].from.element, model_.bonds[i].to.element)].push_back(i);
    std::vector<std::size_t> blocked;
    for (const auto& [ends, bonds] : pairs)
      for (std::size_t k = 0; k < bonds.size(); ++k) {
        const bool forth = model_.bonds[bonds[k]].from.element == ends.first;
        const double apart = 0.3 * (static_cast<double>(k) - 0.5 * static_cast<double>(bonds.size() - 1));
        const auto [from, to] = ends_of(bonds[k], true);
        const Curve line = between(from, to, forth ? apart : -apart);
        if (bonds.size() == 1 && taken_.crossed(line, kSolid) > 0.0)
          blocked.push_back(bonds[k]);
        else
          place_bond(bonds[k], line);
      }
    // What cannot be straight goes round, once the straight ones are there.
    for (const std::size_t bond : blocked) place_bond(bond, way_round(bond));
  }

  std::pair<Capsule, Capsule> ends_of(std::size_t i, bool clear) const {
    std::pair<Capsule, Capsule> ends{capsule_of(model_.bonds[i].from.element), capsule_of(model_.bonds[i].to.element)};
    if (!clear) return ends;
    ends.first.radius = std::max(ends.first.radius, clearance_[i].first);
    ends.second.radius = std::max(ends.second.radius, clearance_[i].second);
    return ends;
  }

  Curve way_round(std::size_t i) const {
    const auto [from, to] = ends_of(i, false);
    Curve way = between(from, to, 0.0);
    double least = std::numeric_limits<double>::infinity();
    for (const double bend : {0.0, 0.12, -0.12, 0.2, -0.2, 0.3, -0.3, 0.42, -0.42, 0.6, -0.6, 0.8, -0.8}) {
      const Curve tried = between(from, to, bend);
      const double cost = taken_.crossed(tried) + 25.0 * std::abs(std::abs(bend) - 0.42);
      if (cost < least) {
        least = cost;
        way = tried;
      }
    }
    return way;
  }

  /// Clear space at each end of each bond. Bonds that meet at a small angle end further out, so that the stroke of one
  /// does not touch the other.
  void find_clearances() {
    constexpr double kMost = 24.0;
    clearance_.assign(model_.bonds.size(), {0.0, 0.0});
    std::vector<std::vector<std::pair<double, double*>>> at(model_.elements.size());
    for (std::size_t i = 0; i < model_.bonds.size(); ++i) {
      const ElementId from = model_.bonds[i].from.element, to = model_.bonds[i].to.element;
      const Point d = layout_.elements[to.index()] - layout_.elements[from.index()];
      at[from.index()].emplace_back(std::atan2(d.y, d.x), &clearance_[i].first);
      at[to.index()].emplace_back(std::atan2(-d.y, -d.x), &clearance_[i].second);
    }
    constexpr double kTurn = 6.283185307179586;
    for (auto& ends : at) {
      std::sort(ends.begin(), ends.end());
      for (std::size_t k = 0; ends.size() > 1 && k < ends.size(); ++k) {
        const bool wraps = k + 1 == ends.size();
        const auto& next = ends[wraps ? 0 : k + 1];
        const double angle = next.first - ends[k].first + (wraps ? kTurn : 0.0);
        if (angle >= 1.0 || angle < 0.05) continue;  // parallel bonds are curved apart
        const double needed = std::min(kMost, (kStroke + 0.5) / std::tan(angle / 2));
        for (double* end : {ends[k].second, next.second}) *end = std::max(*end, needed);
      }
    }
  }

  void place_bond(std::size_t i, const Curve& line) {
    const ModelBond& bond = model_.bonds[i];
    DrawnBond& drawn = scene_.bonds[i];
    drawn.line = line;
    const Point along = line.tangent(1.0), side = flow_side(along);
    drawn.barb = line.end + kBarb * (-std::cos(kBarbAngle) * along + std::sin(kBarbAngle) * side);
    if (i < causality_.strokes.size() && causality_.strokes[i]) {
      const bool head = *causality_.strokes[i] == BondEnd::head;
      const Point at = head ? line.end : line.begin, n = turned(line.tangent(head ? 1.0 : 0.0));
      drawn.stroke = {at + kStroke * n, at - kStroke * n};
      taken_.add(around(at, 13.0, 13.0), kLineWeight);
    }
    taken_.add(around(0.5 * (drawn.barb + line.end), 9.0, 9.0), kLineWeight);
    taken_.add(line, kLineWeight);
    towards_[bond.from.element.index()] = towards_[bond.from.element.index()] + line.tangent(0.0);
    towards_[bond.to.element.index()] = towards_[bond.to.element.index()] - line.tangent(1.0);
  }

  // --- names ---

  struct Candidate {
    PlacedText text;
    double cost = 0.0;
  };

  PlacedText best_of(const std::vector<Candidate>& candidates, double weight) {
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const double cost = taken_.overlap(grown(candidates[i].text.box, 1.0)) + candidates[i].cost;
      if (cost >= least) continue;
      least = cost;
      best = i;
    }
    taken_.add(candidates[best].text.box, weight);
    return candidates[best].text;
  }

  void place_name(std::size_t i) {
    const Element& element = model_.elements[i];
    const Capsule shape = capsule_of(ElementId(i));
    const Point at = shape.centre;
    const std::string name = local_name(element.name);
    const bool one_port = !is_junction(element.kind) && port_count(element) == 1;
    const double side = shape.reach + 12.0, high = 18.0;
    std::vector<Candidate> candidates;
    const auto add = [&](Point offset, Anchor anchor, const std::string& text, double cost) {
      // Away from the bond, as far as there is one direction to speak of.
      const double against = unit(offset).x * unit(towards_[i]).x + unit(offset).y * unit(towards_[i]).y;
      candidates.push_back(
          {text_at(at + offset, anchor, kNameSize, text), cost + (one_port ? 60.0 * (1.0 + against) : 0.0)});
    };
    const double sides = one_port ? 0.0 : 30.0;
    add({side, 0.0}, Anchor::start, one_port ? ": " + name : name, sides);
    add({-side, 0.0}, Anchor::end, one_port ? name + " :" : name, sides);
    add({0.0, high}, Anchor::middle, name, is_junction(element.kind) ? 22.0 : 0.0);
    add({0.0, -high}, Anchor::middle, name, is_junction(element.kind) ? 20.0 : 2.0);
    for (const double further : {0.0, 6.0, 12.0, 18.0}) {
      const double x = shape.reach + 7.0, y = 14.0 + further,
                   cost = (is_junction(element.kind) ? 0.0 : 16.0) + 2.0 * further;
      add({x, -y}, Anchor::start, name, cost);
      add({-x, -y}, Anchor::end, name, cost + 1.0);
      add({x, y}, Anchor::start, name, cost + 2.0);
      add({-x, y}, Anchor::end, name, cost + 3.0);
    }
    scene_.elements[i].name = best_of(candidates, kNameWeight);
  }

  /// Beside the line at @p s, on the side @p n, just clear of it.
  static PlacedText beside(const Curve& line, double s, Point n, double size, std::string text,
                           std::string subscript = {}) {
    PlacedText placed = text_at(line.at(s), Anchor::middle, size, std::move(text), std::move(subscript));
    const double clear = 3.5 + std::abs(n.x) * placed.box.width() / 2 + std::abs(n.y) * placed.box.height() / 2;
    return text_at(line.at(s) + clear * n, Anchor::middle, size, placed.text, placed.subscript);
  }

  void place_ports(std::size_t i) {
    const ModelBond& bond = model_.bonds[i];
    DrawnBond& drawn = scene_.bonds[i];
    for (const bool head : {false, true}) {
      const BondEndText& end = head ? bond.to : bond.from;
      const Element& element = model_.elements[end.element.index()];
      if (!is_field(element.kind) || !end.port) continue;
      const double whole = std::max(1.0, length(drawn.line.end - drawn.line.begin));
      const Point side = flow_side(drawn.line.tangent(head ? 1.0 : 0.0));
      std::vector<Candidate> candidates;
      const std::string& name = element.ports[*end.port];
      for (const double away : {0.5 * text_width(name, 9.5) + 6.0, 22.0, 30.0}) {
        const double s = std::min(0.5, away / whole);
        for (const double sign : {1.0, -1.0})
          candidates.push_back(
              {beside(drawn.line, head ? 1.0 - s : s, sign * side, 9.5, name), away + (sign < 0 ? 1.0 : 0.0)});
      }
      drawn.ports.push_back(best_of(candidates, kNameWeight));
    }
  }

  void place_bond_names(std::size_t i) {
    DrawnBond& drawn = scene_.bonds[i];
    const std::string name = local_name(model_.bonds[i].name);
    const auto place = [&](double preferred, const std::string& text, const std::string& subscript, bool either_side) {
      std::vector<Candidate> candidates;
      for (const double s : {0.5, 0.44, 0.56, 0.38, 0.62, 0.31, 0.69, 0.24, 0.76}) {
        const Point side = flow_side(drawn.line.tangent(s));
        const double cost = 40.0 * std::abs(s - 0.5);
        candidates.push_back({beside(drawn.line, s, preferred * side, kBondNameSize, text, subscript), cost});
        if (either_side)
          candidates.push_back({beside(drawn.line, s, -preferred * side, kBondNameSize, text, subscript), cost + 3.0});
      }
      drawn.names.push_back(best_of(candidates, kNameWeight));
    };
    if (options_.effort_flow) {
      const bool numbered =
          name.size() > 1 && name[0] == 'b' && name.find_first_not_of("0123456789", 1) == std::string::npos;
      const std::string subscript = numbered ? name.substr(1) : name;
      place(-1.0, "e", subscript, false);
      place(1.0, "f", subscript, false);
    } else if (options_.bond_names) {
      place(-1.0, name, {}, true);
    }
  }

  // --- signals ---

  void place_signals() {
    for (ReadSignal& signal : read_signals(model_)) {
      Capsule from;
      if (signal.from.valid()) {
        from = capsule_of(signal.from);
      } else {
        from.centre = scene_.bonds[signal.from_bond.index()].line.at(0.5);
        from.radius = 3.0;
      }
      const Capsule to = capsule_of(signal.to);
      DrawnSignal drawn;
      double least = std::numeric_limits<double>::infinity();
      for (const double bend : {0.0, 0.1, -0.1, 0.2, -0.2, 0.33, -0.33, 0.5, -0.5, 0.7, -0.7, 0.95, -0.95}) {
        const Curve tried = between(from, to, bend);
        const double cost = taken_.crossed(tried) + 60.0 * std::abs(bend);
        if (cost >= least) continue;
        least = cost;
        drawn.line = tried;
      }
      taken_.add(drawn.line, kSignalWeight);
      drawn.signal = std::move(signal);
      scene_.signals.push_back(std::move(drawn));
    }
  }

  void place_signal_label(DrawnSignal& drawn) {
    std::vector<Candidate> candidates;
    for (const double s : {0.5, 0.42, 0.58, 0.34, 0.66, 0.75, 0.25})
      for (const double sign : {-1.0, 1.0}) {
        const Point side = flow_side(drawn.line.tangent(s));
        candidates.push_back(
            {beside(drawn.line, s, sign * side, kBondNameSize, drawn.signal.label), 40.0 * std::abs(s - 0.5)});
      }
    drawn.label = best_of(candidates, kNameWeight);
  }

  // --- frames ---

  void place_frames() {
    std::map<std::string, Box> inside;
    const auto include = [&](std::string scope, const Box& box) {
      for (double pad = kMargin; !scope.empty();
           scope = scope_of(scope.substr(0, scope.size() - 1)), pad += kMargin + 6.0) {
        const Box padded = {grown(box, pad).low - Point{0.0, 6.0}, grown(box, pad).high};
        const auto [at, fresh] = inside.emplace(scope, padded);
        if (!fresh) at->second = united(at->second, padded);
      }
    };
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      const std::string scope = scope_of(model_.elements[i].name);
      include(scope, capsule_of(ElementId(i)).box());
      include(scope, scene_.elements[i].name.box);
    }
    for (std::size_t i = 0; i < model_.bonds.size(); ++i)
      include(scope_of(model_.bonds[i].name), around(scene_.bonds[i].line.at(0.5), 1.0, 1.0));
    for (const auto& [scope, box] : inside) {
      const std::string name = local_name(scope.substr(0, scope.size() - 1));
      DrawnFrame frame{scope, box, text_at(box.low + Point{8.0, 10.0}, Anchor::start, kNameSize, name)};
      frame.box.high.x = std::max(frame.box.high.x, frame.name.box.high.x + 8.0);
      taken_.add(frame.name.box, kNameWeight);
      scene_.frames.push_back(std::move(frame));
    }
  }

  Box bounds() const {
    Box all{};
    bool first = true;
    const auto include = [&](const Box& box) {
      all = first ? box : united(all, box);
      first = false;
    };
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      include(capsule_of(ElementId(i)).box());
      include(scene_.elements[i].name.box);
    }
    for (const DrawnFrame& frame : scene_.frames) include(frame.box);
    for (const DrawnBond& bond : scene_.bonds) {
      for (const double s : {0.25, 0.5, 0.75}) include(around(bond.line.at(s), 2.0, 2.0));
      for (const PlacedText& text : bond.names) include(text.box);
    }
    for (const DrawnSignal& signal : scene_.signals) {
      for (const double s : {0.25, 0.5, 0.75}) include(around(signal.line.at(s), 2.0, 2.0));
      if (signal.label) include(signal.label->box);
    }
    return grown(all, kMargin);
  }

  const Model& model_;
  const DrawnCausality& causality_;
  const Layout& layout_;
  const DrawingOptions& options_;
  DrawnScene scene_;
  Taken taken_;
  std::vector<std::pair<double, double>> clearance_;  // by BondId: at tail and head
  std::vector<Point> towards_;                        // by ElementId: sum of the directions of its bonds
};

}  // namespace

DrawnScene place_all(const Model& model, const DrawnCausality& causality, const Layout& layout,
                     const DrawingOptions& options) {
  return Placing(model, causality, layout, options).run();
}

}  // namespace bgsim
