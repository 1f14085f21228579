/// "repeat": an element or submodel many times, named cell[1], cell[2], ..., and the bonds between them.
#include <algorithm>
#include <cmath>

#include "read/reader.hpp"

namespace bgsim {
namespace {

constexpr double kMostCopies = 1e7;
constexpr const char* kCountsRule = "\"repeat\" is a number of copies, or a list of two or three: [rows, columns]";

/// "cell[1] to cell[10]"
std::string range_text(std::string_view name, const std::vector<std::int64_t>& first,
                       const std::vector<std::int64_t>& last) {
  const auto at = [name](const std::vector<std::int64_t>& indices) {
    std::string text(name);
    for (const std::int64_t index : indices) text += "[" + std::to_string(index) + "]";
    return in_quotes(text);
  };
  return first == last ? at(first) : at(first) + " to " + at(last);
}

/// Calls @p each with all indices from @p first to @p last, the last one running fastest.
template <class Each>
void for_all(IndexValues indices, const std::array<std::int64_t, kMostIndices>& first,
             const std::array<std::int64_t, kMostIndices>& last, const Each& each) {
  for (std::size_t d = 0; d < kMostIndices; ++d)
    if (indices.used[d]) {
      if (first[d] > last[d]) return;
      indices.value[d] = first[d];
    }
  while (true) {
    each(indices);
    std::size_t d = kMostIndices;
    while (d-- > 0) {
      if (!indices.used[d]) continue;
      if (++indices.value[d] <= last[d]) break;
      indices.value[d] = first[d];
    }
    if (d == static_cast<std::size_t>(-1)) return;
  }
}

}  // namespace

/// "repeat": 10, or [3, 4]; what is wrong with it is reported.
std::optional<Reader::Counts> Reader::read_counts(const Document& file, NodeId repeat) {
  const auto refuse = [&](const std::string& situation, NodeId at) {
    problem("BG139", situation, file.place(at), "write a whole number from 1 on: \"repeat\": 10", kCountsRule);
    return std::nullopt;
  };
  std::vector<NodeId> numbers{repeat};
  if (file[repeat].kind == JsonKind::array) {
    numbers.clear();
    for (NodeId each = file[repeat].first_child; each.valid(); each = file[each].next_sibling) numbers.push_back(each);
    if (numbers.empty() || numbers.size() > kMostIndices)
      return refuse("\"repeat\" lists " + std::to_string(numbers.size()) + " numbers", repeat);
  }
  Counts counts;
  for (const NodeId number : numbers) {
    if (file[number].kind != JsonKind::number)
      return refuse("\"repeat\" is " + std::string(json_kind_name(file[number].kind)), number);
    const double count = file[number].number;
    if (!(count >= 1.0) || count > kMostCopies || std::floor(count) != count)
      return refuse("\"repeat\" is " + number_text(count), number);
    counts.push_back(static_cast<std::int64_t>(count));
  }
  return counts;
}

/// How many elements one of a file stands for; 1 where "repeat" is at fault.
double Reader::copies_of(const Document& file, NodeId element) const {
  const NodeId repeat = file[element].kind == JsonKind::object ? file.find(element, "repeat") : NodeId{};
  if (!repeat.valid()) return 1.0;
  double copies = 1.0;
  const auto times = [&](NodeId number) {
    if (file[number].kind == JsonKind::number && file[number].number > 1.0) copies *= file[number].number;
  };
  if (file[repeat].kind != JsonKind::array)
    times(repeat);
  else
    for (NodeId each = file[repeat].first_child; each.valid(); each = file[each].next_sibling) times(each);
  return copies;
}

void Reader::claim_repeated(const std::string& full_name, Repeated range, const Place& place) {
  if (!claim(full_name, {Entity::Kind::repeated, static_cast<std::uint32_t>(repeated_.size()), place})) return;
  repeated_.push_back(std::move(range));
}

Reader::Repeated Reader::range_of(const IndexValues& first, const IndexValues& last) {
  Repeated range;
  for (std::size_t d = 0; d < kMostIndices; ++d) {
    if (!first.used[d]) continue;
    range.first.push_back(first.value[d]);
    range.last.push_back(last.value[d]);
  }
  return range;
}

const Reader::Repeated* Reader::repeated(const std::string& full_name) const {
  const auto found = names_.find(full_name);
  return found != names_.end() && found->second.kind == Entity::Kind::repeated ? &repeated_[found->second.index]
                                                                               : nullptr;
}

/// Each copy has a scope of its own, in which i, j and k have values; what it names is what the model names.
void Reader::declare_copies(std::size_t scope, NodeId node, NodeId repeat) {
  const Document& file = document(scopes_[scope]);
  const auto counts = read_counts(file, repeat);
  if (!counts) return;
  if (!valid_name(file[node].key, file.key_place(node), "an element")) return;
  claim_repeated(scopes_[scope].prefix + std::string(file[node].key), {Counts(counts->size(), 1), *counts},
                 file.key_place(node));
  Scope copy = scopes_[scope];
  copy.copy_in = scope;
  std::array<std::int64_t, kMostIndices> first{}, last{};
  for (std::size_t d = 0; d < counts->size(); ++d) {
    copy.indices.used[d] = true;
    first[d] = 1;
    last[d] = (*counts)[d];
  }
  for_all(copy.indices, first, last, [&](const IndexValues& indices) {
    copy.indices = indices;
    scopes_.push_back(copy);
    declare_element(scopes_.size() - 1, node);
  });
  const std::string full = scopes_[scope].prefix + std::string(file[node].key);
  copy.indices.value = first;
  if (names_.contains(full + index_text(copy.indices))) return;
  names_.erase(full);  // its declaration is at fault, which is reported
  broken_.insert(full);
}

/// A name with numbers for its indices; none if one of them has no value, which refusal_ says.
std::optional<std::string> Reader::with_indices(const Context& context, std::string_view name) {
  const IndexValues& indices = scopes_[context.scope].indices;
  if (auto put = indices_put_in(name, indices)) return put;
  for (const WrittenIndex& index : indices_in(name))
    if (!read_index(index.text))
      return refuse("BG121", in_quotes(index.text) + " is no index",
                    "an index is a whole number, or within what is repeated i, i+1, 2*i-1, and so with j and k");
  return refuse("BG121", "in " + in_quotes(name) + " the index has no value here",
                indices.any() ? "\"repeat\" is one number, so there is i alone: [rows, columns] has i and j"
                              : "i, j and k have values in bonds and in elements with \"repeat\"; elsewhere write the "
                                "number");
}

/// Why a name with an index, or without one that it needs, has no meaning; empty if that is not what is wrong.
std::string Reader::index_advice(std::size_t scope, std::string_view name) const {
  const std::string& prefix = scopes_[scope].prefix;
  const auto indices = indices_in(name);
  for (std::size_t end = name.find('.'); true; end = name.find('.', end + 1)) {
    std::string_view part = name.substr(0, end);
    const std::size_t bracket = part.rfind('[');
    const bool own = bracket != std::string_view::npos && part.back() == ']';
    if (!own) {
      if (const Repeated* range = repeated(prefix + std::string(part)))
        return in_quotes(part) + " is repeated: write which one is meant, " +
               range_text(part, range->first, range->last);
    } else if (!names_.contains(prefix + std::string(part))) {
      const auto base = std::find_if(indices.begin(), indices.end(), [&](const WrittenIndex& index) {
        return index.begin < part.size() && index.begin > part.rfind('.') + 1;
      });
      if (base == indices.end()) return "";
      if (const Repeated* range = repeated(prefix + std::string(base->base)))
        return "there are " + range_text(base->base, range->first, range->last);
      if (names_.contains(prefix + std::string(base->base)))
        return in_quotes(base->base) + " is not repeated: write it without an index";
      return "";
    }
    if (end == std::string_view::npos) return "";
  }
}

/// What the indices of a bond's ends are, and what range they leave to i, j and k.
struct Reader::BondIndices {
  struct Index {
    IndexSum sum;
    std::int64_t first, last;  ///< that there are
    NodeId value;              ///< the end
    std::string name;          ///< what is repeated
  };
  std::vector<Index> all;
  IndexValues used;
  std::array<std::int64_t, kMostIndices> first{}, last{};
};

/// False if an end's indices are at fault, which is reported.
bool Reader::read_bond_indices(std::size_t scope, NodeId value, BondIndices& indices) {
  const Document& file = document(scopes_[scope]);
  if (!value.valid() || file[value].kind != JsonKind::string) return true;
  const std::string_view text = file[value].text;
  const auto written = indices_in(text);
  const auto brackets =
      static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return c == '[' || c == ']'; }));
  if (brackets != 2 * written.size()) {
    problem("BG139", "a bracket in " + in_quotes(text) + " has no other one", file.place(value), "write [i+1], say");
    return false;
  }
  for (const WrittenIndex& index : written) {
    if (broken_.contains(scopes_[scope].prefix + std::string(index.base))) return false;
    const auto sum = read_index(index.text);
    if (!sum) {
      problem("BG139", in_quotes(index.text) + " is no index", file.place(value),
              "write [i], [i+1], [2*i-1] or a number",
              "an index is a whole number, or a sum of multiples of i, j, k and a whole number");
      return false;
    }
    const Repeated* range = repeated(scopes_[scope].prefix + std::string(index.base));
    if (range == nullptr || index.dimension >= range->first.size()) {
      // Its name is not known, or it has fewer indices: the end says so when it is looked for.
      static_cast<void>(no_element(scope, value, text.substr(0, text.find('.'))));
      return false;
    }
    for (std::size_t d = 0; d < kMostIndices; ++d) indices.used.used[d] = indices.used.used[d] || sum->uses(d);
    indices.all.push_back(
        {*sum, range->first[index.dimension], range->last[index.dimension], value, std::string(index.base)});
  }
  return true;
}

