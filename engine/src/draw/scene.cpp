// Puts everything of a drawing in its place: first what cannot give way (letters, bonds), then what can (signals,
// texts), each where it covers least of what is there; then what still covers something is moved, or the layout
// stretched.
#include "draw/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "model/element_kinds.hpp"

namespace bgsim {

namespace {

constexpr double kMargin = 14.0;

class Placing {
 public:
  Placing(const Model& model, const DrawnCausality& causality, const Layout& layout, const DrawingOptions& options)
      : model_(model), causality_(causality), layout_(layout), options_(options) {
    scene_.elements.resize(model.elements.size());
  }

  /// Once.
  DrawnScene run() {
    place_letters();
    place_bonds();
    place_signals();
    place_frames();
    place_bond_texts();
    labels_.improve();
    if (reroute_signals()) labels_.improve();
    take_texts();
    scene_.bounds = bounds();
    return std::move(scene_);
  }

  /// What covers something it should not: px^2 of texts and px of lines, by weight. Of a finished run.
  [[nodiscard]] double trouble() const { return trouble_; }

 private:
  Capsule capsule_of(ElementId id) const { return capsule(model_.elements[id.index()], layout_.elements[id.index()]); }

  void place_letters() {
    for (std::size_t i = 0; i < model_.elements.size(); ++i) {
      DrawnElement& drawn = scene_.elements[i];
      drawn.at = layout_.elements[i];
      drawn.letters = letters(model_.elements[i]);
      taken_.add(letter_box(i), kLetterWeight);
    }
  }

  /// Capitals with a little around them; subscripts go deeper.
  Box letter_box(std::size_t i) const {
    const Capsule capsule = capsule_of(ElementId(i));
    const Box box = grown(capsule.box(), 8.0 - capsule.radius);
    const Point at = layout_.elements[i];
    const bool source = !letters(model_.elements[i]).subscript.empty();
    return {{box.low.x, at.y - 9.0}, {box.high.x, at.y + (source ? 13.0 : 9.0)}};
  }

  void place_bonds() {
    PlacedBonds placed = bgsim::place_bonds(model_, causality_, layout_, taken_);
    scene_.bonds = std::move(placed.bonds);
    trouble_ += placed.trouble;
    for (std::size_t i = 0; i < model_.elements.size(); ++i)
      names_.push_back(labels_.add(name_places(model_.elements[i], layout_.elements[i], placed.towards[i])));
  }

  void place_bond_texts() {
    bond_texts_.resize(model_.bonds.size());
    for (std::size_t i = 0; i < model_.bonds.size(); ++i) {
      const ModelBond& bond = model_.bonds[i];
      for (const bool head : {false, true}) {
        const BondEndText& end = head ? bond.to : bond.from;
        const Element& element = model_.elements[end.element.index()];
        if (is_field(element.kind) && end.port)
          bond_texts_[i].ports.push_back(
              labels_.add(port_places(scene_.bonds[i].line, head, element.ports[*end.port])));
      }
    }
    for (std::size_t i = 0; i < model_.bonds.size(); ++i) {
      const std::string name = local_name(model_.bonds[i].name);
      const Curve& line = scene_.bonds[i].line;
      if (options_.effort_flow) {
        const bool numbered =
            name.size() > 1 && name[0] == 'b' && name.find_first_not_of("0123456789", 1) == std::string::npos;
        const std::string subscript = numbered ? name.substr(1) : name;
        bond_texts_[i].names = {labels_.add(beside_line(line, -1.0, false, "e", subscript)),
                                labels_.add(beside_line(line, 1.0, false, "f", subscript))};
      } else if (options_.bond_names) {
        bond_texts_[i].names = {labels_.add(beside_line(line, -1.0, true, name))};
      }
    }
  }

  // --- signals ---

  std::pair<Capsule, Capsule> ends_of(const ReadSignal& signal) const {
    std::pair<Capsule, Capsule> ends{{}, capsule_of(signal.to)};
    if (signal.from.valid()) {
      ends.first = capsule_of(signal.from);
    } else {
      ends.first.centre = scene_.bonds[signal.from_bond.index()].line.at(0.5);
      ends.first.radius = 3.0;
    }
    return ends;
  }

