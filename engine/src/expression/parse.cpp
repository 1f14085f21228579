#include "expression/parse.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <span>
#include <vector>

#include "base/text.hpp"
#include "bgsim/diagnostic.hpp"
#include "expression/graph.hpp"
#include "expression/language.hpp"
#include "expression/other_words.hpp"
#include "expression/partial.hpp"
#include "expression/value_unit.hpp"
#include "expression/write/layout.hpp"

namespace bgsim {

ExpressionError::ExpressionError(std::string code_, const std::string& message, std::size_t begin_, std::size_t end_,
                                 std::string help_)
    : std::runtime_error(message), code(std::move(code_)), begin(begin_), end(end_), help(std::move(help_)) {}

namespace {

constexpr std::size_t kDeepestNesting = 1000;

/// The byte after the character that begins at @p at: one for ASCII, all of a character of several bytes.
std::size_t character_end(std::string_view text, std::size_t at) {
  if (at >= text.size()) return text.size();
  ++at;
  while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U) ++at;
  return at;
}

/// What is between operators: a number, a condition, or (in table only) a text.
struct Operand {
  enum class Kind : std::uint8_t { number, condition, text } kind = Kind::number;
  ExprId id;
  std::string_view text;
  std::size_t begin = 0, end = 0;
  bool partial = false;  ///< something in it has no value everywhere
};

/// An operator whose right operand is being read.
struct Pending {
  Op op;
  bool prefix;
  std::size_t begin, end;
};

/// An open parenthesis, with the function it belongs to.
struct Group {
  const Function* function;  ///< nullptr: parenthesis
  std::size_t begin;         ///< of the function's name or the parenthesis
  std::size_t operators;     ///< operators outside
  std::size_t operands;      ///< operands outside
};

/// Operator precedence parser with its own stacks: no recursion, time linear in the text.
class Parser {
 public:
  Parser(std::string_view text, ExprPool& pool, const ExpressionScope& scope)
      : text_(text), pool_(pool), scope_(scope) {}

  ExprId parse(Operand::Kind wanted) {
    bool operand_next = true;
    for (skip_space(); at_ < text_.size(); skip_space()) operand_next = operand_next ? read_operand() : read_operator();
    if (operand_next) missing_operand(text_.size(), text_.size());
    if (!groups_.empty()) {
      const std::size_t begin = groups_.back().begin;
      fail("BG120", "this parenthesis is not closed", begin, begin + opening_length(groups_.back()), "add \")\"");
    }
    reduce_all(0);
    const Operand result = operands_.back();
    want(result, wanted, "the expression");
    return result.id;
  }

 private:
  // --- characters

  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }
  [[nodiscard]] char peek(std::size_t ahead = 0) const {
    return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0';
  }
  /// Length of a dotted name at @p at: "x", "packet.wall.q", "tf.1.e", "cell[i+1].store.q"; 0 if there is none.
  [[nodiscard]] std::size_t name_length(std::size_t at) const {
    if (at >= text_.size() || !begins_name(text_[at])) return 0;
    std::size_t end = at;
    const auto part = [&] {
      while (end < text_.size() && (begins_name(text_[end]) || is_digit(text_[end]))) ++end;
      while (end < text_.size() && text_[end] == '[') {
        const std::size_t close = text_.find_first_of("[](),.", end + 1);
        if (close == std::string_view::npos || text_[close] != ']') return;
        end = close + 1;
      }
    };
    part();
    while (end + 1 < text_.size() && text_[end] == '.' && (begins_name(text_[end + 1]) || is_digit(text_[end + 1]))) {
      ++end;
      part();
    }
    return end - at;
  }
  [[nodiscard]] std::string quoted(std::size_t begin, std::size_t end) const {
    return "\"" + std::string(text_.substr(begin, end - begin)) + "\"";
  }
  [[noreturn]] void fail(const char* code, const std::string& message, std::size_t begin, std::size_t end,
                         std::string help = {}) const {
    throw ExpressionError(code, message, begin, end, std::move(help));
  }

