#include "effects/formulas/formula.h"

#include <muParser.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cmath>
#include <map>
#include <string_view>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

double add(double a, double b) {
  return a + b;
}
double subtract(double a, double b) {
  return a - b;
}
double multiply(double a, double b) {
  return a * b;
}
double divide(double a, double b) {
  return a / b;
}
double less(double a, double b) {
  return a < b;
}
double greater(double a, double b) {
  return a > b;
}
double at_most(double a, double b) {
  return a <= b;
}
double at_least(double a, double b) {
  return a >= b;
}
double equal(double a, double b) {
  return a == b;
}
double unequal(double a, double b) {
  return a != b;
}
double both(double a, double b) {
  return a != 0 && b != 0;
}
double either(double a, double b) {
  return a != 0 || b != 0;
}
double sign_of(double a) {
  return a > 0 ? 1 : a < 0 ? -1 : 0;
}
double square_root(double a) {
  return std::sqrt(a);
}
double absolute(double a) {
  return std::abs(a);
}
double round_down(double a) {
  return std::floor(a);
}
double nearest(double a) {
  return std::round(a);
}
double hyperbolic_tangent(double a) {
  const double e = maths::expm1(-2 * std::abs(a));
  return std::copysign(-e / (e + 2), a);
}
double smaller(double a, double b) {
  return a < b ? a : b;
}
double larger(double a, double b) {
  return a > b ? a : b;
}
double choose(double condition, double then, double otherwise) {
  return condition != 0 ? then : otherwise;
}

// Powers with small whole exponents are products, exact in the same way everywhere.
double power(double base, double exponent) {
  if (exponent == std::floor(exponent) && std::abs(exponent) <= 16) {
    double product = 1;
    for (int i = 0; i < std::abs(exponent); ++i) product *= base;
    return exponent < 0 ? 1 / product : product;
  }
  return maths::pow(base, exponent);
}

// muParser with none of its own arithmetic: its powers and functions are those of the C library,
// whose last bits depend on the CPU.
std::unique_ptr<mu::Parser> bare_parser(Names names) {
  auto parser = std::make_unique<mu::Parser>();
  if (names == Names::dotted) {
    parser->DefineNameChars("0123456789_abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.");
  }
  parser->ClearFun();
  parser->ClearConst();
  parser->EnableBuiltInOprt(false);
  const struct {
    const char* name;
    double (*function)(double, double);
    unsigned priority;
    mu::EOprtAssociativity side;
  } operators[] = {
      {"||", either, mu::prLOR, mu::oaLEFT},      {"&&", both, mu::prLAND, mu::oaLEFT},
      {"<=", at_most, mu::prCMP, mu::oaLEFT},     {">=", at_least, mu::prCMP, mu::oaLEFT},
      {"==", equal, mu::prCMP, mu::oaLEFT},       {"!=", unequal, mu::prCMP, mu::oaLEFT},
      {"<", less, mu::prCMP, mu::oaLEFT},         {">", greater, mu::prCMP, mu::oaLEFT},
      {"+", add, mu::prADD_SUB, mu::oaLEFT},      {"-", subtract, mu::prADD_SUB, mu::oaLEFT},
      {"*", multiply, mu::prMUL_DIV, mu::oaLEFT}, {"/", divide, mu::prMUL_DIV, mu::oaLEFT},
      {"^", power, mu::prPOW, mu::oaRIGHT},
  };
  for (const auto& o : operators) parser->DefineOprt(o.name, o.function, o.priority, o.side, true);
  const struct {
    const char* name;
    double (*function)(double);
  } functions[] = {
      {"sin", maths::sin},   {"cos", maths::cos},
      {"tan", maths::tan},   {"asin", maths::asin},
      {"acos", maths::acos}, {"atan", maths::atan},
      {"exp", maths::exp},   {"log", maths::log},
      {"ln", maths::log},    {"tanh", hyperbolic_tangent},
      {"sqrt", square_root}, {"abs", absolute},
      {"sign", sign_of},     {"floor", round_down},
      {"round", nearest},
  };
  for (const auto& f : functions) parser->DefineFun(f.name, f.function);
  parser->DefineFun("atan2", maths::atan2);
  parser->DefineFun("pow", power);
  parser->DefineFun("min", smaller);
  parser->DefineFun("max", larger);
  parser->DefineFun("if", choose);
  parser->DefineConst("pi", maths::kPi);
  return parser;
}

// One thread's parser of one formula, with the variables that it reads.
struct Compiled {
  std::unique_ptr<mu::Parser> parser;
  std::vector<double> values;

  Compiled(const std::string& text, const std::vector<std::string>& variables, Names names)
      : parser(bare_parser(names)), values(variables.size(), 0) {
    for (size_t i = 0; i < variables.size(); ++i) parser->DefineVar(variables[i], &values[i]);
    parser->SetExpr(text);
  }
};

