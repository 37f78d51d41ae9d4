#include "measurement/suggest/vocabulary.h"

#include <fmt/format.h>

#include "effects/questions.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// Products of up to `degree` of the variables, each in the given order; the empty product is "1".
std::vector<std::string> products(const std::vector<std::string>& variables, int degree) {
  std::vector<std::string> all = {"1"}, last = {""};
  std::vector<size_t> first = {0};
  for (int d = 0; d < degree; ++d) {
    std::vector<std::string> next;
    std::vector<size_t> next_first;
    for (size_t i = 0; i < last.size(); ++i) {
      for (size_t k = first[i]; k < variables.size(); ++k) {
        next.push_back(last[i].empty() ? variables[k] : last[i] + " * " + variables[k]);
        next_first.push_back(k);
      }
    }
    all.insert(all.end(), next.begin(), next.end());
    last = std::move(next), first = std::move(next_first);
  }
  return all;
}

void in_each_output(Vocabulary& vocabulary, const std::vector<std::string>& texts) {
  for (const std::string& output : vocabulary.outputs) {
    for (const std::string& text : texts) vocabulary.terms.push_back({.pieces = {{output, text}}});
  }
}

void append(std::vector<std::string>& list, const std::vector<std::string>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

// The same in several outputs, each with its own sign, for each factor.
void together(std::vector<Term>& terms, const std::vector<Term::Piece>& pieces,
              const std::vector<std::string>& factors) {
  for (const std::string& factor : factors) {
    Term term{.pieces = pieces};
    for (Term::Piece& piece : term.pieces) {
      if (factor != "1") piece.text += " * " + factor;
    }
    terms.push_back(std::move(term));
  }
}

// A curve by itself in each of these outputs.
std::vector<Term> curves_in(const std::vector<std::string>& outputs) {
  std::vector<Term> carriers;
  for (const std::string& output : outputs) carriers.push_back({.pieces = {{output, "@"}}});
  return carriers;
}

// Further columns of a set, by which anything may grow: each times these ("1": alone).
std::vector<std::string> by_columns(const std::vector<std::string>& columns,
                                    const std::vector<std::string>& factors) {
  std::vector<std::string> texts;
  for (const std::string& column : columns) {
    for (const std::string& factor : factors)
      texts.push_back(factor == "1" ? column : column + " * " + factor);
  }
  return texts;
}

Vocabulary geometry(const std::vector<std::string>& columns) {
  Vocabulary all{.stage = "geometry",
                 .outputs = {"u", "v"},
                 .variables = {"u", "v", "t"},
                 .covariates = {{"u", "column"}, {"v", "row"}, {"t", "time"}},
                 .channels = {{"u", "u_px"}, {"v", "v_px"}}};
  // Along the radius, and across it (a turn of the image): one coefficient for both axes.
  together(all.terms, {{"u", "(u - cx)"}, {"v", "(v - cy)"}},
           {"t", "t * t", "r2", "r2 * t", "r2 * r2", "r2 * r2 * r2", "sign(x)", "sign(y)", "1"});
  together(all.terms, {{"u", "(u - cx)"}, {"v", "(v - cy)"}}, by_columns(columns, {"1", "r2"}));
  together(all.terms, {{"u", "(cy - v)"}, {"v", "(u - cx)"}}, {"t", "r2"});
  all.carriers = curves_in(all.outputs);
  together(all.carriers, {{"u", "(u - cx)"}, {"v", "(v - cy)"}}, {"@"});
  std::vector<std::string> texts = products({"x", "y", "t"}, 3);
  append(texts, {"r2 * x * x", "r2 * x * y", "r2 * y * y", "r2 * r2 * x", "r2 * r2 * y", "sign(x)",
                 "sign(y)", "sign(x) * y", "sign(y) * x", "abs(x)", "abs(y)", "1 / (1 + t)"});
  append(texts, by_columns(columns, {"1", "x", "y"}));
  append(all.variables, columns);
  in_each_output(all, texts);
  // Detectors of corners err by the place within a pixel.
  for (const std::string& output : all.outputs) {
    for (const char* wave : {"sin", "cos"})
      all.terms.push_back({.pieces = {{output, fmt::format("{}(2 * pi * {})", wave, output)}}});
  }
  return all;
}

Vocabulary joint(const std::vector<std::string>& columns) {
  Vocabulary all{.stage = "joint", .outputs = {"q"}, .variables = {"q", "t"}};
  append(all.variables, columns);
  all.carriers = curves_in(all.outputs);
  std::vector<std::string> texts = products({"q", "t"}, 3);
  append(texts, {"rate", "rate * q", "rate * t", "rate * rate", "rate * abs(rate)", "sign(rate)",
                 "sign(rate) * q", "sign(rate) * t", "sign(rate) * q * q", "abs(rate)", "abs(q)",
                 "sign(q)", "sin(q)", "cos(q)", "sin(q) * t", "cos(q) * t", "(command - q)",
                 "sign(command - q)", "sqrt(abs(rate)) * sign(rate)"});
  append(texts, by_columns(columns, {"1", "q", "t", "rate", "sign(rate)", "sin(q)", "cos(q)"}));
  in_each_output(all, texts);
  return all;
}

// What pushes a motor: loads, friction by the place, a motor that is stronger here or weaker later.
Vocabulary torque() {
  Vocabulary all{
      .stage = "joint",
      .outputs = {"torque"},
      .variables = {"q", "t"},
      .place = {.arrives = true, .variables = {"q", "rate", "t"}, .outputs = {"torque"}}};
  std::vector<std::string> texts = products({"q", "rate", "t"}, 3);
  append(texts, {"rate * abs(rate)", "sign(rate)", "sign(rate) * q", "sign(rate) * q * q",
                 "sign(rate) * t", "abs(rate)", "sin(q)", "cos(q)", "sin(2 * q)", "cos(2 * q)",
                 "drive * t", "drive * q", "drive * q * q", "drive * abs(drive)", "sign(drive)"});
  in_each_output(all, texts);
  for (const char* factor : {"@", "drive * @", "sign(rate) * @"})
    all.carriers.push_back({.pieces = {{"torque", factor}}});
  return all;
}

// Poses of the views take what moves all points alike, and what tilts the board.
Vocabulary target() {
  Vocabulary all{.stage = "target",
                 .outputs = {"z"},
                 .variables = {"x", "y"},
                 .place = {.variables = {"x", "y", "z"}, .outputs = {"x", "y", "z"}}};
  in_each_output(all, products({"x", "y"}, 3));
  in_each_output(all, {"abs(x)", "abs(y)", "abs(x) * y", "abs(y) * x", "x * x * y * y"});
  for (const char* output : {"x", "y"}) {
    for (const std::string& text : products({"x", "y"}, 2))
      all.terms.push_back({.pieces = {{output, text}}});
  }
  all.carriers = curves_in(all.outputs);
  return all;
}

// The gain takes what is the same everywhere and at all times.
Vocabulary light() {
  Vocabulary all{.stage = "light", .outputs = {"gain"}, .variables = {"u", "v", "rho", "t"}};
  std::vector<std::string> texts = products({"u", "v", "t"}, 3);
  std::erase(texts, "1");
  append(texts, {"rho^2", "rho^4", "rho^6", "rho^2 * t", "t * t * t"});
  in_each_output(all, texts);
  all.carriers = curves_in(all.outputs);
  all.carriers.push_back({.pieces = {{"gain", "t * @"}}});
  return all;
}

Vocabulary detector(const std::vector<std::string>& columns) {
  Vocabulary all{.stage = "detector",
                 .outputs = {"range", "bearing"},
                 .variables = {"range", "bearing", "speed", "turn", "t"}};
  all.carriers = curves_in(all.outputs);
  std::vector<std::string> texts = products({"range", "bearing", "t"}, 3);
  for (const std::string& text : products({"speed", "turn"}, 2)) {
    if (text != "1") texts.push_back(text);
  }
  append(texts, {"sign(bearing)", "abs(bearing)", "sign(bearing) * range", "abs(bearing) * range",
                 "sqrt(range)", "1 / range"});
  append(texts, by_columns(columns, {"1", "range", "bearing"}));
  append(all.variables, columns);
  in_each_output(all, texts);
  return all;
}

Vocabulary locomotion(const std::vector<std::string>& columns) {
  Vocabulary all{.stage = "locomotion",
                 .outputs = {"vx", "vy", "omega"},
                 .variables = {"x", "y", "theta", "way", "t"},
                 .covariates = {{"x", "x_moved"},
                                {"y", "y_moved"},
                                {"theta", "heading"},
                                {"way", "distance"},
                                {"t", "time"}}};
  std::vector<std::string> texts = products({"vx", "vy", "omega"}, 3);
  append(texts, {"vx * t", "vy * t", "omega * t", "abs(vx)", "abs(vy)", "abs(omega)", "sign(vx)",
                 "sign(vy)", "sign(omega)", "vx * abs(vx)", "vy * abs(vy)", "omega * abs(omega)",
                 "vx * abs(omega)", "vx * sin(theta)", "vx * cos(theta)", "omega * sin(theta)",
                 "omega * cos(theta)", "sin(theta)", "cos(theta)"});
  append(texts, by_columns(columns, {"vx", "vy", "omega"}));
  append(all.variables, columns);
  std::erase(texts, "1");  // A body that stands does not creep.
  in_each_output(all, texts);
  // The whole motion, the way, aside from it, and along the floor's own axes.
  const std::string speed = "sqrt(vx * vx + vy * vy)";
  const std::vector<Term::Piece> way = {{"vx", "vx"}, {"vy", "vy"}};
  const std::vector<Term::Piece> motion = {{"vx", "vx"}, {"vy", "vy"}, {"omega", "omega"}};
  const std::vector<std::string> factors = {"1",          "t",          speed,       "omega",
                                            "abs(omega)", "sin(theta)", "cos(theta)"};
  together(all.terms, way, factors);
  together(all.terms, way, columns);
  together(all.terms, motion, {"1", "t", speed, "abs(omega)"});
  together(all.terms, {{"vx", "vy", -1}, {"vy", "vx"}}, factors);
  together(all.terms, {{"vx", "cos(theta)"}, {"vy", "sin(theta)", -1}}, {speed});
  together(all.terms, {{"vx", "sin(theta)"}, {"vy", "cos(theta)"}}, {speed});
  together(all.carriers, way, {"@"});
  together(all.carriers, motion, {"@"});
  together(all.carriers, {{"omega", "omega"}}, {"@"});
  return all;
}

}  // namespace

std::vector<Vocabulary> vocabularies(effects::Kind kind, const effects::Model& model,
                                     const std::vector<std::string>& columns) {
  std::vector<Vocabulary> all;
  for (const effects::Stage stage : effects::kind_facts(kind).formula_stages) {
    switch (stage) {
      case effects::Stage::geometry:
        all.push_back(geometry(columns));
        break;
      case effects::Stage::target:
        all.push_back(target());
        break;
      case effects::Stage::joint:
        all.push_back(joint(columns));
        if (effects::has_base(model, effects::Base::motor)) all.push_back(torque());
        break;
      case effects::Stage::light:
        all.push_back(light());
        break;
      case effects::Stage::detector:
        all.push_back(detector(columns));
        break;
      case effects::Stage::locomotion:
        all.push_back(locomotion(columns));
        break;
      default:
        SEAM_CHECK(false, "no words for formulas of stage {}", to_string(stage));
    }
  }
  return all;
}

}  // namespace seam::measurement
