/// A model file as a Study, with the warnings of its stages printed.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "bgsim/input_file.hpp"
#include "bgsim/study.hpp"

namespace bgsim::cli {

/// Reads the model and prints the warnings. One with switches is in the mode that begins its first scene, changed by
/// what @p mode ("a=closed,b=open") says.
/// @throws ModelError as read_model does; UsageError for faults of what @p reading says alone.
Study read_study(const std::string& path, const ReadOptions& reading, const std::string& mode = "");
/// Assigns the causality, prints the warnings.
void assign_causality(const Study& study);
/// All that is left up to the order of the equations, prints the warnings.
void derive_equations(const Study& study);
/// The three of them.
Study study_of(const std::string& path, const ReadOptions& reading, const std::string& mode = "");
/// Prints which mode the following is about, of a model with switches.
void print_mode(const Study& study);

/// Whether nothing but the command line is at fault.
bool is_wrong_usage(const ModelError& error);

/// Prints warnings on standard error.
void print_warnings(const std::vector<Diagnostic>& warnings, const Model& model);

/// Calls @p work and adds its wall time to @p seconds.
template <class Work>
auto timed(StageSeconds& seconds, const std::string& stage, const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  auto value = work();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  seconds.emplace_back(stage, took.count());
  return value;
}

}  // namespace bgsim::cli
