/// bgsim: bond graphs from JSON to a trace. Includes every public header in the order of the stages.
#pragma once

// IWYU pragma: begin_exports
#include "bgsim/activity.hpp"
#include "bgsim/bond_graph.hpp"
#include "bgsim/causality.hpp"
#include "bgsim/constitutive.hpp"
#include "bgsim/describe.hpp"
#include "bgsim/diagnostic.hpp"
#include "bgsim/document.hpp"
#include "bgsim/equations.hpp"
#include "bgsim/evaluator.hpp"
#include "bgsim/expression.hpp"
#include "bgsim/flat_model.hpp"
#include "bgsim/id.hpp"
#include "bgsim/method.hpp"
#include "bgsim/model.hpp"
#include "bgsim/ordering.hpp"
#include "bgsim/parse_expression.hpp"
#include "bgsim/program.hpp"
#include "bgsim/reduce.hpp"
#include "bgsim/simulate.hpp"
#include "bgsim/slice.hpp"
#include "bgsim/time_event.hpp"
#include "bgsim/trace_csv.hpp"
#include "bgsim/trade.hpp"
#include "bgsim/verify.hpp"
// IWYU pragma: end_exports