  /// The way that crosses least, and is not much longer than the straight one.
  Curve signal_way(const ReadSignal& signal) const {
    const auto [from, to] = ends_of(signal);
    const double whole = length(to.centre - from.centre);
    constexpr double kCrossing = 2.0;  // against going round
    Curve best = between(from, to, 0.0);
    double least = std::numeric_limits<double>::infinity();
    for (const double bend : {0.0, 0.1, -0.1, 0.2, -0.2, 0.33, -0.33, 0.5, -0.5, 0.7, -0.7, 0.95, -0.95, 1.3, -1.3})
      for (const double shift : {0.0, 0.3, -0.3}) {
        if (bend == 0.0 && shift != 0.0) continue;
        const double cost = (60.0 + 0.25 * whole) * std::abs(bend) + 20.0 * std::abs(shift);
        if (cost >= least) continue;
        const Curve tried = between(from, to, bend, shift);
        const double all = cost + kCrossing * taken_.crossed(tried);
        if (all >= least) continue;
        least = all;
        best = tried;
      }
    return best;
  }

  std::size_t add_signal_label(const DrawnSignal& drawn) {
    return labels_.add(beside_line(drawn.line, -1.0, true, drawn.signal.label));
  }

  /// The line with its arrow, as it is drawn.
  Taken::Range take_signal(const Curve& line) {
    Taken::Range taken = taken_.add(line, kSignalWeight);
    for (const Point barb : signal_barbs(line))
      taken.last = taken_.add(Curve{barb, 0.5 * (barb + line.end), line.end}, kSignalWeight).last;
    return taken;
  }

  void place_signals() {
    for (ReadSignal& signal : read_signals(model_)) {
      DrawnSignal drawn;
      drawn.line = signal_way(signal);
      drawn.signal = std::move(signal);
      signal_items_.push_back(take_signal(drawn.line));
      scene_.signals.push_back(std::move(drawn));
    }
    for (const DrawnSignal& drawn : scene_.signals) signal_labels_.push_back(add_signal_label(drawn));
  }

  /// Signals that go through texts or letters look for another way. @return whether one has found it.
  bool reroute_signals() {
    bool changed = false;
    for (std::size_t i = 0; i < scene_.signals.size(); ++i) {
      DrawnSignal& drawn = scene_.signals[i];
      if (taken_.crossed(drawn.line, kLight) == 0.0) continue;
      labels_.drop(signal_labels_[i]);
      taken_.remove(signal_items_[i]);
      drawn.line = signal_way(drawn.signal);
      signal_items_[i] = take_signal(drawn.line);
      signal_labels_[i] = add_signal_label(drawn);
      changed = true;
    }
    return changed;
  }

  // --- frames ---

