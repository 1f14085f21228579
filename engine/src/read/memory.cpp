/// Signals with memory: "every" (sample and hold) and "set", "reset" (latch). Each is an integral of 0, a state that
/// nothing moves, and events that set it. So dense output, snapshots and the known times of samples need nothing new.
#include <algorithm>
#include <array>

#include "base/dependence.hpp"
#include "base/strong_parts.hpp"
#include "model/samples.hpp"
#include "read/reader.hpp"

namespace bgsim {

bool Reader::is_memory(const Document& file, NodeId node) const {
  if (file[node].kind != JsonKind::object) return false;
  const std::vector<NodeId> children = file.children(node);
  return std::any_of(children.begin(), children.end(), [&](NodeId child) {
    const std::string_view key = file[child].key;
    return key == "every" || key == "offset" || key == "set" || key == "reset";
  });
}

void Reader::declare_memory(std::size_t scope, NodeId node) {
  const Document& file = document(scopes_[scope]);
  if (file.find(node, "every").valid() || file.find(node, "offset").valid())
    declare_sampled(scope, node);
  else
    declare_latch(scope, node);
}

/// The state behind a signal with memory. Its index among the signals.
std::size_t Reader::declare_state(std::size_t scope, NodeId node, NodeId initial) {
  const Document& file = document(scopes_[scope]);
  const std::string unit = text_of(file, node, "unit");
  text_of(file, node, "source");
  const std::size_t index = model_.signals.size();
  ModelSymbol symbol;
  symbol.kind = ModelSymbol::Kind::signal;
  symbol.signal = SignalId(index);
  const auto names = static_cast<std::uint32_t>(scope);
  signal_text_.push_back({{names, {}}, {names, initial}});
  Signal signal;
  signal.name = scopes_[scope].prefix + std::string(file[node].key);
  signal.value = model_.pool.constant(0.0);
  signal.symbol = add_symbol(symbol);
  signal.unit = unit;
  signal.about = text_of(file, node, "about");
  signal.place = file.key_place(node);
  if (!unit.empty()) signal.unit_place = file.place(file.find(node, "unit"));
  signal.kind = Signal::Kind::integral;
  if (initial.valid()) signal.initial_place = file.place(initial);
  model_.signals.push_back(std::move(signal));
  return index;
}

/// { value, every, offset, initial }.
void Reader::declare_sampled(std::size_t scope, NodeId node) {
  static constexpr std::array<std::string_view, 7> kKeys{"value", "every", "offset", "initial",
                                                         "unit",  "about", "source"};
  const Document& file = document(scopes_[scope]);
  const std::string name(file[node].key);
  check_keys(file, node, kKeys, "a sampled signal");
  const NodeId value = file.find(node, "value"), every = file.find(node, "every");
  if (!value.valid())
    missing(file, node, "the sampled signal " + in_quotes(name) + " has no \"value\"", file.key_place(node),
            "add \"value\": what it takes over at each sample");
  if (!every.valid())
    missing(file, node, "the sampled signal " + in_quotes(name) + " has no \"every\"", file.key_place(node),
            "add \"every\": the time between two samples");
  const auto index = static_cast<std::uint32_t>(model_.signals.size());
  if (!claim(scopes_[scope].prefix + name, {Entity::Kind::signal, index, file.key_place(node)})) return;
  Memory memory;
  memory.signal = SignalId(declare_state(scope, node, file.find(node, "initial")));
  memory.names = static_cast<std::uint32_t>(scope);
  memory.value = value;
  memory.every = every;
  memory.offset = file.find(node, "offset");
  if (value.valid() && every.valid()) memories_.push_back(memory);
}

/// { set, reset, initial }: a condition that remembers.
void Reader::declare_latch(std::size_t scope, NodeId node) {
  static constexpr std::array<std::string_view, 5> kKeys{"set", "reset", "initial", "about", "source"};
  const Document& file = document(scopes_[scope]);
  const std::string name(file[node].key);
  check_keys(file, node, kKeys, "a latch");
  Memory memory;
  memory.names = static_cast<std::uint32_t>(scope);
  memory.set = file.find(node, "set");
  memory.reset = file.find(node, "reset");
  for (const bool sets : {true, false})
    if (const std::string key = sets ? "set" : "reset"; !(sets ? memory.set : memory.reset).valid())
      missing(file, node, "the latch " + in_quotes(name) + " has no " + in_quotes(key), file.key_place(node),
              "add " + in_quotes(key) + ": the condition that makes it " + (sets ? "true" : "false"));
  const NodeId initial = file.find(node, "initial");
  const bool known = !initial.valid() || expect(file, initial, JsonKind::boolean, "\"initial\" of a latch");
  const auto index = static_cast<std::uint32_t>(conditions_.size());
  if (!claim(scopes_[scope].prefix + name, {Entity::Kind::condition, index, file.key_place(node)})) return;
  memory.signal = SignalId(declare_state(scope, node, {}));
  Signal& signal = model_.signals[memory.signal.index()];
  signal.unit = "1";
  const bool begins = known && initial.valid() && file[initial].boolean;
  signal.initial = model_.pool.constant(begins ? 1.0 : 0.0);
  ConditionSignal side{{static_cast<std::uint32_t>(scope), {}}, file.key_place(node), signal.name};
  side.id = model_.pool.make(Op::gt, model_.pool.symbol(signal.symbol), model_.pool.constant(0.5));
  side.begun = side.latch = true;
  conditions_.push_back(side);
  if (memory.set.valid() && memory.reset.valid()) memories_.push_back(memory);
}

/// The memory behind a symbol.
std::optional<std::size_t> Reader::memory_of(SymbolId symbol) const {
  const ModelSymbol& meaning = model_.symbols[symbol.index()];
  if (meaning.kind != ModelSymbol::Kind::signal) return std::nullopt;
  for (std::size_t i = 0; i < memories_.size(); ++i)
    if (memories_[i].signal == meaning.signal) return i;
  return std::nullopt;
}

/// previous(u): a state of its own, which takes over u just before each sample.
std::optional<ExprId> Reader::previous(ExprId x) {
  if (!model_.pool.is_symbol(x)) return std::nullopt;
  const auto found = memory_of(model_.pool.symbol_of(x));
  if (!found || !memories_[*found].value.valid()) return std::nullopt;
  Memory& memory = memories_[*found];
  if (!memory.previous.valid()) {
    memory.previous = SignalId(model_.signals.size());
    ModelSymbol symbol;
    symbol.kind = ModelSymbol::Kind::signal;
    symbol.signal = memory.previous;
    Signal before = model_.signals[memory.signal.index()];
    before.name = "previous(" + before.name + ")";
    before.symbol = add_symbol(symbol);
    model_.signals.push_back(std::move(before));
  }
  return model_.pool.symbol(model_.signals[memory.previous.index()].symbol);
}

void Reader::parse_memories() {
  for (Memory& memory : memories_) {
    const Context context{memory.names, nullptr, nullptr};
    const Document& file = document(scopes_[memory.names]);
    if (memory.set.valid()) {
      memory.sets = condition(context, memory.set, "\"set\"");
      memory.resets = condition(context, memory.reset, "\"reset\"");
      continue;
    }
    memory.target = expression(context, memory.value, "a signal");
    const Context constant{memory.names, nullptr, "a sampling time"};
    const ExprId every = expression(constant, memory.every, "\"every\"");
    const ExprId offset =
        memory.offset.valid() ? expression(constant, memory.offset, "\"offset\"") : model_.pool.constant(0.0);
    Signal& signal = model_.signals[memory.signal.index()];
    signal.every = every;
    signal.offset = offset;
    signal.every_place = file.place(memory.every);
  }
}

/// Which memories some expressions depend on, directly or through signals.
std::vector<std::size_t> Reader::memories_in(std::initializer_list<ExprId> expressions) const {
  std::vector<std::size_t> found;
  std::vector<char> seen(model_.signals.size(), 0);
  std::vector<ExprId> open;
  for (const ExprId id : expressions)
    if (id.valid()) open.push_back(id);
  while (!open.empty()) {
    const ExprId id = open.back();
    open.pop_back();
    for (const SymbolId symbol : symbols_in(model_.pool, std::array{id})) {
      const ModelSymbol& meaning = model_.symbols[symbol.index()];
      if (meaning.kind != ModelSymbol::Kind::signal || seen[meaning.signal.index()] != 0) continue;
      seen[meaning.signal.index()] = 1;
      if (const auto memory = memory_of(symbol))
        found.push_back(*memory);
      else if (const Signal& signal = model_.signals[meaning.signal.index()];
               !signal.is_state() && signal.value.valid())
        open.push_back(signal.value);
    }
  }
  return found;
}

/// At one instant each after those that it depends on. Latches may depend on each other in a circle, also by way of
/// samples: these come as they are declared. What is sampled may not depend on itself (BG132).
std::vector<std::size_t> Reader::order_of_memories() {
  std::vector<std::vector<std::uint32_t>> depends_on;
  for (const Memory& memory : memories_) {
    const std::vector<std::size_t> others = memories_in({memory.target, memory.sets, memory.resets});
    depends_on.emplace_back(others.begin(), others.end());
  }
  const auto sampled = [&](std::size_t i) { return memories_[i].value.valid(); };
  const auto samples = [&](std::size_t i) {
    std::vector<std::uint32_t> others = sampled(i) ? depends_on[i] : std::vector<std::uint32_t>{};
    std::erase_if(others, [&](std::uint32_t other) { return !sampled(other); });
    return others;
  };
  const Dependence among_samples = order_by_dependence(memories_.size(), samples);
  for (const std::vector<std::size_t>& cycle : among_samples.cycles) {
    std::string chain;
    for (const std::size_t i : cycle) chain += model_.signals[memories_[i].signal.index()].name + " -> ";
    const Signal& first = model_.signals[memories_[cycle.front()].signal.index()];
    problem("BG132", "samples of one instant depend on each other: " + chain + first.name, first.place,
            "write previous(" + first.name + ") for the value before the sample",
            "samples of one instant are taken one after the other");
  }
  // A part is a circle, or one memory; within a circle only samples wait for others.
  const StrongParts parts = strong_parts(depends_on);
  std::vector<std::size_t> order = among_samples.order;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return parts.part_of[a] < parts.part_of[b]; });
  return order;
}

