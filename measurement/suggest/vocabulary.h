// What a formula of one stage may be made of.
#pragma once

#include <map>
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
  // What a set's covariates call the variables, and its channels the outputs that are residuals
  // themselves. Values of variables are taken from there: nuisances may follow what a carrier does.
  std::map<std::string, std::string> covariates = {}, channels = {};
  // The variables and outputs of a problem's place (FieldPlace) on which formulas of this stage act
  // in place of channels, in its order, and whether they act on all that comes later.
  struct Place {
    bool arrives = false;
    std::vector<std::string> variables, outputs;
  };
  Place place = {};
};

// The stages whose formulas act on a kind, beside this model; `columns` are the further columns of
// a servo log.
std::vector<Vocabulary> vocabularies(effects::Kind kind, const effects::Model& model,
                                     const std::vector<std::string>& columns);

}  // namespace seam::measurement