  // --- operands; each returns whether an operand comes next

  bool read_operand() {
    const char c = peek();
    if (is_digit(c) || (c == '.' && is_digit(peek(1)))) return read_number();
    if (begins_name(c)) return read_name();
    if (c == '(') return open_group(nullptr, at_, 1);
    if (c == '"' || c == '\'') return read_text(c);
    if (c == '-') {
      operators_.push_back({Op::neg, true, at_, at_ + 1});
      ++at_;
      return true;
    }
    if (c == ')' && !groups_.empty() && groups_.back().function != nullptr &&
        groups_.back().operands == operands_.size() && operators_.size() == groups_.back().operators)
      wrong_count(*groups_.back().function, 0, groups_.back().begin, at_ + 1);
    const std::size_t end = character_end(text_, at_);
    if (c == '+') fail("BG120", "\"+\" before a value", at_, end, "remove it: only the minus sign may be used alone");
    missing_operand(at_, end);
  }

  [[noreturn]] void missing_operand(std::size_t begin, std::size_t end) const {
    if (const auto sign = foreign_sign(text_.substr(begin))) refuse_sign(*sign, begin);
    if (begin == end && operands_.empty() && operators_.empty() && groups_.empty())
      fail("BG120", "the expression is empty", 0, text_.size(), "write a number or an expression");
    const std::string what = begin == end ? "the end of the text" : quoted(begin, end);
    fail("BG120", "a number, a name or \"(\" is expected here, not " + what, begin, end);
  }

  [[noreturn]] void refuse_sign(const ForeignSign& sign, std::size_t begin) const {
    const std::size_t end = begin + sign.length;
    fail("BG120", (sign.what.empty() ? quoted(begin, end) : sign.what) + " is not part of the language", begin, end,
         sign.help);
  }

  /// What follows a number at byte @p at as if it were its unit, or its power of ten.
  void refuse_unit(std::size_t number, std::size_t at) const {
    const auto found = unit_behind(text_.substr(number), at - number);
    if (!found) return;
    const std::string_view word = text_.substr(at, name_length(at));
    const bool known = !word.empty() && scope_.name && scope_.name(word);
    std::string help = found->help;
    if (known)
      help = "if a product is meant, write " + std::string(trimmed_end(text_.substr(number, at - number))) + "*" +
             std::string(word) + "; " + help;
    fail(found->code, found->situation, at, at + found->length, std::move(help));
  }
  static std::string_view trimmed_end(std::string_view text) {
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    return text;
  }

  bool read_number() {
    double value = 0.0;
    const char* first = text_.data() + at_;
    const char* last = text_.data() + text_.size();
    const auto [end, error] = std::from_chars(first, last, value);
    const std::size_t length = static_cast<std::size_t>(end - first);
    const std::size_t stop = at_ + length;
    if (error != std::errc()) {
      fail("BG123", "the number " + std::string(text_.substr(at_, length)) + " is out of range", at_, stop,
           "numbers go from about 5e-324 to 1.8e308 in magnitude");
    }
    last_number_ = at_;
    if (const std::size_t name = name_length(stop); name > 0 && keyword(stop, name) == nullptr) {
      refuse_unit(at_, stop);
      const std::string number(text_.substr(at_, length)), rest(text_.substr(stop, name));
      fail("BG120", "no operator between " + number + " and " + rest, at_, stop + name,
           "write " + number + "*" + rest + " if a product is meant");
    }
    push_number(pool_.constant(value), at_, stop);
    at_ = stop;
    return false;
  }

  /// The word operator "and" or "or" if the name is one, else nullptr.
  [[nodiscard]] const BinaryOperator* keyword(std::size_t at, std::size_t length) const {
    for (const BinaryOperator& b : kBinary)
      if (b.text == text_.substr(at, length)) return &b;
    return nullptr;
  }

