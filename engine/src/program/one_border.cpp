#include "program/one_border.hpp"

#include <algorithm>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "expression/border.hpp"
#include "expression/graph.hpp"
#include "model/element_kinds.hpp"
#include "program/rewritten.hpp"

namespace bgsim {
namespace {

bool is_of_resistor(const Model& model, const BlockOrder& order, ExprId e) {
  const ElementId element = order.origins[e.index()].element;
  return element.valid() && is_resistor(model.elements[element.index()].kind);
}

/// Of a resistor or of a signal, which laws may follow.
bool is_of_laws(const Model& model, const BlockOrder& order, ExprId e) {
  return order.origins[e.index()].signal.valid() || is_of_resistor(model, order, e);
}

class OneBorder {
 public:
  OneBorder(const Model& model, const EquationSystem& system, const BlockOrder& order)
      : model_(model), system_(system), made_(order) {
    for (const std::vector<SymbolId>* const symbols : {&system.efforts, &system.flows})
      for (std::size_t i = 0; i < symbols->size(); ++i)
        if (const ExprId value = made_.resolved[(*symbols)[i].index()]; value.valid())
          for (const ElementId element : {model.bonds[i].from.element, model.bonds[i].to.element})
            bonds_[value].push_back(element);
    const std::size_t size = made_.pool.size();
    image_.reserve(size);
    for (std::size_t i = 0; i < size; ++i) {
      const ExprId e(i);
      note(e);
      // A relation that a law gets is that of the law.
      made_.origins.resize(made_.pool.size(), Origin(made_.origins[i]));
      ExprId image = with_images(made_, e, image_);
      const std::vector<Said> said = said_[i];
      if (std::any_of(said.begin(), said.end(), [](const Said& of) { return of.bent; }))
        image = by_one_border_each(e, said, image);
      changed_ = changed_ || image != e;
      made_.origins.resize(made_.pool.size(), Origin(made_.origins[i]));
      image_.push_back(image);
    }
  }

  [[nodiscard]] bool changed() const { return changed_; }
  BlockOrder take() && {
    replace_by_images(made_, image_);
    return std::move(made_);
  }

 private:
  /// A border of a law.
  struct Said {
    ExprId guard;
    ExprId border;      ///< one of this guard
    bool bent = false;  ///< the law is no straight line over the mode of that one
  };

  void note(ExprId e) {
    const ExprNode node = made_.pool[e];  // a copy: the pool grows
    Follows follows;
    if (node.op == Op::symbol && node.a < system_.symbols.size()) {
      const SystemSymbol::Kind kind = system_.symbols[node.a].kind;
      follows = {kind == SystemSymbol::Kind::state, kind == SystemSymbol::Kind::unknown};
    }
    for_each_argument(node, [&](ExprId a) {
      follows.state = follows.state || follows_[a.index()].state;
      follows.loop = follows.loop || follows_[a.index()].loop;
    });
    follows_.push_back(follows);
    said_.emplace_back();
    if (!follows.state || !is_of_laws(model_, made_, e)) return;
    if (!is_border(node.op))
      said_.back() = said_by_arguments(e);
    else if (!follows.loop)
      said_.back().push_back({guard_of(made_.pool, node).at, e});
  }

  /// Borders of what an element is connected with are none of its law: a series of laws is no straight line over the
  /// mode of the first. Two resistors may have a border in common.
  [[nodiscard]] bool is_of_law(ExprId e, ExprId argument) const {
    const auto at = bonds_.find(argument);
    if (at == bonds_.end()) return true;
    const ElementId own = made_.origins[e.index()].element;
    const bool is_own = std::find(at->second.begin(), at->second.end(), own) != at->second.end();
    return !is_own && is_border(made_.pool[argument].op);
  }

