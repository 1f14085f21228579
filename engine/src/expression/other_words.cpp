#include "expression/other_words.hpp"

#include <algorithm>
#include <array>

#include "base/text.hpp"
#include "expression/language.hpp"

namespace bgsim {
namespace {

struct Word {
  std::string_view other;
  const char* help;
};

template <std::size_t N>
std::string help_for(const std::array<Word, N>& words, std::string_view name) {
  const auto* found = std::find_if(words.begin(), words.end(), [&](const Word& word) { return word.other == name; });
  return found == words.end() ? std::string() : found->help;
}

const Function* function_named(std::string_view name) {
  const auto* found =
      std::find_if(kFunctions.begin(), kFunctions.end(), [&](const Function& f) { return f.name == name; });
  return found == kFunctions.end() ? nullptr : found;
}

constexpr const char* kIntegral =
    "an integral is a separate signal: \"x\": { \"integral\": \"body.f\", \"initial\": 0 } among \"signals\"; then "
    "use its name x";
constexpr const char* kDelay =
    "there is no delay: values are those of the time t; a first-order lag \"y\": { \"integral\": \"(u - y)/T\", "
    "\"initial\": 0 } among \"signals\" is the usual approximation";
constexpr const char* kNoRandom = "there are no random numbers: put measured or prepared data into a table(...)";
constexpr const char* kTable = "measured data are read with table(\"file.csv\", \"column\", x)";
constexpr const char* kSwitch = "write if(condition, then, otherwise)";
constexpr const char* kPlain = "leave it out: write its argument alone";
constexpr const char* kLimit = "write min(max(x, low), high)";
constexpr const char* kDer = "write der(x) for the time derivative of x";
constexpr const char* kNoMemory = "expressions have no memory of earlier times: write what holds at the time t";

/// In small letters. Functions that are only spelt otherwise are in kSpelling.
constexpr std::array kFunctionWords{
    Word{"int", kIntegral},
    Word{"integral", kIntegral},
    Word{"integrate", kIntegral},
    Word{"integ", kIntegral},
    Word{"integrator", kIntegral},
    Word{"cumtrapz", kIntegral},
    Word{"idt", kIntegral},
    Word{"resint", kIntegral},
    Word{"delay", kDelay},
    Word{"tdelay", kDelay},
    Word{"deadtime", kDelay},
    Word{"transportdelay", kDelay},
    Word{"pow", "write a^b"},
    Word{"power", "write a^b"},
    Word{"mpower", "write a^b"},
    Word{"sqr", "write x^2"},
    Word{"square", "write x^2"},
    Word{"cube", "write x^3"},
    Word{"root", "write x^(1/n), sqrt(x) or cbrt(x)"},
    Word{"nthroot", "write x^(1/n), or cbrt(x)"},
    Word{"inv", "write 1/x"},
    Word{"exp10", "write 10^x"},
    Word{"exp2", "write 2^x"},
    Word{"log2", "write log(x)/log(2)"},
    Word{"sec", "write 1/cos(x)"},
    Word{"csc", "write 1/sin(x)"},
    Word{"cot", "write 1/tan(x)"},
    Word{"sinc", "write sin(x)/x"},
    Word{"sind", "write sin(x*pi/180): angles are in rad"},
    Word{"cosd", "write cos(x*pi/180): angles are in rad"},
    Word{"tand", "write tan(x*pi/180): angles are in rad"},
    Word{"deg2rad", "write x*pi/180"},
    Word{"radians", "write x*pi/180"},
    Word{"rad2deg", "write x*180/pi"},
    Word{"degrees", "write x*180/pi"},
    Word{"ramp", "write max(t - t0, 0) for a ramp that begins at t0"},
    Word{"pulse", "write step(t - t1) - step(t - t2) for a pulse from t1 to t2"},
    Word{"rect", "write step(t - t1) - step(t - t2) for a pulse from t1 to t2"},
    Word{"squarewave", "write sign(sin(2*pi*f*t)) for a square wave of frequency f"},
    Word{"sawtooth", "write t*f - floor(t*f) for a sawtooth of frequency f"},
    Word{"dirac", "an impulse is a jump of a stored quantity: give it as an initial value"},
    Word{"delta", "an impulse is a jump of a stored quantity: give it as an initial value"},
    Word{"sat", kLimit},
    Word{"saturate", kLimit},
    Word{"saturation", kLimit},
    Word{"clip", kLimit},
    Word{"clamp", kLimit},
    Word{"limit", kLimit},
    Word{"limiter", kLimit},
    Word{"deadzone", "write x - min(max(x, -d), d)"},
    Word{"fix", "write sign(x)*floor(abs(x))"},
    Word{"trunc", "write sign(x)*floor(abs(x))"},
    Word{"frac", "write x - floor(x)"},
    Word{"rem", "write x - y*sign(x/y)*floor(abs(x/y))"},
    Word{"norm", "write hypot(x, y), or sqrt(x^2 + y^2 + z^2)"},
    Word{"ifelse", kSwitch},
    Word{"iif", kSwitch},
    Word{"ite", kSwitch},
    Word{"cond", kSwitch},
    Word{"where", kSwitch},
    Word{"piecewise", kSwitch},
    Word{"switch", kSwitch},
    Word{"choose", kSwitch},
    Word{"xor", "write (a and not b) or (b and not a)"},
    Word{"ddt", kDer},
    Word{"diff", kDer},
    Word{"deriv", kDer},
    Word{"derivative", kDer},
    Word{"d", kDer},
    Word{"dt", kDer},
    Word{"dot", kDer},
    Word{"data", kTable},
    Word{"lookup", kTable},
    Word{"interp", kTable},
    Word{"interp1", kTable},
    Word{"interp1d", kTable},
    Word{"interpolate", kTable},
    Word{"table1d", kTable},
    Word{"csv", kTable},
    Word{"spline", "write table(\"file.csv\", \"column\", x, spline)"},
    Word{"rand", kNoRandom},
    Word{"randn", kNoRandom},
    Word{"random", kNoRandom},
    Word{"noise", kNoRandom},
    Word{"gauss", kNoRandom},
    Word{"noevent", kPlain},
    Word{"smooth", kPlain},
    Word{"float", kPlain},
    Word{"double", kPlain},
    Word{"real", kPlain},
    Word{"pre", kNoMemory},
    Word{"hold", kNoMemory},
    Word{"edge", kNoMemory},
    Word{"hyst", kNoMemory},
    Word{"sample", "there is no sampling: floor(t/T)*T is the last multiple of T"},
    Word{"erf", "it is not in the language: put its values into a table(...)"},
    Word{"gamma", "it is not in the language: put its values into a table(...)"},
};

/// The same function under another name; the second names one of the language, if the language has it.
constexpr std::array kSpelling{
    Word{"ln", "log"},        Word{"loge", "log"},      Word{"lg", "log10"},       Word{"arcsin", "asin"},
    Word{"arccos", "acos"},   Word{"arctan", "atan"},   Word{"arctg", "atan"},     Word{"tg", "tan"},
    Word{"arctan2", "atan2"}, Word{"angle", "atan2"},   Word{"sgn", "sign"},       Word{"signum", "sign"},
    Word{"fabs", "abs"},      Word{"absolute", "abs"},  Word{"heaviside", "step"}, Word{"theta", "step"},
    Word{"unitstep", "step"}, Word{"ustep", "step"},    Word{"stepfun", "step"},   Word{"maximum", "max"},
    Word{"fmax", "max"},      Word{"minimum", "min"},   Word{"fmin", "min"},       Word{"squareroot", "sqrt"},
    Word{"arcsinh", "asinh"}, Word{"arsinh", "asinh"},  Word{"argsinh", "asinh"},  Word{"arccosh", "acosh"},
    Word{"arcosh", "acosh"},  Word{"argcosh", "acosh"}, Word{"arctanh", "atanh"},  Word{"artanh", "atanh"},
    Word{"argtanh", "atanh"}, Word{"fmod", "mod"},      Word{"modulo", "mod"},     Word{"remainder", "mod"},
    Word{"ceiling", "ceil"},  Word{"rint", "round"},    Word{"sh", "sinh"},        Word{"ch", "cosh"},
    Word{"th", "tanh"},       Word{"expo", "exp"},      Word{"cuberoot", "cbrt"},  Word{"nroot", "cbrt"},
};

/// In small letters.
constexpr std::array kNameWords{
    Word{"time", "the time is called t"},
    Word{"tau_time", "the time is called t"},
    Word{"inf", "there is no infinity: write a large number"},
    Word{"infinity", "there is no infinity: write a large number"},
    Word{"nan", "a value is a number: write the one that is meant"},
    Word{"true", "write a condition that always holds, such as 1 > 0"},
    Word{"false", "write a condition that never holds, such as 1 < 0"},
    Word{"g",
         "no constants of nature are built in: declare \"g\": { \"value\": 9.81, \"unit\": \"m/s^2\" } among "
         "\"parameters\""},
    Word{"gravity", "no constants of nature are built in: declare it among \"parameters\""},
    Word{"eps", "write the number, 2.2e-16"},
    Word{"dt", "steps are chosen by the integrator: write der(x) for a rate, and signals with \"integral\" for sums"},
};

/// "y'" for a pair of bytes that are one sign.
struct Sign {
  std::string_view text;
  const char* what;
  const char* help;
};

/// Longer ones before their beginnings.
constexpr std::array kSigns{
    Sign{"&&", "", "write and"},
    Sign{"&", "", "write and"},
    Sign{"||", "", "write or"},
    Sign{"|", "", "write or; the magnitude of x is abs(x)"},
    Sign{"!", "", "write not"},
    Sign{"~=", "", "write !="},
    Sign{"<>", "", "write !="},
    Sign{"=>", "", "write >="},
    Sign{"=<", "", "write <="},
    Sign{":=", "", "a value is the right side alone; write == to compare"},
    Sign{"+=", "", "a value is the right side alone"},
    Sign{"-=", "", "a value is the right side alone"},
    Sign{"=", "", "write == to compare; a value is the right side of an equation alone"},
    Sign{"~", "", "write not"},
    Sign{"?", "", "write if(condition, then, otherwise)"},
    Sign{":", "", "write if(condition, then, otherwise) for a choice"},
    Sign{"**", "", "write ^ for a power"},
    Sign{".*", "", "write *: values are single numbers"},
    Sign{"./", "", "write /: values are single numbers"},
    Sign{".^", "", "write ^: values are single numbers"},
    Sign{".'", "", "leave it out: values are single numbers"},
    Sign{"'", "", "write der(x) for the time derivative of x"},
    Sign{"//", "", "there are no remarks and no whole-number division: write / or floor(a/b)"},
    Sign{"%", "", "write x/100 for per cent; the remainder of x/y is x - y*floor(x/y)"},
    Sign{";", "", "leave it out: a value is one expression"},
    Sign{"[", "",
         "values are single numbers, and only the name of a repeated element has an index, cell[3].q; write ( ) for "
         "parentheses"},
    Sign{"]", "", "write ( ) for parentheses"},
    Sign{"{", "", "write ( ) for parentheses"},
    Sign{"}", "", "write ( ) for parentheses"},
    Sign{"$", "", "remove it: names are written without it"},
    Sign{"@", "", "remove it: names are written without it"},
    Sign{"#", "", "leave it out: remarks go into \"about\""},
    Sign{"\\", "", "write / for a quotient"},
    Sign{"`", "", "remove it: names are written without it"},
    Sign{"\xC3\x97", "", "write *"},                                     // multiplication sign
    Sign{"\xC2\xB7", "", "write *"},                                     // middle dot
    Sign{"\xE2\x8B\x85", "", "write *"},                                 // dot operator
    Sign{"\xE2\x80\xA2", "", "write *"},                                 // bullet
    Sign{"\xE2\x88\x97", "", "write *"},                                 // asterisk operator
    Sign{"\xC3\xB7", "", "write /"},                                     // division sign
    Sign{"\xE2\x88\x95", "", "write /"},                                 // division slash
    Sign{"\xE2\x81\x84", "", "write /"},                                 // fraction slash
    Sign{"\xE2\x88\x92", "a minus sign (U+2212)", "type the hyphen -"},  // these look like the hyphen
    Sign{"\xE2\x80\x93", "a dash (U+2013)", "type the hyphen -"},
    Sign{"\xE2\x80\x94", "a dash (U+2014)", "type the hyphen -"},
    Sign{"\xE2\x80\x90", "a hyphen (U+2010)", "type the hyphen -"},
    Sign{"\xE2\x80\x91", "a hyphen (U+2011)", "type the hyphen -"},
    Sign{"\xEF\xBC\x8D", "a wide minus sign (U+FF0D)", "type the hyphen -"},
    Sign{"\xC2\xA0", "a no-break space (U+00A0)", "type a plain space"},
    Sign{"\xE2\x80\xAF", "a narrow no-break space (U+202F)", "type a plain space"},
    Sign{"\xE2\x80\x89", "a thin space (U+2009)", "type a plain space"},
    Sign{"\xE2\x80\x8B", "a space of no width (U+200B)", "delete it"},
    Sign{"\xEF\xBB\xBF", "a byte order mark (U+FEFF)", "delete it"},
    Sign{"\xE2\x80\x98", "", "write straight quotes: 'file.csv'"},
    Sign{"\xE2\x80\x99", "", "write straight quotes, 'file.csv'; the time derivative of x is der(x)"},
    Sign{"\xE2\x80\xB2", "", "write der(x) for the time derivative of x"},
    Sign{"\xE2\x80\x9C", "", "write straight quotes: 'file.csv'"},
    Sign{"\xE2\x80\x9D", "", "write straight quotes: 'file.csv'"},
    Sign{"\xE2\x80\x9E", "", "write straight quotes: 'file.csv'"},
    Sign{"\xC2\xAB", "", "write straight quotes: 'file.csv'"},
    Sign{"\xC2\xB2", "", "write ^2"},
    Sign{"\xC2\xB3", "", "write ^3"},
    Sign{"\xC2\xB9", "", "write powers with ^: x^-1"},
    Sign{"\xE2\x81\xBB", "", "write powers with ^: x^-1"},
    Sign{"\xE2\x81", "", "write powers with ^: x^4"},  // the other superscripts
    Sign{"\xE2\x82", "", "names have no subscripts: write x_0"},
    Sign{"\xC2\xBD", "", "write 0.5"},
    Sign{"\xC2\xBC", "", "write 0.25"},
    Sign{"\xE2\x88\x9A", "", "write sqrt(x)"},
    Sign{"\xE2\x89\xA4", "", "write <="},
    Sign{"\xE2\x89\xA5", "", "write >="},
    Sign{"\xE2\x89\xA0", "", "write !="},
    Sign{"\xE2\x88\xAB", "", kIntegral},
    Sign{"\xE2\x88\x9E", "", "there is no infinity: write a large number"},
    Sign{"\xE2\x88\x82", "", kDer},
    Sign{"\xC2\xB0", "", "angles are in rad: write x*pi/180"},
    Sign{"\xCF\x80", "", "write pi"},
};

std::size_t sign_length(std::string_view text) {
  std::size_t length = 1;
  while (length < text.size() && (static_cast<unsigned char>(text[length]) & 0xC0U) == 0x80U) ++length;
  return length;
}

/// Greek letters by their names, since names are written in ASCII.
std::string greek(std::string_view letter) {
  static constexpr std::array<std::string_view, 25> kNames{
      "alpha", "beta",   "gamma",   "delta", "epsilon", "zeta",    "eta",  "theta", "iota",
      "kappa", "lambda", "mu",      "nu",    "xi",      "omicron", "pi",   "rho",   "sigma",
      "sigma", "tau",    "upsilon", "phi",   "chi",     "psi",     "omega"};
  if (letter.size() != 2) return {};
  const auto point =
      ((static_cast<unsigned char>(letter[0]) & 0x1FU) << 6U) | (static_cast<unsigned char>(letter[1]) & 0x3FU);
  constexpr unsigned kAlpha = 0x3B1, kCapitalAlpha = 0x391;
  if (point >= kAlpha && point < kAlpha + kNames.size()) return std::string(kNames[point - kAlpha]);
  if (point >= kCapitalAlpha && point < kCapitalAlpha + kNames.size()) {
    std::string name(kNames[point - kCapitalAlpha]);
    name[0] = static_cast<char>(name[0] - 'a' + 'A');
    return name;
  }
  return {};
}

}  // namespace

std::string instead_of_function(std::string_view name) {
  const auto dot = name.rfind('.');
  const std::string_view last = dot == std::string_view::npos ? name : name.substr(dot + 1);
  const std::string small = lower_case(last);
  const std::string spelling = help_for(kSpelling, small);
  for (const std::string& known : {std::string(last), small, spelling})
    if (const Function* function = function_named(known); function != nullptr && known != name)
      return "write " + std::string(function->usage) +
             (dot != std::string_view::npos ? ": functions have no prefix" : "");
  return help_for(kFunctionWords, small);
}

std::string instead_of_name(std::string_view name, std::string_view rest) {
  const auto dot = name.rfind('.');
  const std::string small = lower_case(dot == std::string_view::npos ? name : name.substr(dot + 1));
  if (small == "pi" && name != "pi") return "write pi";
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  if (rest.starts_with("/dt") || rest.starts_with("/ dt"))
    return name.size() > 1 && name[0] == 'd' ? "write der(" + std::string(name.substr(1)) + ")" : kDer;
  if (small == "e" && rest.starts_with("^")) return "write exp(x) for e^x";
  if (small == "exp" && rest.starts_with("^")) return "write exp(x)";
  if (dot != std::string_view::npos) return {};
  if (name == "G") return {};  // a conductance or a shear modulus more often than gravity
  return help_for(kNameWords, small);
}

std::optional<ForeignSign> foreign_sign(std::string_view text) {
  if (text.empty()) return std::nullopt;
  for (const Sign& sign : kSigns)
    if (text.starts_with(sign.text)) {
      const bool ascii = static_cast<unsigned char>(text[0]) < 0x80;
      return ForeignSign{ascii ? sign.text.size() : sign_length(text), sign.what, sign.help};
    }
  if (static_cast<unsigned char>(text[0]) < 0x80) return std::nullopt;
  const std::size_t length = sign_length(text);
  const std::string name = greek(text.substr(0, length));
  return ForeignSign{length,
                     {},
                     name.empty() ? "names consist of the letters a-z and A-Z, digits and underscores"
                                  : "names have no Greek letters: write " + name};
}

}  // namespace bgsim
