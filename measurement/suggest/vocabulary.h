// What a formula of one stage may be made of.
#pragma once

#include <string>
#include <vector>

#include "effects/model.h"
#include "measurement/suggest/term.h"

namespace seam::measurement {

// What formulas of one stage may be made of.
struct Vocabulary {
  std::string stage;
  std::vector<std::string> outputs;
  std::vector<std::string> variables;  // Of curves.
  std::vector<Term> terms;
  // What curves multiply: terms with "@" in their pieces.
  std::vector<Term> carriers;
  // Where nuisances follow what a carrier does by itself, values of a variable are those of the
  // covariate whose name begins so: "target " of x and y.
  std::string prefix = {};
};

// The stages whose formulas act on a kind, beside this model; `columns` are the further columns of
// a servo log.
std::vector<Vocabulary> vocabularies(effects::Kind kind, const effects::Model& model,
                                     const std::vector<std::string>& columns);

}  // namespace seam::measurement
