#include "base/codes.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace bgsim {
namespace {

constexpr auto kError = Severity::error, kWarning = Severity::warning;

constexpr std::array kCodes{
    Code{"BG100", kError, "The file cannot be read"},
    Code{"BG101", kError, "The file is not JSON"},
    Code{"BG102", kError, "A key occurs twice in one object"},
    Code{"BG103", kError, "A number is out of range"},
    Code{"BG104", kError, "The file is too large"},
    Code{"BG105", kError, "Further problems"},
    Code{"BG110", kError, "Another model format"},
    Code{"BG111", kError, "Unknown key"},
    Code{"BG112", kError, "A key is missing, or two exclude each other"},
    Code{"BG113", kError, "A value of the wrong type"},
    Code{"BG114", kError, "Unknown kind of element"},
    Code{"BG115", kError, "An invalid name"},
    Code{"BG116", kError, "An ambiguous name"},
    Code{"BG117", kError, "A law or an energy that cannot be used"},
    Code{"BG118", kError, "A quantity that may not be used here"},
    Code{"BG119", kError, "Equality of quantities that vary"},
    Code{"BG120", kError, "The expression cannot be read"},
    Code{"BG121", kError, "Unknown name or function"},
    Code{"BG122", kError, "Wrong arguments of a function"},
    Code{"BG123", kError, "Number out of range"},
    Code{"BG124", kError, "A condition where a number is meant, or the reverse"},
    Code{"BG125", kError, "Parentheses nested too deep"},
    Code{"BG126", kError, "A law is one equation"},
    Code{"BG127", kError, "Measured data that cannot be used"},
    Code{"BG128", kWarning, "A part of an expression that is left out"},
    Code{"BG130", kError, "A bond to something that is not an element"},
    Code{"BG131", kError, "A bond to a port that does not exist"},
    Code{"BG132", kError, "Circular definition"},
    Code{"BG133", kError, "A submodel that cannot be unfolded"},
    Code{"BG135", kError, "An initial value of something that is not a state"},
    Code{"BG136", kError, "A submodel has no such parameter or signal"},
    Code{"BG137", kError, "Too many elements"},
    Code{"BG138", kError, "A port that is not a junction"},
    Code{"BG139", kError, "An index or a number of copies"},
    Code{"BG140", kError, "No such scene"},
    Code{"BG141", kError, "--set is not understood"},
    Code{"BG142", kError, "A constant that is not a finite number"},
    Code{"BG143", kError, "A scene that stops before it starts"},
    Code{"BG144", kError, "Invalid output times"},
    Code{"BG145", kError, "A store that stores nothing"},
    Code{"BG146", kError, "A tolerance or method that cannot be used"},
    Code{"BG147", kError, "A scene refers to something that does not exist"},
    Code{"BG148", kWarning, "An active resistor"},
    Code{"BG149", kWarning, "Nothing to record"},
    Code{"BG150", kError, "The reference cannot be read"},
    Code{"BG151", kError, "The reference is longer than the scene"},
    Code{"BG152", kError, "No such column to compare"},
    Code{"BG160", kWarning, "A unit that is not understood"},
    Code{"BG161", kError, "Units contradict each other"},
    Code{"BG162", kError, "One dimension in two units"},
    Code{"BG163", kWarning, "Effort times flow is not a power"},
    Code{"BG170", kError, "A file outside the model's folder"},
    Code{"BG171", kError, "A run that cannot be continued"},
    Code{"BG173", kError, "No such mode"},
    Code{"BG180", kWarning, "An unstable store"},
    Code{"BG181", kError, "A unit after a number"},
    Code{"BG182", kWarning, "A power of the effort e"},
    Code{"BG183", kError, "An initial effort or flow that does not determine what is stored"},
    Code{"BG184", kError, "Two initial values for one store"},
    Code{"BG185", kError, "A quantity that an event cannot set"},
    Code{"BG186", kError, "A sampling time that is not positive, or too short"},
    Code{"BG187", kWarning, "A sampling time longer than the scene"},
    Code{"BG190", kError, "A parameter file sets something that does not exist"},
    Code{"BG191", kError, "A parameter file has another unit"},
    Code{"BG192", kError, "Not a quantity that can be recorded"},
    Code{"BG201", kError, "Port bonded twice"},
    Code{"BG202", kError, "Port without a bond"},
    Code{"BG203", kError, "Ports of a TF or GY not distinguished"},
    Code{"BG204", kError, "Element without bonds"},
    Code{"BG205", kError, "Bond from an element to itself"},
    Code{"BG206", kWarning, "The graph has unconnected parts"},
    Code{"BG207", kError, "A detector that would act on the model"},
    Code{"BG301", kError, "Effort conflict"},
    Code{"BG302", kError, "Flow conflict"},
    Code{"BG303", kError, "No bond sets a junction's effort or flow"},
    Code{"BG304", kError, "A TF or GY with contradictory strokes"},
    Code{"BG305", kError, "A law cannot be solved for the required variable"},
    Code{"BG306", kWarning, "A field whose laws are not reciprocal"},
    Code{"BG402", kError, "Derivative of a jump"},
    Code{"BG403", kError, "Too many derivatives in a row"},
    Code{"BG404", kError, "An event that sets what others determine"},
    Code{"BG405", kError, "An initial value contradicts the states that determine it"},
    Code{"BG406", kError, "No such input for a linearization"},
    Code{"BG407", kError, "The system cannot be linearized at this point"},
    Code{"BG408", kError, "No derivative: a kink, a jump or the border of a condition at this point"},
    Code{"BG409", kError, "Too many states for poles and zeros"},
    Code{"BG410", kError, "An output that does not depend on the input"},
    Code{"BG411", kError, "A structurally singular loop"},
    Code{"BG412", kError, "No steady state was found"},
    Code{"BG413", kError, "No such parameter for a sensitivity"},
    Code{"BG414", kError, "A sensitivity that does not exist or is not found"},
    Code{"BG415", kError, "A value that cannot be fitted"},
    Code{"BG416", kError, "A range that cannot be fitted within"},
    Code{"BG417", kError, "Data that cannot be fitted to"},
    Code{"BG418", kError, "Nothing to compare"},
    Code{"BG419", kError, "A value without influence"},
    Code{"BG420", kError, "A fit that cannot begin"},
    Code{"BG421", kError, "Fitted values that cannot be written"},
    Code{"BG601", kError, "A law gives a value that is not finite"},
    Code{"BG602", kError, "A loop has no solution"},
    Code{"BG603", kError, "A singular loop"},
    Code{"BG604", kError, "A condition switches without end"},
    Code{"BG605", kError, "The step size goes to zero"},
    Code{"BG606", kError, "The run was interrupted"},
    Code{"BG607", kError, "The limit of steps was reached"},
    Code{"BG608", kError, "A table is read outside its data"},
    Code{"BG609", kError, "The tolerance is beyond double precision"},
    Code{"BG610", kError, "A method that cannot be used on this system"},
    Code{"BG611", kError, "No reference for the measurement"},
    Code{"BG612", kError, "An accuracy that is not reached or cannot be verified"},
    Code{"BG613", kError, "A denominator reaches zero"},
    Code{"BG614", kError, "A store is too fast for the scene"},
    Code{"BG615", kError, "A pulse too narrow for double precision"},
    Code{"BG616", kWarning, "A slow run"},
    Code{"BG617", kError, "A run that would not end"},
    Code{"BG618", kError, "The limit of time was reached"},
    Code{"BG619", kError, "A mode that the graph does not allow"},
    Code{"BG620", kError, "A jump that cannot be found"},
    Code{"BG621", kError, "A jump that creates energy"},
    Code{"BG622", kError, "Diodes or contacts with no possible sides"},
    Code{"BG623", kError, "Events that accumulate"},
    Code{"BG624", kError, "Two events that set one store at once"},
    Code{"BG625", kError, "A contact beyond its gap"},
    Code{"BG626", kError, "A restitution outside 0 to 1"},
    Code{"BG627", kError, "Impacts that accumulate"},
    Code{"BG628", kError, "More events than the scene allows"},
    Code{"BG629", kError, "A delay that cannot be followed"},
    Code{"BG710", kError, "A reduction without outputs"},
    Code{"BG711", kError, "An error below the solver's own"},
    Code{"BG712", kError, "No such element to keep"},
};

constexpr bool codes_increase() {
  for (std::size_t i = 1; i < kCodes.size(); ++i)
    if (!(kCodes[i - 1].code < kCodes[i].code)) return false;
  return true;
}
static_assert(codes_increase());

}  // namespace

const Code& code_row(std::string_view code) {
  const auto* row = std::lower_bound(kCodes.begin(), kCodes.end(), code,
                                     [](const Code& at, std::string_view wanted) { return at.code < wanted; });
  if (row == kCodes.end() || row->code != code) throw std::logic_error("there is no code " + std::string(code));
  return *row;
}

Diagnostic diagnostic_of(std::string_view code, std::string situation, std::optional<Place> place, std::string rule,
                         std::string help, std::vector<Note> notes) {
  return {code_row(code).severity, std::string(code), std::move(situation), place,
          std::move(notes),        std::move(rule),   std::move(help)};
}

}  // namespace bgsim
