// The commands of bgsim-studies where they are not linked: studies of many runs, linear analysis and reports are a
// third of the build, and no run needs them.
#include "elsewhere/hand_over.hpp"
#include "run_search.hpp"

namespace bgsim::cli {

namespace {

[[noreturn]] void studies(const char* command, const Arguments& arguments) {
  hand_over("bgsim-studies", command, arguments,
            "the program bgsim-studies, which this command is part of, is not beside bgsim\nscripts/bgsim builds it "
            "when it is first needed; by hand: cmake --build FOLDER --target bgsim_studies_cli");
}

}  // namespace

Exit linearize_command(const Arguments& arguments) { studies("linearize", arguments); }
Exit poles_command(const Arguments& arguments) { studies("poles", arguments); }
Exit zeros_command(const Arguments& arguments) { studies("zeros", arguments); }
Exit control_command(const Arguments& arguments) { studies("control", arguments); }
Exit transfer_command(const Arguments& arguments) { studies("transfer", arguments); }
Exit bode_command(const Arguments& arguments) { studies("bode", arguments); }
Exit step_command(const Arguments& arguments) { studies("step", arguments); }
Exit steady_command(const Arguments& arguments) { studies("steady", arguments); }
Exit reduce_command(const Arguments& arguments) { studies("reduce", arguments); }
Exit report_command(const Arguments& arguments) { studies("report", arguments); }
Exit trade_command(const Arguments& arguments) { studies("trade", arguments); }
Exit sweep_command(const Arguments& arguments) { studies("sweep", arguments); }
Exit sensitivity_command(const Arguments& arguments) { studies("sensitivity", arguments); }

/// What --accuracy asks for is found by the runs of a trade.
AccuracySearch accuracy_search(const Arguments& arguments) { studies("run", arguments); }

}  // namespace bgsim::cli