  bool read_name() {
    const std::size_t begin = at_, length = name_length(at_);
    const std::string_view name = text_.substr(begin, length);
    if (keyword(begin, length) != nullptr) missing_operand(begin, begin + length);
    last_number_.reset();
    at_ += length;
    if (name == "not") {
      operators_.push_back({Op::logical_not, true, begin, at_});
      return true;
    }
    skip_space();
    if (peek() == '(') {
      const Function* function = function_named(name);
      if (function == nullptr) unknown_function(name, begin);
      return open_group(function, begin, at_ + 1 - begin);
    }
    if (is_table_argument(3) && (name == "linear" || name == "spline")) {
      operands_.push_back({Operand::Kind::text, {}, name, begin, begin + length});
      return false;
    }
    push_quantity(meaning(name, begin), begin, begin + length);
    return false;
  }

  /// Signals and mode(...) may be conditions.
  void push_quantity(ExprId id, std::size_t begin, std::size_t end) {
    const Op op = pool_[id].op;
    const bool condition = is_comparison(op) || (op >= Op::logical_and && op <= Op::logical_not);
    operands_.push_back({condition ? Operand::Kind::condition : Operand::Kind::number, id, {}, begin, end});
  }

  [[nodiscard]] static const Function* function_named(std::string_view name) {
    const auto* found = std::lower_bound(kFunctions.begin(), kFunctions.end(), name,
                                         [](const Function& f, std::string_view n) { return f.name < n; });
    return found != kFunctions.end() && found->name == name ? found : nullptr;
  }

  ExprId meaning(std::string_view name, std::size_t begin) {
    if (name == "t") return pool_.symbol(scope_.time);
    if (name == "pi") return pool_.constant(std::numbers::pi);
    if (scope_.name)
      if (const auto known = scope_.name(name)) return *known;
    const std::size_t end = begin + name.size();
    if (const Function* function = function_named(name)) {
      fail("BG120", std::string(name) + " is a function and needs arguments", begin, end,
           "write " + std::string(function->usage) +
               (peek() == '^' ? ", and the power behind: " + std::string(name) + "(x)^2" : ""));
    }
    const std::string other = instead_of_name(name, text_.substr(end));
    if (!other.empty()) fail("BG121", "unknown name \"" + std::string(name) + "\"", begin, end, other);
    std::vector<std::string> candidates;
    if (scope_.known_names) candidates = scope_.known_names();
    candidates.insert(candidates.end(), {"t", "pi"});
    const std::string nearest = nearest_name(std::string(name), candidates);
    fail("BG121", "unknown name \"" + std::string(name) + "\"", begin, end,
         nearest.empty() ? "" : "did you mean \"" + nearest + "\"?");
  }

  [[noreturn]] void unknown_function(std::string_view name, std::size_t begin) const {
    std::vector<std::string> candidates;
    for (const Function& f : kFunctions) candidates.emplace_back(f.name);
    std::string help = instead_of_function(name);
    if (scope_.name && scope_.name(name)) help = "if a product is meant, write " + std::string(name) + "*(...)";
    const std::string nearest = help.empty() ? nearest_name(std::string(name), candidates) : "";
    if (!nearest.empty()) help = "did you mean " + nearest + "?";
    if (help.empty()) help = "functions are listed in docs/model-format.md; what is not among them can be a table(...)";
    fail("BG121", "unknown function " + std::string(name) + "(...)", begin, begin + name.size(), help);
  }

  bool read_text(char quote) {
    const std::size_t begin = at_, close = text_.find(quote, at_ + 1);
    if (close == std::string_view::npos)
      fail("BG120", "this text is not closed", begin, text_.size(), std::string("add ") + quote);
    const Function* const function = groups_.empty() ? nullptr : groups_.back().function;
    if (function == nullptr || (function->op != Op::table && function->op != Op::symbol))
      fail("BG120", "a text is allowed only in table(...) and mode(...)", begin, close + 1);
    operands_.push_back({Operand::Kind::text, {}, text_.substr(begin + 1, close - begin - 1), begin, close + 1});
    at_ = close + 1;
    return false;
  }

