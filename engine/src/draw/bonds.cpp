// Where bonds run: straight where they can, round obstacles where they cannot, their strokes clear of each
// other.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "draw/scene.hpp"

namespace bgsim {

namespace {

constexpr double kStroke = 7.0;                   // half length of a causal stroke, in px
constexpr double kBarb = 10.5, kBarbAngle = 0.5;  // the half-arrow's, in px and rad
constexpr double kStrokeApart = 2.5;              // between a stroke and another bond, middle to middle

/// How a bond runs: how far it is bent, and the clear space at its ends.
struct Way {
  double bulge = 0.0, tail = 14.0, head = 14.0;
};

/// One end of a bond, seen from the element.
struct BondEndLine {
  Point begin, towards;
  double reach = 0.0;  ///< length of the bond
  bool stroke = false;
  [[nodiscard]] std::pair<Point, Point> line() const { return {begin, begin + reach * towards}; }
  [[nodiscard]] std::pair<Point, Point> cross() const {
    return {begin + kStroke * turned(towards), begin - kStroke * turned(towards)};
  }
};

double distance_to(Point p, const std::pair<Point, Point>& segment) {
  const Point along = segment.second - segment.first, away = p - segment.first;
  const double whole = along.x * along.x + along.y * along.y;
  const double s = whole > 0.0 ? std::clamp((along.x * away.x + along.y * away.y) / whole, 0.0, 1.0) : 0.0;
  return length(away - s * along);
}

double cross_product(Point a, Point b) { return a.x * b.y - a.y * b.x; }

bool close(const std::pair<Point, Point>& a, const std::pair<Point, Point>& b) {
  const auto side = [](const std::pair<Point, Point>& of, Point p) {
    return cross_product(of.second - of.first, p - of.first) > 0.0;
  };
  if (side(a, b.first) != side(a, b.second) && side(b, a.first) != side(b, a.second)) return true;
  return std::min({distance_to(a.first, b), distance_to(a.second, b), distance_to(b.first, a),
                   distance_to(b.second, a)}) < kStrokeApart;
}

/// Strokes on something else, or bonds that begin as one line.
bool touch(const BondEndLine& a, const BondEndLine& b) {
  constexpr double kSameDirection = 0.995;  // cosine of 6 degrees
  if (a.towards.x * b.towards.x + a.towards.y * b.towards.y > kSameDirection) return true;
  return (a.stroke && close(a.cross(), b.line())) || (b.stroke && close(b.cross(), a.line())) ||
         (a.stroke && b.stroke && close(a.cross(), b.cross()));
}

class BondPlacing {
 public:
  BondPlacing(const Model& model, const DrawnCausality& causality, const Layout& layout, Taken& taken)
      : model_(model), causality_(causality), layout_(layout), taken_(taken), ways_(model.bonds.size()) {
    placed_.bonds.resize(model.bonds.size());
    placed_.towards.resize(model.elements.size());
    at_.resize(model.elements.size());
    for (std::size_t i = 0; i < model.bonds.size(); ++i) {
      at_[model.bonds[i].from.element.index()].push_back({i, false});
      at_[model.bonds[i].to.element.index()].push_back({i, true});
    }
  }

  PlacedBonds run() {
    choose_ways();
    clear_strokes();
    for (std::size_t i = 0; i < model_.bonds.size(); ++i) place_bond(i, line_of(i, ways_[i]));
    return std::move(placed_);
  }

 private:
  struct End {
    std::size_t bond = 0;
    bool head = false;
  };

  Curve line_of(std::size_t i, const Way& way) const {
    const ElementId from = model_.bonds[i].from.element, to = model_.bonds[i].to.element;
    Capsule tail = capsule(model_.elements[from.index()], layout_.elements[from.index()]);
    Capsule head = capsule(model_.elements[to.index()], layout_.elements[to.index()]);
    tail.radius = std::max(way.tail, tail.radius);
    head.radius = std::max(way.head, head.radius);
    return between(tail, head, way.bulge);
  }

  double whole_length(std::size_t i) const {
    return length(layout_.elements[model_.bonds[i].to.element.index()] -
                  layout_.elements[model_.bonds[i].from.element.index()]);
  }

  // --- straight or not ---

