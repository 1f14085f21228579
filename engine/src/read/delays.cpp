/// Signals that are delayed: y(t) = u(t - by). In expressions y is a table over the time since the start, which the run
/// fills. That time is a state of its own, so that nobody takes y for something that is known beforehand.
#include <algorithm>
#include <array>

#include "read/reader.hpp"

namespace bgsim {

bool Reader::is_delay(const Document& file, NodeId node) const {
  return file[node].kind == JsonKind::object && (file.find(node, "delay").valid() || file.find(node, "by").valid());
}

/// { delay, by, initial }.
void Reader::declare_delay(std::size_t scope, NodeId node) {
  static constexpr std::array<std::string_view, 6> kKeys{"delay", "by", "initial", "unit", "about", "source"};
  const Document& file = document(scopes_[scope]);
  const std::string name(file[node].key);
  check_keys(file, node, kKeys, "a delayed signal");
  const NodeId delay = file.find(node, "delay"), by = file.find(node, "by");
  if (!delay.valid())
    missing(file, node, "the delayed signal " + in_quotes(name) + " has no \"delay\"", file.key_place(node),
            "add \"delay\": what it was \"by\" earlier");
  if (!by.valid())
    missing(file, node, "the delayed signal " + in_quotes(name) + " has no \"by\"", file.key_place(node),
            "add \"by\": by how much it is late");
  const auto index = static_cast<std::uint32_t>(model_.signals.size());
  if (!claim(scopes_[scope].prefix + name, {Entity::Kind::signal, index, file.key_place(node)})) return;
  const std::size_t signal = declare_state(scope, node, {});
  model_.signals[signal].kind = Signal::Kind::value;
  model_.signals[signal].place = file.place(delay.valid() ? delay : node);
  if (!delay.valid() || !by.valid()) return;
  delays_.push_back({SignalId(signal), static_cast<std::uint32_t>(scope), delay, by, file.find(node, "initial")});
}

void Reader::parse_delays() {
  if (delays_.empty()) return;
  ModelSymbol symbol;
  symbol.kind = ModelSymbol::Kind::signal;
  symbol.signal = SignalId(model_.signals.size());
  Signal clock;
  clock.name = "(time since the start)";
  clock.kind = Signal::Kind::integral;
  clock.value = model_.pool.constant(1.0);
  clock.initial = model_.pool.constant(0.0);
  clock.symbol = add_symbol(symbol);
  clock.place = model_.signals[delays_.front().signal.index()].place;
  const ExprId time = model_.pool.symbol(clock.symbol);
  model_.signals.push_back(clock);
  for (const DelayText& text : delays_) {
    const Context context{text.names, nullptr, nullptr};
    const Document& file = document(scopes_[text.names]);
    Signal::Delay delay;
    delay.clock = symbol.signal;
    delay.value = expression(context, text.value, "\"delay\"");
    delay.by = expression({text.names, nullptr, "a delay"}, text.by, "\"by\"");
    delay.by_place = file.place(text.by);
    if (text.initial.valid()) {
      delay.initial = expression(context, text.initial, "\"initial\"");
      delay.initial_place = file.place(text.initial);
    }
    if (!delay.value.valid() || !delay.by.valid()) continue;
    Table table;
    table.column = model_.signals[text.signal.index()].name;
    table.interpolation = Interpolation::spline;
    table.delayed = true;
    table.x = {-1.0, 0.0};
    table.y = table.slope2 = {0.0, 0.0};
    table.last = 1;
    delay.table = model_.pool.add_table(std::move(table));
    Signal& signal = model_.signals[text.signal.index()];
    signal.value = model_.pool.table(Op::table, model_.pool.sub(time, delay.by), delay.table);
    signal.delay = delay;
  }
}

/// What was before the start is known at the start.
void Reader::check_delays() {
  for (const Signal& signal : model_.signals)
    if (signal.delay && signal.delay->initial.valid() && variation(signal.delay->initial) == Varies::with_state)
      problem("BG118", "what the delayed signal " + in_quotes(signal.name) + " was before the start depends on states",
              signal.delay->initial_place, "write an expression of t and parameters",
              "\"initial\" of a delayed signal is what it was before the start");
}

}  // namespace bgsim
