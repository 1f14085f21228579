/// Reading a model: first every name is declared, submodels unfolded where their elements stand; then every expression
/// is parsed in the scope it is written in, so that order in the file means nothing.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/document.hpp"
#include "base/text.hpp"
#include "bgsim/csv.hpp"
#include "bgsim/input_file.hpp"
#include "bgsim/model.hpp"
#include "bgsim/text.hpp"
#include "bgsim/unit.hpp"
#include "expression/parse.hpp"
#include "model/element_kinds.hpp"
#include "read/name_indices.hpp"

namespace bgsim {

/// One use of a file: the model itself, or a submodel in place of its element.
struct Scope {
  std::string prefix;  ///< "" or "left."
  DocumentId document;
  std::size_t parent = 0;  ///< scope of the instance
  NodeId instance;         ///< the instance's element in the parent's file; none for the model itself
  /// Of one copy of a repeated element: the same names as in the scope that declares it, and its indices i, j, k.
  IndexValues indices = {};
  std::optional<std::size_t> copy_in = {};  ///< that scope
};

/// Meaning of a full name.
struct Entity {
  enum class Kind : std::uint8_t { parameter, signal, condition, element, bond, instance, repeated } kind;
  std::uint32_t index;  ///< into the model's table; the scope for instances; the reader's table of what is repeated
  Place place;
};

/// Where the text of a declaration is.
struct Written {
  std::uint32_t names = 0;  ///< scope whose names the text uses (for overrides by an instance: the parent)
  NodeId value;             ///< JSON value in that scope's document
};

/// What an expression is for, which tells the names it may use.
struct Context {
  std::size_t scope = 0;
  const Element* own = nullptr;    ///< whose law or energy it is: its variables come first
  const char* constant = nullptr;  ///< set where only parameters may be used: what is computed, "an initial value"
  bool after_event = false;        ///< what an event sets: it may use pre(x)
};

class Reader {
 public:
  Reader(std::string path, const ReadOptions& options);
  Model read(std::string text);

 private:
  static constexpr std::size_t kMostProblems = 100;
  static constexpr std::size_t kMostSearched = 20'000;  ///< names for a suggestion, which is not worth more time

  // files (read_model.cpp)
  [[noreturn]] void give_up();
  DocumentId load(const std::string& path, std::optional<std::string> text, const std::optional<Place>& from);
  [[nodiscard]] const Document& document(DocumentId id) const { return (*sources_)[id.index()]; }
  [[nodiscard]] const Document& document(const Scope& scope) const { return document(scope.document); }
  DocumentId load_parameters(const std::string& path);
  DocumentId add_document(const std::string& path, std::string text, bool users = false);
  [[nodiscard]] std::string beside(DocumentId id, std::string_view file) const;
  [[nodiscard]] std::string submodel_file(DocumentId id, std::string_view file) const;
  bool is_model(DocumentId id);
  void check_root(const Scope& scope);
  void read_head();

  // problems and JSON helpers (reader_keys.cpp)
  void problem(const char* code, std::string situation, std::optional<Place> place, std::string help = {},
               std::string rule = {}, std::vector<Note> notes = {});
  /// Whether so many problems are known that the costly search for suggestions is not worth its time any more.
  [[nodiscard]] bool enough_problems() const { return problems_.size() >= kMostProblems; }
  void check_keys(const Document& file, NodeId object, std::span<const std::string_view> allowed,
                  const std::string& what, std::optional<ElementKind> kind = std::nullopt);
  /// A required key is missing; not reported for an object with an unknown key, which is probably that key misspelt.
  void missing(const Document& file, NodeId object, std::string situation, const Place& place, std::string help,
               std::string rule = {});
  bool expect(const Document& file, NodeId value, JsonKind kind, const std::string& what);
  std::string text_of(const Document& file, NodeId object, std::string_view key);
  NodeId section(const Scope& scope, std::string_view key, JsonKind kind);
  /// Whether a section of a file is there and is not what it has to be, which is reported: what it would declare is
  /// not missed.
  [[nodiscard]] bool unreadable(const Scope& scope, std::string_view key) const;
  bool valid_name(std::string_view name, const Place& place, const std::string& what);
  bool valid_title(std::string_view name, const Place& place, const std::string& what);

  // names of quantities, elements and submodels (reader_names.cpp)
  void declare_all();
  void begin_scope(std::size_t scope);
  void end_scope(std::size_t scope);
  bool claim(const std::string& full_name, const Entity& entity);
  void declare_quantities(std::size_t scope, bool signals);
  struct QuantityKeys {
    NodeId value, initial;  ///< none where not given
    Signal::Kind kind = Signal::Kind::value;
  };
  QuantityKeys quantity_keys(const Document& file, NodeId node, bool signal);
  void declare_element(std::size_t scope, NodeId node);
  bool read_ports(std::size_t scope, NodeId node, Element& element);
  void declare_junction_switch(std::size_t scope, NodeId node);
  void bond_junction_switches(std::size_t scope);
  void parse_junction_switch(std::size_t index);
  void add_element(std::size_t scope, NodeId node, Element element);
  SymbolId add_symbol(ModelSymbol symbol);

