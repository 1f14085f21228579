/// What the commands of linear analysis share: the model, the point, inputs and outputs.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "bgsim/linear.hpp"
#include "bgsim/study.hpp"
#include "command.hpp"

namespace bgsim::cli {

struct LinearArguments {
  std::string file, scene, mode, at = "start", output;
  std::vector<std::string> inputs, outputs;  ///< as given, lists not yet split
  ReadOptions reading;
  SceneOverrides overrides;
  bool quiet = false;
};

/// model.json, --scene, --set, --parameters, --at, --mode, -o.
void add_linear_options(CLI::App& app, LinearArguments& arguments, const std::string& file);
/// --in and --out.
void add_path_options(CLI::App& app, LinearArguments& arguments, bool several);

/// A model linearized as the arguments say.
struct LinearStudy {
  Study study;
  RunInputs point;    ///< where it is linearized
  std::string where;  ///< "at the start of the scene step, t = 0"
  LinearSystem system;
};

/// Names out of lists with commas.
std::vector<std::string> split_names(const std::vector<std::string>& lists);
/// Makes --out what the scenes record, so that names are looked up and suggested as by --record.
void take_outputs(LinearArguments& arguments);

/// The model, read, with its warnings printed.
Study linear_study(const LinearArguments& arguments);
/// The scene at its start, with what samples, latches and events of the model set there, as a run begins.
/// @param study  comes to be in the mode that the run begins in.
RunInputs scene_begun(Study& study, const LinearArguments& arguments);
/// That, linearized where --at says. In a model with switches a time of its run is in the mode that they are in then.
/// Notes go to standard error.
/// @param outputs  whether any are wanted.
LinearStudy linearized(const LinearArguments& arguments, const std::vector<std::string>& inputs, bool outputs = true);
/// All sources of a model, by the names of what they give.
std::vector<std::string> all_sources(const Model& model);
/// The only input and output that a command needs.
/// @throws UsageError if none or several are given.
void require_one(const std::vector<std::string>& names, const char* option, const char* example);

/// "1.5 +- 2j", "-3"
std::string complex_text(std::complex<double> value, int digits = 6);
/// How a pole is to be read: what is not known of it.
std::string pole_remark(const Pole& pole);

}  // namespace bgsim::cli