  [[nodiscard]] bool is_table_argument(std::size_t position) const {
    return !groups_.empty() && groups_.back().function != nullptr && groups_.back().function->op == Op::table &&
           operands_.size() - groups_.back().operands == position;
  }

  void push_number(ExprId id, std::size_t begin, std::size_t end) {
    operands_.push_back({Operand::Kind::number, id, {}, begin, end});
  }

  // --- operators; each returns whether an operand comes next

  bool read_operator() {
    const char c = peek();
    if (c == ')') return close_group();
    if (c == ',') return next_argument();
    const BinaryOperator* found = nullptr;
    if (const std::size_t length = name_length(at_); length > 0) {
      found = keyword(at_, length);
    } else {
      const auto* symbol = std::find_if(kBinary.begin(), kBinary.end(), [&](const BinaryOperator& b) {
        return text_.substr(at_, b.text.size()) == b.text;
      });
      if (symbol != kBinary.end()) found = symbol;
    }
    if (found == nullptr) missing_operator();
    const std::size_t begin = at_;
    at_ += found->text.size();
    if (found->op == Op::mul && peek() == '*')
      fail("BG120", "unknown operator \"**\"", begin, at_ + 1, "write ^ for a power");
    // What binds tighter is done; what binds alike is done too, but for powers, which go from right to left.
    const Binding own = binding_of(found->op);
    while (operators_.size() > base()) {
      const Binding left = binding_of(operators_.back().op);
      if (left < own || (left == own && found->op == Op::pow)) break;
      if (own == Binding::comparison && left == own)
        fail("BG120", "comparisons cannot be chained", operators_.back().begin, at_,
             "join two comparisons with and: a < b and b < c");
      reduce();
    }
    last_number_.reset();
    operators_.push_back({found->op, false, begin, at_});
    return true;
  }

  [[noreturn]] void missing_operator() const {
    if (last_number_) refuse_unit(*last_number_, at_);
    if (const auto sign = foreign_sign(text_.substr(at_))) refuse_sign(*sign, at_);
    std::size_t end = at_ + name_length(at_);
    if (end == at_) end = character_end(text_, at_);
    const std::string_view next = text_.substr(at_, end - at_);
    std::string help;
    if (next == "(" || begins_name(next[0]) || is_digit(next[0])) help = "write * if a product is meant";
    if (next == "\"") help = "a text is allowed only in table(...) and mode(...)";
    fail("BG120", "an operator is expected here, not " + quoted(at_, end), at_, end, help);
  }

  // --- parentheses and functions

  [[nodiscard]] std::size_t base() const { return groups_.empty() ? 0 : groups_.back().operators; }
  static std::size_t opening_length(const Group& group) {
    return group.function == nullptr ? 1 : group.function->name.size();
  }

  bool open_group(const Function* function, std::size_t begin, std::size_t length) {
    if (groups_.size() >= kDeepestNesting)
      fail("BG125", "parentheses are nested more than 1000 deep", begin, begin + length,
           "give parts of the expression names as signals");
    groups_.push_back({function, begin, operators_.size(), operands_.size()});
    at_ = begin + length;
    return true;
  }

  bool next_argument() {
    if (groups_.empty() || groups_.back().function == nullptr)
      fail("BG120", "a comma outside a function's arguments", at_, at_ + 1, "the decimal sign is a point");
    reduce_all(base());
    ++at_;
    return true;
  }

  bool close_group() {
    if (groups_.empty())
      fail("BG120", "\")\" without \"(\"", at_, at_ + 1, "take it out, or open a parenthesis before it");
    reduce_all(base());
    last_number_.reset();
    const Group group = groups_.back();
    groups_.pop_back();
    ++at_;
    if (group.function == nullptr) {
      operands_.back().begin = group.begin;
      operands_.back().end = at_;
      return false;
    }
    const std::vector<Operand> arguments(operands_.begin() + static_cast<std::ptrdiff_t>(group.operands),
                                         operands_.end());
    operands_.resize(group.operands);
    push_quantity(call(*group.function, arguments, group.begin), group.begin, at_);
    // What if(...) leaves out by a constant condition was not asked for.
    if (group.function->op == Op::select)
      operands_.back().partial = true;
    else
      look(group.function->op, operands_.back(), arguments);
    return false;
  }

