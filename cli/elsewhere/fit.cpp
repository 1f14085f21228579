// bgsim fit where Ceres and NLopt are not linked: the command is in bgsim-fit, so that bgsim itself needs neither, and
// loads neither at each start.
#include "elsewhere/hand_over.hpp"

namespace bgsim::cli {

Exit fit_command(const Arguments& arguments) {
  hand_over("bgsim-fit", "fit", arguments,
            "this bgsim was built without Ceres and NLopt, which bgsim fit needs\nscripts/bgsim fit installs them and "
            "builds it; by hand: apt-get install libceres-dev libnlopt-dev, then configure and build again");
}

}  // namespace bgsim::cli
