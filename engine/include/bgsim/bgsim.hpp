/// bgsim: bond graphs from JSON to a trace. Includes every public header, in the order of the stages.
#pragma once

// clang-format off
// IWYU pragma: begin_exports
#include "bgsim/id.hpp"
#include "bgsim/text.hpp"
#include "bgsim/xml.hpp"
#include "bgsim/csv.hpp"
#include "bgsim/diagnostic.hpp"
#include "bgsim/unit.hpp"
#include "bgsim/expression.hpp"
#include "bgsim/method.hpp"
#include "bgsim/output_times.hpp"
#include "bgsim/model.hpp"
#include "bgsim/modes.hpp"
#include "bgsim/input_file.hpp"
#include "bgsim/constitutive.hpp"
#include "bgsim/bond_graph.hpp"
#include "bgsim/causality.hpp"
#include "bgsim/infer_units.hpp"
#include "bgsim/equations.hpp"
#include "bgsim/ordering.hpp"
#include "bgsim/slice.hpp"
#include "bgsim/program.hpp"
#include "bgsim/evaluator.hpp"
#include "bgsim/simulate.hpp"
#include "bgsim/trace_csv.hpp"
#include "bgsim/verify.hpp"
#include "bgsim/linear.hpp"
#include "bgsim/study.hpp"
#include "bgsim/sensitivity.hpp"
#include "bgsim/sweep.hpp"
#include "bgsim/trade.hpp"
#include "bgsim/reduce.hpp"
#include "bgsim/drawing.hpp"
#include "bgsim/describe.hpp"
// IWYU pragma: end_exports
// clang-format on