/// "repeat" of a bond: [first, last], or a list of these, one for each of i, j and k that its ends use.
bool Reader::read_ranges(const Document& file, NodeId repeat, BondIndices& indices) {
  const auto refuse = [&](const std::string& situation) {
    problem("BG139", situation, file.place(repeat), "write \"repeat\": [1, 9], or [[1, 3], [1, 4]] for i and j",
            "\"repeat\" of a bond gives the first and the last index");
    return false;
  };
  const auto range = [&](NodeId pair, std::size_t d) {
    if (file[pair].kind != JsonKind::array || file[pair].child_count != 2) return false;
    std::array<std::int64_t, 2> ends{};
    std::size_t at = 0;
    for (NodeId each = file[pair].first_child; each.valid(); each = file[each].next_sibling) {
      const double number = file[each].kind == JsonKind::number ? file[each].number : 0.5;
      if (std::floor(number) != number || std::abs(number) > kMostCopies) return false;
      ends[at++] = static_cast<std::int64_t>(number);
    }
    indices.first[d] = ends[0];
    indices.last[d] = ends[1];
    return ends[0] <= ends[1];
  };
  std::vector<std::size_t> used;
  for (std::size_t d = 0; d < kMostIndices; ++d)
    if (indices.used.used[d]) used.push_back(d);
  if (used.empty()) return refuse("the bond has \"repeat\", but no end of it has an index i");
  if (used.size() == 1) return range(repeat, used[0]) || refuse("the bond's \"repeat\" is no range");
  if (file[repeat].kind != JsonKind::array || file[repeat].child_count != used.size())
    return refuse("the bond's \"repeat\" does not give " + std::to_string(used.size()) + " ranges");
  std::size_t at = 0;
  for (NodeId each = file[repeat].first_child; each.valid(); each = file[each].next_sibling)
    if (!range(each, used[at++])) return refuse("the bond's \"repeat\" is no range");
  return true;
}