  [[noreturn]] void wrong_count(const Function& f, std::size_t count, std::size_t begin, std::size_t end) const {
    const std::string meant = f.least == f.most      ? std::to_string(f.least)
                              : f.most == kAnyNumber ? std::to_string(f.least) + " or more"
                                                     : std::to_string(f.least) + " or " + std::to_string(f.most);
    const bool one = f.least == 1 && f.most == 1;
    fail(
        "BG122",
        std::string(f.name) + " takes " + meant + (one ? " argument" : " arguments") + ", not " + std::to_string(count),
        begin, end,
        f.op == Op::select && count > f.most ? "nest them: if(a, x, if(b, y, z))" : "write " + std::string(f.usage));
  }

  ExprId call(const Function& f, const std::vector<Operand>& x, std::size_t begin) {
    if (x.size() < f.least || x.size() > f.most) wrong_count(f, x.size(), begin, at_);
    if (f.op == Op::table) return call_table(x);
    if (f.op == Op::symbol) return call_mode(x[0]);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const bool condition = f.op == Op::select && i == 0;
      want(x[i], condition ? Operand::Kind::condition : Operand::Kind::number,
           "argument " + std::to_string(i + 1) + " of " + std::string(f.name));
    }
    switch (f.op) {
      case Op::constant:
        if (f.name == "previous") {
          if (scope_.previous)
            if (const auto before = scope_.previous(x[0].id)) return *before;
          fail("BG122", "previous(...) takes the name of a sampled signal", begin, at_,
               "write previous(u), where u is declared with \"every\"");
        }
        // pre(x): what an event sets is computed from the instant before
        if (!scope_.after_event)
          fail("BG118", "pre(...) cannot be used here", begin, at_,
               "leave it out; the value before an event has a meaning in the \"set\" of that event only");
        return x[0].id;
      case Op::select:
        return pool_.select(x[0].id, x[1].id, x[2].id);
      case Op::min:
      case Op::max: {
        ExprId result = x[0].id;
        for (std::size_t i = 1; i < x.size(); ++i) result = pool_.make(f.op, result, x[i].id);
        return result;
      }
      default:
        return x.size() == 1 ? pool_.make(f.op, x[0].id) : pool_.make(f.op, x[0].id, x[1].id);
    }
  }

  ExprId call_mode(const Operand& name) {
    want(name, Operand::Kind::text, "the argument of mode");
    if (!scope_.mode) fail("BG122", "mode(...) cannot be used here", name.begin, name.end);
    if (const auto known = scope_.mode(name.text)) return *known;
    const std::string nearest =
        scope_.known_modes ? nearest_name(std::string(name.text), scope_.known_modes()) : std::string();
    fail("BG121", "there is no switch, diode or contact \"" + std::string(name.text) + "\"", name.begin + 1,
         name.end - 1,
         nearest.empty() ? "Sw, D, contact and junctions with \"on\" have modes" : "did you mean '" + nearest + "'?");
  }

  ExprId call_table(const std::vector<Operand>& x) {
    want(x[0], Operand::Kind::text, "argument 1 of table");
    want(x[1], Operand::Kind::text, "argument 2 of table");
    want(x[2], Operand::Kind::number, "argument 3 of table");
    Interpolation interpolation = Interpolation::linear;
    if (x.size() == 4) {
      if (x[3].kind != Operand::Kind::text || (x[3].text != "linear" && x[3].text != "spline"))
        fail("BG122", "argument 4 of table is neither linear nor spline", x[3].begin, x[3].end,
             "leave it out for linear interpolation");
      if (x[3].text == "spline") interpolation = Interpolation::spline;
    }
    if (!scope_.table) fail("BG122", "measured data cannot be used here", x[0].begin, x[0].end);
    return pool_.table(Op::table, x[2].id, scope_.table(x[0].text, x[1].text, interpolation));
  }

  // --- building

  void reduce_all(std::size_t outside) {
    while (operators_.size() > outside) reduce();
  }

  /// Applies the last operator to its operands.
  void reduce() {
    const Pending pending = operators_.back();
    operators_.pop_back();
    const Operand right = operands_.back();
    operands_.pop_back();
    const bool logical = pending.op >= Op::logical_and && pending.op <= Op::logical_not;
    const auto kind = logical ? Operand::Kind::condition : Operand::Kind::number;
    const std::string place = " of " + (pending.op == Op::neg ? "the minus sign" : quoted(pending.begin, pending.end));
    Operand result;
    result.end = right.end;
    result.kind = logical || is_comparison(pending.op) ? Operand::Kind::condition : Operand::Kind::number;
    if (pending.prefix) {
      want(right, kind, "the operand" + place);
      result.id = pool_.make(pending.op, right.id);
      result.begin = pending.begin;
      look(pending.op, result, std::array{right});
    } else {
      const Operand left = operands_.back();
      operands_.pop_back();
      want(left, kind, "the left operand" + place);
      want(right, kind, "the right operand" + place);
      result.id = pool_.make(pending.op, left.id, right.id);
      result.begin = left.begin;
      if (!logical) look(pending.op, result, std::array{left, right});
    }
    operands_.push_back(result);
  }

  /// Whether what was made of these operands by @p op has all of it that may have no value.
  void look(Op op, Operand& made, std::span<const Operand> of) {
    const bool divides = op == Op::div || op == Op::mod;
    made.partial =
        is_partial(pool_, made.id) || std::any_of(of.begin(), of.end(), [](const Operand& x) { return x.partial; });
    if ((!made.partial && !divides) || !scope_.leaves_out) return;
    std::vector<ExprId> ids, kept;
    for (const Operand& x : of)
      if (x.kind != Operand::Kind::text) ids.push_back(x.id);
    for_each_argument(pool_[made.id], [&](ExprId argument) { kept.push_back(argument); });
    if (pool_[made.id].op == op && std::is_permutation(ids.begin(), ids.end(), kept.begin(), kept.end())) return;
    const ExprId lost = lost_partial(pool_, ids, divides ? ids[1] : ExprId(), made.id);
    if (lost.valid()) scope_.leaves_out(made.begin, made.end, made.id, lost);
  }

  void want(const Operand& operand, Operand::Kind kind, const std::string& what) const {
    if (operand.kind == kind) return;
    static constexpr std::array<const char*, 3> kNames{"a number", "a condition", "a text"};
    const std::string is = kNames[static_cast<std::size_t>(operand.kind)];
    const std::string wanted = kNames[static_cast<std::size_t>(kind)];
    std::string help;
    if (kind == Operand::Kind::number && operand.kind == Operand::Kind::condition)
      help = "if(condition, 1, 0) makes a number of a condition";
    if (kind == Operand::Kind::condition && operand.kind == Operand::Kind::number) help = "compare it, as in x > 0";
    if (kind == Operand::Kind::text) help = "write it in quotes";
    const bool text = kind == Operand::Kind::text || operand.kind == Operand::Kind::text;
    fail(text ? "BG122" : "BG124", what + " is " + is + " where " + wanted + " is meant", operand.begin, operand.end,
         help);
  }

  std::string_view text_;
  ExprPool& pool_;
  const ExpressionScope& scope_;
  std::size_t at_ = 0;
  std::optional<std::size_t> last_number_;  ///< where the last operand begins, if it is a number
  std::vector<Operand> operands_;
  std::vector<Pending> operators_;
  std::vector<Group> groups_;
};

}  // namespace

ExprId parse_expression(std::string_view text, ExprPool& pool, const ExpressionScope& scope) {
  return Parser(text, pool, scope).parse(Operand::Kind::number);
}

ExprId parse_condition(std::string_view text, ExprPool& pool, const ExpressionScope& scope) {
  return Parser(text, pool, scope).parse(Operand::Kind::condition);
}

}  // namespace bgsim
