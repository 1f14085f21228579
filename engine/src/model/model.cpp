#include "bgsim/model.hpp"

namespace bgsim {

char letter(Variable variable) {
  switch (variable) {
    case Variable::effort:
      return 'e';
    case Variable::flow:
      return 'f';
    case Variable::displacement:
      return 'q';
    case Variable::momentum:
      return 'p';
  }
  return '?';
}

std::size_t port_count(const Element& element) { return element.ports.size(); }

std::string port_name(const Element& element, std::size_t port) {
  if (element.ports.size() < 2) return element.name;
  return element.name + "." + element.ports[port];
}

SymbolId port_variable(const Element& element, std::size_t port, Variable variable) {
  if (is_junction(element.kind)) return element.first_symbol;
  const std::size_t stride = is_store(element.kind) ? 3 : 2;
  const std::size_t offset = variable == Variable::effort ? 0 : variable == Variable::flow ? 1 : 2;
  return SymbolId(element.first_symbol.index() + port * stride + offset);
}

std::string symbol_name(const Model& model, SymbolId symbol) {
  const ModelSymbol& s = model.symbols[symbol.index()];
  switch (s.kind) {
    case ModelSymbol::Kind::time:
      return "t";
    case ModelSymbol::Kind::parameter:
      return model.parameters[s.parameter.index()].name;
    case ModelSymbol::Kind::signal:
      return model.signals[s.signal.index()].name;
    case ModelSymbol::Kind::port_variable: {
      const Element& element = model.elements[s.element.index()];
      const std::string name = is_junction(element.kind) ? element.name : port_name(element, s.port);
      return name + "." + letter(s.variable);
    }
    case ModelSymbol::Kind::bond_variable:
      return model.bonds[s.bond.index()].name + "." + letter(s.variable);
    case ModelSymbol::Kind::mode:
      return "mode('" + model.elements[s.element.index()].name + "')";
  }
  return {};
}

}  // namespace bgsim