// This thread's of a formula.
Compiled& compiled_here(uint64_t id, const std::string& text,
                        const std::vector<std::string>& variables, Names names) {
  thread_local std::map<uint64_t, Compiled> compiled;
  auto found = compiled.find(id);
  if (found == compiled.end()) found = compiled.try_emplace(id, text, variables, names).first;
  return found->second;
}

std::atomic<uint64_t> next_id{1};

bool is_of_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
}

// Numbers, names and operators: what the time of an evaluation grows with.
size_t parts_in(const std::string& text) {
  constexpr std::string_view kNoOperators = " \t\r\n(),";
  size_t parts = 0;
  for (size_t at = 0; at < text.size();) {
    const size_t start = at;
    const bool number = std::isdigit(static_cast<unsigned char>(text[at])) != 0;
    const auto of_exponent = [&] {  // 1e-3
      return number && at > start && (text[at] == '-' || text[at] == '+') &&
             (text[at - 1] == 'e' || text[at - 1] == 'E');
    };
    while (at < text.size() && (is_of_word(text[at]) || of_exponent())) ++at;
    if (at == start) {
      const bool two = at + 1 < text.size() && (text[at + 1] == '=' || text[at + 1] == text[at]) &&
                       std::string_view("<>=!&|").find(text[at]) != std::string_view::npos;
      parts += kNoOperators.find(text[at]) == std::string_view::npos ? 1 : 0;
      at += two ? 2 : 1;
    } else {
      ++parts;
    }
  }
  return parts;
}

// The parser takes a NUL for the end.
void check_text(const std::string& text) {
  constexpr size_t kMostCharacters = 10'000;
  if (text.size() > kMostCharacters)
    throw InputError(
        fmt::format("formula of {} characters, expected {} at most", text.size(), kMostCharacters));
  constexpr size_t kMostParts = 1000;
  if (const size_t parts = parts_in(text); parts > kMostParts)
    throw InputError(fmt::format(
        "formula of {} numbers, names and operators, expected {} at most: a fit evaluates it for "
        "each row, again and again",
        parts, kMostParts));
  const auto odd = std::find_if(text.begin(), text.end(), [](char c) {
    return c != '\t' && c != '\n' && c != '\r' &&
           (static_cast<unsigned char>(c) < 0x20 || c == 0x7F);
  });
  if (odd != text.end())
    throw InputError(fmt::format("formula '{}...': character {} is a control character (code {})",
                                 text.substr(0, static_cast<size_t>(odd - text.begin())),
                                 odd - text.begin() + 1, static_cast<int>(*odd)));
}

// As errors show it.
std::string shortened(const std::string& text) {
  constexpr size_t kMost = 80;
  return text.size() > kMost ? text.substr(0, kMost) + "..." : text;
}

[[noreturn]] void fail(const std::string& text, const mu::Parser::exception_type& error) {
  std::string why = error.GetMsg();
  if (error.GetCode() == mu::ecNAME_CONFLICT)
    why = "a parameter has a name that formulas have already (pi, or a function's)";
  for (const auto& [word, sign] : {std::pair("and", "&&"), {"or", "||"}}) {
    if (error.GetToken() == word) why = fmt::format("write {} for '{}'", sign, word);
  }
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) why = "the formula is empty";
  throw InputError(fmt::format("formula '{}': {}", shortened(text), shortened(why)));
}

}  // namespace

Formula::Formula(const std::string& text, std::vector<std::string> variables, Names names)
    : text_(text), variables_(std::move(variables)), names_(names), id_(next_id++) {
  for (const std::string& name : names_in(text, names)) {
    if (std::find(variables_.begin(), variables_.end(), name) == variables_.end()) {
      throw InputError(fmt::format("formula '{}': unknown name '{}'{}", shortened(text),
                                   shortened(name), suggestion_for(name, variables_)));
    }
  }
  const std::vector<double> ones(variables_.size(), 1);
  (*this)(ones);
  // Of several formulas with commas between the parser takes the last: "0,5 * x" would be 5 * x.
  const int count = compiled_here(id_, text_, variables_, names_).parser->GetNumResults();
  if (count != 1)
    throw InputError(fmt::format(
        "formula '{}': found {} formulas with commas between, expected one (a decimal has a point)",
        shortened(text_), count));
}

double Formula::operator()(std::span<const double> values) const {
  try {
    Compiled& compiled = compiled_here(id_, text_, variables_, names_);
    SEAM_CHECK(values.size() == variables_.size(), "{} for {}", values.size(), variables_.size());
    std::copy(values.begin(), values.end(), compiled.values.begin());
    return compiled.parser->Eval();
  } catch (const mu::Parser::exception_type& error) {
    fail(text_, error);
  }
}

std::vector<std::string> Formula::names_in(const std::string& text, Names names) {
  check_text(text);
  try {
    const auto parser = bare_parser(names);
    parser->SetExpr(text);
    std::vector<std::string> found;
    for (const auto& [name, place] : parser->GetUsedVar()) found.push_back(name);
    return found;
  } catch (const mu::Parser::exception_type& error) {
    fail(text, error);
  }
}

}  // namespace seam::effects