/// The events behind the memories. At one instant they come after the events of the file: first what previous() is,
/// then each memory after those that it depends on.
void Reader::add_memory_events() {
  if (memories_.empty()) return;
  double lowest = 0.0;
  for (const ModelEvent& event : model_.events) lowest = std::min(lowest, event.priority);
  const double first = lowest - 1.0;
  double priority = first;
  for (const std::size_t i : order_of_memories()) {
    priority -= 1.0;
    const Memory& memory = memories_[i];
    if (memory.value.valid())
      add_samples(memory, priority, first);
    else
      add_latch(memory, priority);
  }
}

void Reader::add_samples(const Memory& memory, double priority, double first) {
  ExprPool& pool = model_.pool;
  Signal& signal = model_.signals[memory.signal.index()];
  if (!memory.target.valid() || !signal.every.valid() || !signal.offset.valid()) return;
  // Each sample is where t, counted from the offset, passes a multiple; half an interval later the event is armed
  // again. A record at n every is off by the rounding of that product, to either side, and shall show the sample. So
  // samples come some roundings of t early.
  const ExprId since = pool.sub(pool.mul(pool.symbol(model_.time), pool.constant(kSamplesEarly)), signal.offset);
  const ExprId phase = pool.make(Op::mod, since, signal.every);
  ExprId when = pool.make(Op::lt, phase, pool.mul(pool.constant(0.5), signal.every));
  if (memory.offset.valid()) when = pool.make(Op::logical_and, pool.make(Op::ge, since, pool.constant(0.0)), when);
  const Document& file = document(scopes_[memory.names]);
  ModelEvent event;
  event.name = signal.name;
  event.when = when;
  event.sets.push_back({{}, 0, memory.signal, memory.target, file.place(memory.value), signal.place});
  event.priority = priority;
  event.place = signal.place;
  event.when_place = signal.every_place;
  event.at_start = true;
  event.sampled = memory.signal;
  if (memory.previous.valid()) {
    model_.signals[memory.previous.index()].initial = signal.initial;
    ModelEvent shift = event;
    shift.name = "previous(" + signal.name + ")";
    shift.priority = first;
    shift.sets = {{{}, 0, memory.previous, pool.symbol(signal.symbol), signal.place, signal.place}};
    model_.events.push_back(std::move(shift));
  }
  model_.events.push_back(std::move(event));
}

/// Where both hold, "reset" wins. At the start both take place, one after the other.
void Reader::add_latch(const Memory& memory, double priority) {
  if (!memory.sets.valid() || !memory.resets.valid()) return;
  ExprPool& pool = model_.pool;
  const Signal& signal = model_.signals[memory.signal.index()];
  const Document& file = document(scopes_[memory.names]);
  for (const bool sets : {true, false}) {
    ModelEvent event;
    event.name = signal.name + (sets ? " (set)" : " (reset)");
    event.when =
        sets ? pool.make(Op::logical_and, memory.sets, pool.make(Op::logical_not, memory.resets)) : memory.resets;
    event.when_place = file.place(sets ? memory.set : memory.reset);
    // At the start the condition may not hold.
    const ExprId value = pool.select(event.when, pool.constant(sets ? 1.0 : 0.0), pool.symbol(signal.symbol));
    event.sets.push_back({{}, 0, memory.signal, value, event.when_place, signal.place});
    event.priority = sets ? priority : priority - 0.5;
    event.place = signal.place;
    event.at_start = true;
    model_.events.push_back(std::move(event));
  }
}

}  // namespace bgsim