  void choose_ways() {
    std::map<std::pair<ElementId, ElementId>, std::vector<std::size_t>> pairs;
    for (std::size_t i = 0; i < model_.bonds.size(); ++i)
      pairs[std::minmax(model_.bonds[i].from.element, model_.bonds[i].to.element)].push_back(i);
    std::vector<std::size_t> blocked;
    std::vector<Taken::Range> lines;
    for (const auto& [ends, bonds] : pairs)
      for (std::size_t k = 0; k < bonds.size(); ++k) {
        const bool forth = model_.bonds[bonds[k]].from.element == ends.first;
        const double apart = 0.3 * (static_cast<double>(k) - 0.5 * static_cast<double>(bonds.size() - 1));
        ways_[bonds[k]].bulge = forth ? apart : -apart;
        const Curve line = line_of(bonds[k], ways_[bonds[k]]);
        if (bonds.size() == 1 && taken_.crossed(line, kSolid) > 0.0)
          blocked.push_back(bonds[k]);
        else
          lines.push_back(taken_.add(line, kLineWeight));
      }
    // What cannot be straight goes round, once the straight ones are there.
    for (const std::size_t bond : blocked) {
      ways_[bond].bulge = bulge_round(bond);
      const Curve line = line_of(bond, ways_[bond]);
      placed_.trouble += taken_.crossed(line, kSolid);
      lines.push_back(taken_.add(line, kLineWeight));
    }
    for (const Taken::Range range : lines) taken_.remove(range);
  }

  double bulge_round(std::size_t i) const {
    double best = 0.0, least = std::numeric_limits<double>::infinity();
    for (const double bend : {0.0, 0.12, -0.12, 0.2, -0.2, 0.3, -0.3, 0.42, -0.42, 0.6, -0.6, 0.8, -0.8}) {
      const double cost =
          taken_.crossed(line_of(i, {bend, ways_[i].tail, ways_[i].head})) + 25.0 * std::abs(std::abs(bend) - 0.42);
      if (cost >= least) continue;
      least = cost;
      best = bend;
    }
    return best;
  }

  // --- strokes ---

  /// Ends bonds further from the letter where they meet others at a small angle; what that does not help is bent, and
  /// so is what runs through a stroke elsewhere.
  void clear_strokes() {
    constexpr int kRounds = 4;
    constexpr double kBend = 0.09, kTouching = 300.0;
    std::size_t through = 0;
    for (int round = 0; round < kRounds; ++round) {
      const bool last = round + 1 == kRounds;
      touching_.clear();
      // Bent first; what is still close after that ends far out.
      const double most = round < 2 ? 40.0 : 80.0;
      for (std::size_t i = 0; i < at_.size(); ++i) space_ends(i, most);
      for (const auto& [bond, sign] : touching_) {
        Way bent = ways_[bond];
        bent.bulge += sign * kBend;
        if (!last && taken_.crossed(line_of(bond, bent), kSolid) == 0.0) ways_[bond] = bent;
      }
      if (!touching_.empty() && !last) continue;
      through = leave_strokes(last);
      if (through == 0) break;
    }
    placed_.trouble += kTouching * static_cast<double>(touching_.size() + through);
  }

  /// Bends bonds that run through the stroke of another. @return how many there were.
  std::size_t leave_strokes(bool count_only) {
    Taken strokes;
    std::vector<Taken::Range> own(model_.bonds.size());
    const auto add = [&](std::size_t i) {
      for (const bool head : {false, true}) {
        const BondEndLine end = seen({i, head}, head ? ways_[i].head : ways_[i].tail);
        if (!end.stroke) continue;
        const auto [a, b] = end.cross();
        own[i] = strokes.add(Curve{a, 0.5 * (a + b), b}, 1.0);
      }
    };
    for (std::size_t i = 0; i < own.size(); ++i) add(i);
    std::size_t count = 0;
    for (std::size_t i = 0; i < own.size(); ++i) {
      const Way straight = ways_[i];
      strokes.remove(own[i]);
      double least = strokes.crossed(line_of(i, straight));
      if (least > 0.0) {
        ++count;
        for (const double bend : {0.05, -0.05, 0.09, -0.09, 0.14, -0.14, 0.2, -0.2}) {
          Way bent = straight;
          bent.bulge += bend;
          const Curve tried = line_of(i, bent);
          const double cost = strokes.crossed(tried) + taken_.crossed(tried, kSolid);
          if (count_only || cost >= least) continue;
          least = cost;
          ways_[i] = bent;
        }
      }
      add(i);
    }
    return count;
  }

  BondEndLine seen(const End& end, double clear) const {
    Way way = ways_[end.bond];
    (end.head ? way.head : way.tail) = clear;
    const Curve line = line_of(end.bond, way);
    const auto& strokes = causality_.strokes;
    const ModelBond& bond = model_.bonds[end.bond];
    const bool detector = is_detector(model_.elements[bond.from.element.index()].kind) ||
                          is_detector(model_.elements[bond.to.element.index()].kind);
    const bool stroke = !detector && end.bond < strokes.size() && strokes[end.bond] &&
                        (*strokes[end.bond] == BondEnd::head) == end.head;
    const double reach = length(line.end - line.begin);
    if (end.head) return {line.end, -1.0 * line.tangent(1.0), reach, stroke};
    return {line.begin, line.tangent(0.0), reach, stroke};
  }