/// The indices of all bonds that one in the file stands for: those for which both ends are there, or those of its
/// "repeat". None if they are at fault, which is reported; one without indices for a bond that is not repeated.
std::optional<std::vector<IndexValues>> Reader::copies_of_bond(std::size_t scope, NodeId node) {
  const Document& file = document(scopes_[scope]);
  BondIndices indices;
  for (const char* key : {"from", "to"})
    if (!read_bond_indices(scope, file.find(node, key), indices)) return std::nullopt;
  const NodeId repeat = file.find(node, "repeat");
  if (repeat.valid() && !read_ranges(file, repeat, indices)) return std::nullopt;
  std::vector<IndexValues> copies;
  if (!indices.used.any()) {
    copies.emplace_back();
    return copies;
  }
  for (std::size_t d = 0; !repeat.valid() && d < kMostIndices; ++d) {
    if (!indices.used.used[d]) continue;
    // From 1 to the count of what it is an index of. Where counts differ, nobody knows what is meant.
    const BondIndices::Index* known = nullptr;
    for (const BondIndices::Index& index : indices.all) {
      if (!index.sum.uses(d)) continue;
      if (known != nullptr && (index.first != known->first || index.last != known->last)) {
        problem("BG139",
                "it is not clear for which " + std::string(1, kIndexNames[d]) + " the bond is meant: there are " +
                    range_text(known->name, {known->first}, {known->last}) + ", but " +
                    range_text(index.name, {index.first}, {index.last}),
                file.place(node), "give the bond a \"repeat\": [first, last]",
                "a bond is repeated for every index for which both its ends are there");
        return std::nullopt;
      }
      known = &index;
    }
    indices.first[d] = known->first;
    indices.last[d] = known->last;
  }
  double count = 1.0;
  for (std::size_t d = 0; d < kMostIndices; ++d)
    if (indices.used.used[d]) count *= static_cast<double>(indices.last[d] - indices.first[d] + 1);
  if (count > kMostCopies) {
    problem("BG137", "the bond is repeated more than 10 million times", file.place(node));
    return std::nullopt;
  }
  for_all(indices.used, indices.first, indices.last, [&](const IndexValues& values) {
    const bool there = std::all_of(indices.all.begin(), indices.all.end(), [&](const BondIndices::Index& index) {
      const std::int64_t at = index.sum.at(values);
      return at >= index.first && at <= index.last;
    });
    if (there || repeat.valid()) copies.push_back(values);  // what its "repeat" asks for has to be there
  });
  if (!copies.empty()) return copies;
  problem("BG139", "the bond joins nothing: for no index are both its ends there", file.place(node), {},
          "a bond is repeated for every index for which both its ends are there");
  return std::nullopt;
}

}  // namespace bgsim