  [[nodiscard]] std::vector<Said> said_by_arguments(ExprId e) const {
    const ExprNode& node = made_.pool[e];
    std::vector<Said> said;
    std::vector<int> arguments;  // with that guard
    for_each_argument(node, [&](ExprId a) {
      if (!is_of_law(e, a)) return;
      for (const Said& of : said_[a.index()]) {
        std::size_t k = 0;
        while (k < said.size() && said[k].guard != of.guard) ++k;
        if (k == said.size()) {
          said.push_back({of.guard, of.border});
          arguments.push_back(0);
        }
        ++arguments[k];
        said[k].bent = said[k].bent || of.bent || said[k].border != of.border;
      }
    });
    const auto among = [this](std::uint32_t argument, ExprId guard) {
      const std::vector<Said>& of = said_[argument];
      return std::any_of(of.begin(), of.end(), [guard](const Said& at) { return at.guard == guard; });
    };
    const bool of_resistor = is_of_resistor(model_, made_, e);
    constexpr std::size_t kMost = 64;  // lists in a logic of thousands of signals would be as long as it is
    if (!of_resistor && said.size() > kMost) return {};
    for (std::size_t k = 0; k < said.size(); ++k) {
      bool straight = false;
      if (node.op == Op::add || node.op == Op::sub || node.op == Op::neg) straight = true;
      if (node.op == Op::mul) straight = arguments[k] == 1;
      if (node.op == Op::div) straight = !among(node.b, said[k].guard);
      // One of two sides is in force, or a condition chooses between what does not have its guard.
      if (node.op == Op::select) straight = arguments[k] == 1 || !among(node.a, said[k].guard);
      // A relation of a signal is none that a law could hold.
      const bool held = !of_resistor || is_of_resistor(model_, made_, said[k].border);
      said[k].bent = said[k].bent || !straight || !held;
    }
    return said;
  }

  /// @p image where nothing is changed.
  ExprId by_one_border_each(ExprId e, const std::vector<Said>& said, ExprId image) {
    if (is_logical(made_.pool[e].op) || !is_of_resistor(model_, made_, e)) return image;
    ExprId made = e;
    for (const Said& of : said)
      if (of.bent) made = by_one_border(made, of.guard);
    return made == e ? image : made;
  }

  /// As it is where both sides go on with one value.
  ExprId by_one_border(ExprId e, ExprId guard) {
    ExprPool& pool = made_.pool;
    const ExprId below = on_side(pool, e, guard, -1), at = on_side(pool, e, guard, 0),
                 above = on_side(pool, e, guard, 1);
    if (meet(pool, below, above, guard)) return e;
    const ExprId zero = pool.constant(0.0);
    const ExprId sign = pool.make(Op::sign, guard), is_above = pool.make(at == above ? Op::ge : Op::gt, guard, zero),
                 is_below = pool.make(at == above ? Op::lt : Op::le, guard, zero);
    if (pool.neg(above) == below && pool.is_constant(at, 0.0) && may_be_held(sign)) return pool.mul(above, sign);
    return may_be_held(is_above) ? pool.select(is_above, above, below) : pool.select(is_below, below, above);
  }

  /// Not where a signal has the same relation.
  [[nodiscard]] bool may_be_held(ExprId relation) const {
    return relation.index() >= made_.origins.size() || is_of_resistor(model_, made_, relation);
  }

  const Model& model_;
  const EquationSystem& system_;
  BlockOrder made_;
  struct Follows {
    bool state = false, loop = false;  ///< a state, an unknown of a loop
  };
  std::unordered_map<ExprId, std::vector<ElementId>> bonds_;  ///< efforts and flows of bonds: between which elements
  std::vector<Follows> follows_;                              ///< by ExprId
  std::vector<std::vector<Said>> said_;                       ///< by ExprId
  std::vector<ExprId> image_;                                 ///< by ExprId
  bool changed_ = false;
};

}  // namespace

std::optional<BlockOrder> with_one_border(const Model& model, const EquationSystem& system, const BlockOrder& order) {
  bool any = false;
  for (std::size_t i = 0; i < order.pool.size() && !any; ++i)
    any = is_border(order.pool[ExprId(i)].op) && is_of_laws(model, order, ExprId(i));
  if (!any) return std::nullopt;
  OneBorder laws(model, system, order);
  if (!laws.changed()) return std::nullopt;
  return std::move(laws).take();
}

}  // namespace bgsim
