/// Any bytes: they are refused with a place inside them, or are an expression that survives everything done to it and
/// whose text reads back as the same expression.
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "expression/time_event.hpp"
#include "support/expression_world.hpp"

using namespace bgsim;

namespace {

void demand(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

void check_place(const ExpressionError& fault, std::string_view text) {
  demand(fault.begin <= fault.end && fault.end <= text.size(), "a fault lies outside the text");
  demand(fault.code.size() == 5 && fault.what()[0] != '\0', "a fault has no code or no message");
}

void use(test::World& world, ExprId e) {
  const std::vector<double> values{0.5, 1.5, -2.0, 0.0, 0.25, 3.0, 1e-3};
  static_cast<void>(world.value(e, values));
  try {
    for (const auto& [symbol, slope] : gradient(world.pool, e, [](SymbolId) { return true; }))
      evaluate(world.pool, slope, values);
  } catch (const std::invalid_argument&) {  // der, or a third derivative of data
  }
  const ExprId other = world.symbol("R_b");
  invert(world.pool, e, world.id("x"), other);
  linear_in(world.pool, e, world.id("x"));
  substitute(world.pool, e, {{world.id("x"), other}});
  for (const ExprId id : reachable(world.pool, {&e, 1})) {
    const Op op = world.pool[id].op;
    if (op != Op::lt && op != Op::floor && op != Op::ceil && op != Op::round) continue;
    next_change(world.pool, id, world.id("t"), values, 0.0, 1.0);
    break;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const test::World prototype;  // interpolating its tables takes longer than all the rest
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  test::World world = prototype;
  try {
    split_law(text);
  } catch (const ExpressionError& fault) {
    check_place(fault, text);
  }
  ExprId e;
  try {
    e = world.parse(text);
  } catch (const ExpressionError& fault) {
    check_place(fault, text);
    return 0;
  }
  try {
    const std::string written = world.text(e);
    demand(world.parse(written) == e, written.c_str());
    static_cast<void>(world.latex(e));
  } catch (const std::length_error&) {  // it shares too much to be written out
  }
  use(world, e);
  return 0;
}