  void space_ends(std::size_t element, double most_clear) {
    constexpr double kLeast = 14.0, kStep = 2.0, kOfLength = 0.42;
    std::vector<End> ends = at_[element];
    if (ends.size() < 2) return;
    std::stable_sort(ends.begin(), ends.end(),
                     [&](const End& a, const End& b) { return whole_length(a.bond) < whole_length(b.bond); });
    std::multimap<double, BondEndLine> done;  // by direction
    for (const End& end : ends) {
      double& clear = end.head ? ways_[end.bond].head : ways_[end.bond].tail;
      const double most = std::clamp(kOfLength * whole_length(end.bond), kLeast, most_clear);
      BondEndLine line = seen(end, kLeast);
      const BondEndLine* hit = nullptr;
      for (clear = kLeast; clear <= most; clear += kStep) {
        line = seen(end, clear);
        hit = touched(done, line);
        if (hit == nullptr) break;
      }
      if (hit != nullptr) {
        clear = kLeast;
        line = seen(end, clear);
        // Bent away from the other; a bulge is counted from tail to head.
        const bool left = cross_product(line.towards, hit->towards) > 0.0;
        touching_.emplace_back(end.bond, left == end.head ? 1.0 : -1.0);
      }
      done.emplace(std::atan2(line.towards.y, line.towards.x), line);
    }
  }

  /// The first of those beside it in direction that @p line touches; none further away than the nearest few.
  static const BondEndLine* touched(const std::multimap<double, BondEndLine>& done, const BondEndLine& line) {
    constexpr int kNearest = 4;
    if (done.empty()) return nullptr;
    const auto from = done.lower_bound(std::atan2(line.towards.y, line.towards.x));
    auto up = from, down = from;
    for (int k = 0; k < kNearest; ++k) {
      if (up == done.end()) up = done.begin();
      if (down == done.begin()) down = done.end();
      --down;
      if (touch(up->second, line)) return &up->second;
      if (touch(down->second, line)) return &down->second;
      ++up;
    }
    return nullptr;
  }

  void place_bond(std::size_t i, const Curve& line) {
    const ModelBond& bond = model_.bonds[i];
    DrawnBond& drawn = placed_.bonds[i];
    drawn.line = line;
    const bool out = is_detector(model_.elements[bond.from.element.index()].kind);
    const bool detector = out || is_detector(model_.elements[bond.to.element.index()].kind);
    const Point along = out ? -1.0 * line.tangent(0.0) : line.tangent(1.0), side = flow_side(along);
    drawn.tip = out ? line.begin : line.end;
    for (const double way : {1.0, -1.0})
      if (way > 0.0 || detector)
        drawn.barbs.push_back(drawn.tip + kBarb * (-std::cos(kBarbAngle) * along + way * std::sin(kBarbAngle) * side));
    if (!detector && i < causality_.strokes.size() && causality_.strokes[i]) {
      const bool head = *causality_.strokes[i] == BondEnd::head;
      const Point at = head ? line.end : line.begin, n = turned(line.tangent(head ? 1.0 : 0.0));
      drawn.stroke = {at + kStroke * n, at - kStroke * n};
      taken_.add(around(at, 13.0, 13.0), kLineWeight);
    }
    taken_.add(around(0.5 * (drawn.barbs.front() + drawn.tip), 9.0, 9.0), kLineWeight);
    taken_.add(line, kLineWeight);
    Point &from = placed_.towards[bond.from.element.index()], &to = placed_.towards[bond.to.element.index()];
    from = from + line.tangent(0.0);
    to = to - line.tangent(1.0);
  }

  const Model& model_;
  const DrawnCausality& causality_;
  const Layout& layout_;
  Taken& taken_;
  PlacedBonds placed_;
  std::vector<Way> ways_;                                 // by BondId
  std::vector<std::vector<End>> at_;                      // by ElementId
  std::vector<std::pair<std::size_t, double>> touching_;  // bonds, and to which side they would bend
};

}  // namespace

PlacedBonds place_bonds(const Model& model, const DrawnCausality& causality, const Layout& layout, Taken& taken) {
  return BondPlacing(model, causality, layout, taken).run();
}

}  // namespace bgsim
