#include "expression/write/typeset.hpp"

#include "expression/graph.hpp"

namespace bgsim {

namespace {

class TypesetWriter : public ExpressionWriter {
 public:
  TypesetWriter(const ExprPool& pool, const SymbolName& name, const Typesetting& language)
      : ExpressionWriter(pool, name), language_(language) {}

 private:
  void begin(ExprId id, Binding least) override {
    const ExprNode& node = pool_[id];
    const Binding own = typeset_binding(node);
    if (own < least) {
      text_ += language_.open;
      push(language_.close);
    }
    const ExprId a(node.a), b(node.b), c(node.c);
    switch (node.op) {
      case Op::constant:
        text_ += language_.number(node.constant);
        return;
      case Op::symbol:
        text_ += language_.name(name_(SymbolId(node.a)));
        return;
      case Op::neg:
        text_ += language_.minus;
        push(a, Binding::product);
        return;
      case Op::logical_not:
        text_ += language_.negation;
        push(a, Binding::atom);
        return;
      case Op::pow:
        text_ += language_.power[0];
        push(language_.power[2]);
        push(b, Binding::none);
        push(language_.power[1]);
        push(a, Binding::atom);
        return;
      case Op::mul:
        product(id);
        return;
      case Op::select:
        text_ += language_.cases[0];
        push(language_.cases[3]);
        push(c, Binding::none);
        push(language_.cases[2]);
        push(a, Binding::none);
        push(language_.cases[1]);
        push(b, Binding::none);
        return;
      case Op::der:
        if (pool_.is_symbol(a))
          text_ += language_.name("der(" + name_(pool_.symbol_of(a)) + ")");
        else
          function(node);
        return;
      default:
        if (own == Binding::sum || is_logical(node.op))
          binary(id, own);
        else
          function(node);
    }
  }

  void binary(ExprId id, Binding own) {
    const auto [left, right] = written_order(pool_, id);
    push(right, stronger(own));
    push(language_.sign(pool_[id].op));
    push(left, own == Binding::comparison ? Binding::sum : own);
  }

  void product(ExprId id) {
    const auto [left, right] = written_order(pool_, id);
    // Before a factor that begins with a digit a thin space would be misread.
    const bool digits =
        pool_.is_constant(right) || (pool_[right].op == Op::pow && pool_.is_constant(ExprId(pool_[right].a)));
    const bool gather = pool_.is_constant(left) && pool_[right].op == Op::mul;
    push(right, gather ? Binding::product : Binding::power);
    push(digits ? language_.times : language_.thin);
    push(left, Binding::product);
  }

  void function(const ExprNode& node) {
    const TypesetForm form =
        is_table(node.op) ? language_.table(pool_.table(TableId(node.b)),
                                            static_cast<std::size_t>(node.op) - static_cast<std::size_t>(Op::table))
                          : language_.function(node.op);
    text_ += form.before;
    push(form.after);
    std::array<ExprId, 3> arguments;
    std::size_t n = 0;
    for_each_argument(node, [&](ExprId argument) { arguments[n++] = argument; });
    while (n-- > 0) {
      push(arguments[n], Binding::none);
      if (n > 0) push(form.between);
    }
  }

  const Typesetting& language_;
};

}  // namespace

std::string typeset(const ExprPool& pool, ExprId root, const SymbolName& name, const Typesetting& language,
                    Binding least) {
  return TypesetWriter(pool, name, language).write(root, least);
}

}  // namespace bgsim