  // submodels (reader_submodels.cpp)
  struct Type {
    NodeId node;  ///< the file's name, in "types"
    DocumentId file;
    bool refused = false;  ///< there is something wrong with it, which is reported
  };
  struct Use {
    Type* type;
    double times;  ///< elements of that kind in the file
  };
  std::unordered_map<std::string_view, Type>& types_of(DocumentId id);
  std::vector<Use> uses_of(DocumentId id);
  void survey(DocumentId root);
  void declare_instance(std::size_t scope, NodeId node, std::string_view kind);
  void apply_overrides(std::size_t scope);
  void override_signal(std::size_t scope, std::uint32_t index, NodeId node);
  void override_condition(std::size_t scope, std::uint32_t index, NodeId node);
  void declare_exports(std::size_t scope);

  // elements and bonds that are repeated (read/repeat.cpp)
  struct Repeated {
    std::vector<std::int64_t> first, last;  ///< by dimension
  };
  using Counts = std::vector<std::int64_t>;  ///< by dimension
  std::optional<Counts> read_counts(const Document& file, NodeId repeat);
  [[nodiscard]] double copies_of(const Document& file, NodeId element) const;
  void declare_copies(std::size_t scope, NodeId node, NodeId repeat);
  void claim_repeated(const std::string& full_name, Repeated range, const Place& place);
  static Repeated range_of(const IndexValues& first, const IndexValues& last);
  [[nodiscard]] const Repeated* repeated(const std::string& full_name) const;
  [[nodiscard]] std::size_t declaring(std::size_t scope) const { return scopes_[scope].copy_in.value_or(scope); }
  std::optional<std::string> with_indices(const Context& context, std::string_view name);
  [[nodiscard]] std::string index_advice(std::size_t scope, std::string_view name) const;
  std::optional<std::vector<IndexValues>> copies_of_bond(std::size_t scope, NodeId node);
  struct BondIndices;
  bool read_bond_indices(std::size_t scope, NodeId value, BondIndices& indices);
  bool read_ranges(const Document& file, NodeId repeat, BondIndices& indices);

  // bonds (reader_bonds.cpp)
  struct BondText {
    NodeId node;
    IndexValues indices;  ///< of a repeated bond
  };
  void declare_bonds(std::size_t scope);
  std::vector<BondText> name_bonds(std::size_t scope, NodeId array);
  std::string automatic_name(std::size_t scope, std::size_t position);
  bool declare_bond_ends(std::size_t scope, const BondText& bond, std::size_t index);
  std::optional<BondEndText> bond_end(std::size_t scope, const BondText& bond, std::string_view key);
  std::optional<BondEndText> bond_end_at(std::size_t scope, NodeId value, std::string_view text);
  std::optional<BondEndText> inner_bond_end(std::size_t scope, NodeId value, std::string_view base,
                                            std::string_view port);
  std::optional<BondEndText> no_element(std::size_t scope, NodeId value, std::string_view base);

  // expressions (reader_expressions.cpp)
  ExprId expression(const Context& context, NodeId value, const std::string& what);
  using Parse = ExprId (*)(std::string_view, ExprPool&, const ExpressionScope&);
  ExprId parse(const Context& context, NodeId value, std::string_view text, std::size_t offset,
               Parse parse_text = parse_expression);
  ExprId condition(const Context& context, NodeId value, const std::string& what);
  void warn_of_left_out(const Place& place, ExprId kept, ExprId lost);
  bool only_parameters(const Context& context, NodeId value, ExprId expression);
  std::optional<ExprId> meaning(const Context& context, std::string_view name);
  std::optional<ExprId> meaning_of_plain(const Context& context, std::string_view name);
  std::optional<ExprId> quantity(const Context& context, const Entity& entity, std::string_view name);
  std::optional<ExprId> own_variable(const Context& context, std::string_view name);
  std::optional<SymbolId> variable_of(std::size_t scope, std::string_view base, char letter);
  std::optional<SymbolId> state_named(std::string_view name, bool or_conjugate);
  std::nullopt_t refuse(const char* code, std::string situation, std::string help, std::vector<Note> notes = {});
  [[nodiscard]] std::vector<std::string> known_names(const Context& context) const;
  SymbolId bond_symbol(BondId bond, Variable variable);
  [[nodiscard]] bool is_broken(std::size_t scope, std::string_view name) const;
  [[nodiscard]] bool perhaps_declared(std::size_t scope, std::string_view name) const;