  /// The frame that holds both: "a.b." of "a.b.c." and "a.b.d.e.".
  static std::string common_scope(const std::string& a, const std::string& b) {
    std::size_t same = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()) && a[i] == b[i]; ++i)
      if (a[i] == '.') same = i + 1;
    return a.substr(0, same);
  }

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
      include(scope, labels_[names_[i]].box);
    }
    for (std::size_t i = 0; i < model_.bonds.size(); ++i)
      include(scope_of(model_.bonds[i].name), around(scene_.bonds[i].line.at(0.5), 1.0, 1.0));
    for (std::size_t i = 0; i < scene_.signals.size(); ++i) {
      const ReadSignal& signal = scene_.signals[i].signal;
      const std::string from =
          signal.from.valid() ? model_.elements[signal.from.index()].name : model_.bonds[signal.from_bond.index()].name;
      const std::string scope = common_scope(scope_of(from), scope_of(model_.elements[signal.to.index()].name));
      for (const double s : {0.25, 0.5, 0.75})
        include(scope, grown(around(scene_.signals[i].line.at(s), 2.0, 2.0), -6.0));
      include(scope, grown(labels_[signal_labels_[i]].box, -6.0));
    }
    for (const auto& [scope, box] : inside) place_frame(scope, box);
    find_frame_trouble();
  }

  void place_frame(const std::string& scope, const Box& box) {
    const std::string name = local_name(scope.substr(0, scope.size() - 1));
    const auto text = [&](double x, Anchor anchor) {
      return text_at({x, box.low.y + 10.0}, anchor, kNameSize, name, {}, Face::bold);
    };
    DrawnFrame frame{scope, box, text(box.low.x + 8.0, Anchor::start)};
    frame.box.high.x = std::max(frame.box.high.x, frame.name.box.high.x + 8.0);
    const Box& at = frame.box;
    frame_names_.push_back(labels_.add({{frame.name, 0.0},
                                        {text(at.high.x - 8.0, Anchor::end), 20.0},
                                        {text((at.low.x + at.high.x) / 2, Anchor::middle), 25.0}}));
    // Texts keep off the border.
    for (const double y : {at.low.y, at.high.y})
      taken_.add(Box{{at.low.x, y - 0.5}, {at.high.x, y + 0.5}}, kLineWeight);
    for (const double x : {at.low.x, at.high.x})
      taken_.add(Box{{x - 0.5, at.low.y}, {x + 0.5, at.high.y}}, kLineWeight);
    scene_.frames.push_back(std::move(frame));
  }

  /// Frames that have grown over what is not theirs.
  void find_frame_trouble() {
    constexpr std::size_t kMost = 1000000;  // pairs that are looked at
    if (scene_.frames.size() * model_.elements.size() > kMost) return;
    for (const DrawnFrame& frame : scene_.frames)
      for (std::size_t i = 0; i < model_.elements.size(); ++i) {
        if (model_.elements[i].name.starts_with(frame.scope)) continue;
        trouble_ += kTextWeight * shared_area(letter_box(i), frame.box);
      }
    for (const DrawnFrame& a : scene_.frames)
      for (const DrawnFrame& b : scene_.frames)
        if (a.scope < b.scope && !b.scope.starts_with(a.scope)) trouble_ += shared_area(a.box, b.box);
  }

  // --- the end ---

  void take_texts() {
    trouble_ += labels_.covered();
    for (std::size_t i = 0; i < model_.elements.size(); ++i) scene_.elements[i].name = labels_[names_[i]];
    for (std::size_t i = 0; i < model_.bonds.size(); ++i) {
      for (const std::size_t label : bond_texts_[i].ports) scene_.bonds[i].ports.push_back(labels_[label]);
      for (const std::size_t label : bond_texts_[i].names) scene_.bonds[i].names.push_back(labels_[label]);
    }
    for (std::size_t i = 0; i < scene_.frames.size(); ++i) scene_.frames[i].name = labels_[frame_names_[i]];
    for (std::size_t i = 0; i < scene_.signals.size(); ++i) {
      scene_.signals[i].label = labels_[signal_labels_[i]];
      trouble_ += kTextWeight * taken_.crossed(scene_.signals[i].line, kLight);
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
  Labels labels_{taken_};
  struct BondTexts {
    std::vector<std::size_t> ports, names;
  };
  std::vector<std::size_t> names_, signal_labels_, frame_names_;  // numbers of labels
  std::vector<BondTexts> bond_texts_;
  std::vector<Taken::Range> signal_items_;
  double trouble_ = 0.0;
};

}  // namespace

DrawnScene place_all(const Model& model, const DrawnCausality& causality, const Layout& layout,
                     const DrawingOptions& options) {
  // Long names and many signals need more room than Graphviz was asked for; mostly it is the width that is missing.
  constexpr std::array<Point, 7> kStretches{
      {{1.0, 1.0}, {1.15, 1.0}, {1.15, 1.15}, {1.3, 1.15}, {1.45, 1.3}, {1.7, 1.6}, {2.0, 2.0}}};
  constexpr std::size_t kMost = 1000;  // beyond, nobody reads names without enlarging the picture
  constexpr double kRoom = 20.0;       // trouble that is not worth a larger picture
  DrawnScene best;
  double least = std::numeric_limits<double>::infinity();
  for (const Point stretch : kStretches) {
    Layout stretched = layout;
    for (Point& at : stretched.elements) at = {stretch.x * at.x, stretch.y * at.y};
    Placing placing(model, causality, stretched, options);
    DrawnScene scene = placing.run();
    const double cost = (placing.trouble() + kRoom) * stretch.x * stretch.y;
    if (cost < least) {
      least = cost;
      best = std::move(scene);
    }
    if (placing.trouble() < 1.0 || model.elements.size() > kMost) break;
  }
  return best;
}

}  // namespace bgsim
