/// A run's state as a text: where it is, and all that it carries from step to step.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <deque>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"
#include "run/integrate/spectrum.hpp"

namespace bgsim {

// A class that takes part has a template carry(archive), which names each of its members once: archive("name", member).
// The same function writes and reads.

/// The text is no snapshot, or not one of this program.
class SnapshotError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <class Archive>
void carry(Archive& archive, Branch& branch) {
  archive("modes", branch.modes);
  archive("tears", branch.tears);
  archive("largest", branch.largest);
}

template <class Archive>
void carry(Archive& archive, SpentMode& mode) {
  archive("order", mode.order);
  archive("frequency", mode.frequency);
  archive("damping", mode.damping);
}

template <class T, class Archive>
concept CarriesItself = requires(T& value, Archive& archive) {
  value.carry(archive);
};

template <class T>
concept Sequence = requires(T& value) {
  value.push_back(typename T::value_type());
  value.clear();
}
&&!std::same_as<T, std::string>;

class SnapshotWriter {
 public:
  static constexpr bool kReads = false;
  template <class T>
  void operator()(const char* name, T& value) {
    json_[name] = json_of(value);
  }
  /// Of what is read only.
  static void check(bool /*good*/) {}

  [[nodiscard]] const nlohmann::ordered_json& json() const { return json_; }

 private:
  /// Numbers in the shortest form that gives the same bits again; JSON has none for infinity and NaN.
  static nlohmann::ordered_json json_of(double value) {
    if (std::isfinite(value)) return value;
    return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
  }
  template <class T>
  static nlohmann::ordered_json json_of(T& value) {
    if constexpr (std::is_floating_point_v<T>) {
      return json_of(double{value});
    } else if constexpr (std::is_arithmetic_v<T> || std::same_as<T, std::string>) {
      return value;
    } else if constexpr (requires { value.has_value(); }) {
      return value ? json_of(*value) : nlohmann::ordered_json(nullptr);
    } else if constexpr (Sequence<T>) {
      auto list = nlohmann::ordered_json::array();
      for (auto&& item : value) {
        typename T::value_type copy = item;
        list.push_back(json_of(copy));
      }
      return list;
    } else {
      SnapshotWriter inner;
      if constexpr (CarriesItself<T, SnapshotWriter>)
        value.carry(inner);
      else
        carry(inner, value);
      return std::move(inner.json_);
    }
  }

  nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
};

class SnapshotReader {
 public:
  static constexpr bool kReads = true;
  explicit SnapshotReader(const nlohmann::ordered_json& json) : json_(json) {}

  /// @throws SnapshotError  if there is no such member, or not of that type, or a list is not as long as the one that
  ///         the run has already.
  template <class T>
  void operator()(const char* name, T& value) {
    const auto found = json_.find(name);
    if (found == json_.end()) throw SnapshotError(std::string("it has no \"") + name + "\"");
    read(*found, value, name);
  }
  /// What is read must be so.
  static void check(bool good) {
    if (!good) throw SnapshotError("a number in it is out of range");
  }

 private:
  template <class T>
  static void read(const nlohmann::ordered_json& json, T& value, const char* name) {
    const auto fault = [name] { return SnapshotError(std::string("\"") + name + "\" in it is not understood"); };
    if constexpr (std::same_as<T, bool>) {
      if (!json.is_boolean()) throw fault();
      value = json.get<bool>();
    } else if constexpr (std::is_floating_point_v<T>) {
      if (json == "nan")
        value = std::numeric_limits<T>::quiet_NaN();
      else if (json == "inf" || json == "-inf")
        value = (json == "inf" ? 1 : -1) * std::numeric_limits<T>::infinity();
      else if (json.is_number())
        value = json.get<T>();
      else
        throw fault();
    } else if constexpr (std::unsigned_integral<T>) {
      if (!json.is_number_unsigned()) throw fault();
      value = json.get<T>();
    } else if constexpr (std::is_arithmetic_v<T>) {
      if (!json.is_number_integer()) throw fault();
      value = json.get<T>();
    } else if constexpr (std::same_as<T, std::string>) {
      if (!json.is_string()) throw fault();
      value = json.get<std::string>();
    } else if constexpr (requires { value.has_value(); }) {
      value.reset();
      if (json.is_null()) return;
      value.emplace();
      read(json, *value, name);
    } else if constexpr (Sequence<T>) {
      if (!json.is_array() || (!value.empty() && json.size() != value.size())) throw fault();
      value.clear();
      for (const auto& item : json) {
        typename T::value_type one{};
        read(item, one, name);
        value.push_back(std::move(one));
      }
    } else {
      if (!json.is_object()) throw fault();
      SnapshotReader inner(json);
      if constexpr (CarriesItself<T, SnapshotReader>)
        value.carry(inner);
      else
        carry(inner, value);
    }
  }

  const nlohmann::ordered_json& json_;
};

inline constexpr int kSnapshotFormat = 11;

/// What a snapshot is valid for: program, scene, method and tolerances, but for output times and the end of the scene.
/// Equal programs give equal texts on all machines.
std::string fingerprint(const Program& program, const RunInputs& inputs);

/// What a run keeps beside its solution, and a snapshot of it then holds.
struct SnapshotKept {
  bool audit = false, errors = false;
};
SnapshotKept kept_by(const SimulateOptions& options);

/// The state in a snapshot of the run with that fingerprint, which keeps the same.
/// @throws ModelError  BG171, with these sources, if the text is no such snapshot, or is not as it was written.
nlohmann::ordered_json state_of_snapshot(const std::string& text, const std::string& fingerprint, SnapshotKept kept,
                                         const std::shared_ptr<const Sources>& sources);
/// @throws ModelError  BG171.
[[noreturn]] void refuse_snapshot(const std::string& why, const std::shared_ptr<const Sources>& sources);

/// A snapshot as a text.
std::string snapshot_text(const std::string& model, const std::string& scene, double t, const std::string& fingerprint,
                          SnapshotKept kept, nlohmann::ordered_json state);

}  // namespace bgsim