  // what to write instead (reader_advice.cpp)
  void expression_fault(const Context& context, NodeId value, std::string_view text, std::size_t offset,
                        const ExpressionError& error);
  std::string unit_advice(const Context& context, NodeId value, std::string_view number, std::string_view unit);
  std::string name_advice(const Context& context, std::string_view name) const;
  [[nodiscard]] std::string law_advice(const Element& own, std::string_view name) const;
  [[nodiscard]] std::string law_without_equals(const Element& own, std::string_view text) const;
  [[nodiscard]] std::string initial_advice(const Element& own, std::string_view name, const std::string& owner) const;

  // measured data (reader_tables.cpp)
  const CsvTable& data_file(const std::string& path, const std::function<void(std::string, std::string)>& fail);
  TableId load_table(const Scope& scope, std::string_view text, std::string_view file, std::string_view column,
                     Interpolation interpolation);

  // elements (reader_elements.cpp)
  void parse_quantities();
  void parse_signal(std::size_t index);
  void parse_element(std::size_t index);
  std::optional<NodeId> chosen_way(std::size_t index);
  void parse_switch(std::size_t index, NodeId way);
  void parse_diode(std::size_t index);
  void parse_contact(std::size_t index);
  void declare_displacement(std::size_t scope, Element& element);
  void parse_energy(std::size_t index, NodeId value);
  void parse_laws(std::size_t index, NodeId value);
  void parse_law(std::size_t index, NodeId value);
  void warn_of_euler(std::size_t index, ExprId right, const Place& place);
  void parse_initial(std::size_t index, NodeId value);
  void parse_priority(std::size_t index, NodeId value);
  void parse_outputs(std::size_t scope);

  // signals that are conditions, and signals with memory (read/conditions.cpp, read/memory.cpp)
  /// A signal whose value is a condition. It stands for its text wherever it is used, and has no value in the trace.
  struct ConditionSignal {
    Written text;
    Place place;
    std::string name;    ///< full name
    ExprId id{};         ///< none until it is parsed
    bool begun = false;  ///< it is being parsed, or was
    bool latch = false;  ///< it stands for the side that a latch is on
  };
  /// A signal that remembers: an integral of 0 that an event sets.
  struct Memory {
    SignalId signal;
    std::uint32_t names = 0;            ///< scope whose names the texts use
    NodeId value, every, offset;        ///< of a sampled one; the last none if not given
    NodeId set, reset;                  ///< of a latch
    ExprId target{}, sets{}, resets{};  ///< the same, parsed
    SignalId previous{};                ///< its value before the last sample, where something asks for it
  };
  /// A delayed signal.
  struct DelayText {
    SignalId signal;
    std::uint32_t names = 0;    ///< scope whose names the texts use
    NodeId value, by, initial;  ///< the last none if not given
  };
  [[nodiscard]] bool is_delay(const Document& file, NodeId node) const;
  void declare_delay(std::size_t scope, NodeId node);
  void parse_delays();
  void check_delays();
  void declare_condition(std::size_t scope, NodeId node, NodeId value);
  std::optional<ExprId> condition_named(std::size_t index);
  [[nodiscard]] bool is_memory(const Document& file, NodeId node) const;
  void declare_memory(std::size_t scope, NodeId node);
  void declare_sampled(std::size_t scope, NodeId node);
  void declare_latch(std::size_t scope, NodeId node);
  std::size_t declare_state(std::size_t scope, NodeId node, NodeId initial);
  [[nodiscard]] std::optional<std::size_t> memory_of(SymbolId symbol) const;
  std::optional<ExprId> previous(ExprId x);
  void parse_memories();
  [[nodiscard]] std::vector<std::size_t> memories_in(std::initializer_list<ExprId> expressions) const;
  [[nodiscard]] std::vector<std::size_t> order_of_memories();
  void add_memory_events();
  void add_samples(const Memory& memory, double priority, double first);
  void add_latch(const Memory& memory, double priority);

  // events (read/events.cpp)
  void parse_events(std::size_t scope);
  void parse_event(std::size_t scope, NodeId node);
  void parse_sets(std::size_t scope, NodeId object, ModelEvent& event);
  std::optional<ModelEvent::Set> set_target(std::size_t scope, NodeId node);

  // what is said outside of the model's files (reader_options.cpp)
  void apply_options();
  void read_parameter_file(const std::string& path);
  void set_from_file(std::size_t scope, NodeId node);
  bool check_file_unit(Parameter& parameter, const Document& file, NodeId node);
  void read_command_line();
  void change_times(std::size_t scope);
  void add_outputs(std::size_t scope);
  void record(std::size_t scope, NodeId list);
  void record_name(std::size_t scope, NodeId item, std::vector<std::string>& names);
  void record_group(std::string_view group, const Place& place, std::vector<std::string>& names);
  void record_symbol(SymbolId symbol, const Place& place, std::vector<std::string>& names);

  // rules about whole expressions (reader_rules.cpp)
  enum class Varies : std::uint8_t { never, with_time, with_state };
  void check_dependence();
  template <class Quantity>
  void check_cycles(const std::vector<Quantity>& quantities, ModelSymbol::Kind kind, const char* what);
  void check_plain_kinds();
  std::optional<ExprId> mode_named(const Context& context, std::string_view name);
  std::vector<std::string> mode_names(const Context& context) const;
  std::vector<ElementId> modes_in(std::initializer_list<ExprId> expressions) const;
  void check_modes();
  void check_laws_of_modes();
  void check_circles_of_modes();
  void check_equalities();
  void add_graph_faults();
  [[nodiscard]] Varies variation(SymbolId id) const;
  [[nodiscard]] Varies variation(ExprId expression) const;

  // scenes (reader_scenes.cpp)
  void parse_scenes();
  void parse_scene(NodeId node);
  void parse_times(NodeId node, Scene& scene);
  bool parse_time(std::size_t scope, NodeId object, const char* key, ExprId& time, Place& place);
  void parse_output_times(std::size_t scope, NodeId object, Scene& scene);
  std::optional<std::size_t> sample_count(const Document& file, NodeId value, const std::string& what);
  void parse_log_samples(std::size_t scope, NodeId samples, Scene& scene);
  void parse_listed_times(std::size_t scope, NodeId times, Scene& scene);
  void parse_scene_parameters(NodeId node, Scene& scene);
  void parse_scene_initial(NodeId node, Scene& scene);
  void parse_scene_outputs(NodeId node, Scene& scene);
  void parse_tolerances(NodeId node, Scene& scene);
  void parse_method(NodeId node, Scene& scene);
  void parse_reference(NodeId node, Scene& scene);
  std::optional<double> positive(NodeId value, const std::string& what);
  [[nodiscard]] std::vector<std::string> state_names() const;
  bool check_state(const std::string& name, const Place& place, bool or_conjugate = false);
  bool check_output(const std::string& name, const Place& place);

  std::string path_;
  ReadOptions options_;  ///< the first of the roots is the model's own folder
  std::shared_ptr<Sources> sources_;
  Model model_;
  std::vector<Scope> scopes_;

  std::unordered_map<std::string, DocumentId> loaded_;  ///< by canonical path; an invalid id for files with faults
  std::unordered_map<std::uint32_t, std::unordered_map<std::string_view, Type>> types_;  ///< by document
  std::vector<std::size_t> unfolding_;  ///< scopes whose elements are being declared, outermost first

  std::unordered_map<std::string, Entity> names_;         ///< by full name
  std::vector<Repeated> repeated_;                        ///< elements and bonds
  std::unordered_map<std::string, ElementId> exports_;    ///< junctions by "left.body"
  std::unordered_set<std::uint64_t> with_unknown_keys_;   ///< objects, by document and value
  std::unordered_set<std::string> broken_;                ///< full names of what is at fault and reported
  std::unordered_set<std::string> ambiguous_;             ///< full names that a law could mean, too; reported
  std::unordered_set<std::uint32_t> meant_;               ///< elements that a misspelt end of a bond is likely to mean
  bool lost_bonds_ = false;                               ///< a bond, or what it was meant for, is not known
  std::unordered_map<std::string, CsvTable> data_;        ///< by path
  std::unordered_map<std::string, TableId> tables_;       ///< by file, column and interpolation
  std::unordered_map<std::string, std::size_t> outputs_;  ///< by name
  std::optional<std::size_t> command_line_scope_;         ///< whose expressions know outputs by their names
  std::vector<Written> parameter_text_, element_text_;
  std::unordered_map<std::size_t, std::size_t> junction_switches_;  ///< element behind "on" -> its junction
  struct SignalText {
    Written value, initial;
  };
  std::vector<SignalText> signal_text_;
  std::vector<ConditionSignal> conditions_;
  std::vector<DelayText> delays_;
  std::vector<Memory> memories_;
  std::unordered_map<std::uint64_t, SymbolId> bond_symbols_;
  std::unordered_map<std::size_t, SymbolId> mode_symbols_;  ///< by element
  std::vector<Varies> signal_varies_;                       ///< by SignalId

  /// Why the last name has no meaning in its place, if more is known than that.
  struct Refusal {
    std::string code, situation, help;
    std::vector<Note> notes = {};
  };
  std::optional<Refusal> refusal_;

  std::vector<Diagnostic> problems_;
  std::unordered_set<std::string> reported_;  ///< a submodel used twice has each of its faults once
  std::size_t further_problems_ = 0;
};

/// "a number", "an array", ...
const char* json_kind_name(JsonKind kind);
/// "did you mean ...?", or nothing.
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace bgsim
