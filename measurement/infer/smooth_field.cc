#include "measurement/infer/smooth_field.h"

#include <algorithm>
#include <cmath>

#include "measurement/numerics/legendre.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using Columns = std::vector<std::vector<double>>;

// A basis by row, its weights in it, and the order of each of its functions: how fast it changes.
struct Basis {
  Columns values;
  std::vector<double> order;
};

constexpr int kWavesOfOne = 16;       // Half periods over the range of a single covariate.
constexpr int kDegreeOfTwo = 6;       // Of the polynomials of two.
constexpr int kDegreeOfParts = 2;     // Of those that each part has for itself.
constexpr size_t kMostColumns = 400;  // Of these in all: more are dear, and few parts show as much.

// Scaled to [-1, 1] over its range, angles left as they are; empty: constant or not known.
std::vector<double> scaled(const Covariate& covariate) {
  std::vector<double> x = covariate.values;
  if (!scale_to_range(x)) return {};
  return covariate.type == Covariate::Type::cyclic ? covariate.values : x;
}

// Waves of an angle; of a quantity a straight line and cosines without a slope at their ends.
Basis waves(const Covariate& covariate, const std::vector<double>& x) {
  Basis basis;
  const auto add = [&](double order, const auto& function) {
    basis.values.emplace_back(x.size());
    for (size_t i = 0; i < x.size(); ++i) basis.values.back()[i] = function(x[i]);
    basis.order.push_back(order);
  };
  if (covariate.type == Covariate::Type::cyclic) {
    for (int k = 1; k <= kWavesOfOne / 2; ++k) {
      add(2 * k - 1, [&](double a) { return std::sin(k * a); });
      add(2 * k - 1, [&](double a) { return std::cos(k * a); });
    }
    return basis;
  }
  add(1, [](double a) { return a; });
  for (int k = 1; k <= kWavesOfOne; ++k)
    add(k, [&](double a) { return std::cos(0.5 * maths::kPi * k * (a + 1)); });
  return basis;
}

// Legendre polynomials up to this degree; of an angle as many sines and cosines.
Columns polynomials(const Covariate& covariate, const std::vector<double>& x, int most) {
  Columns values(static_cast<size_t>(most) + 1, std::vector<double>(x.size(), 1));
  for (int k = 1; k <= most; ++k) {
    for (size_t i = 0; i < x.size(); ++i) {
      const double angle = (k + 1) / 2 * x[i];
      values[k][i] = covariate.type != Covariate::Type::cyclic ? legendre(k, x[i])
                     : k % 2 == 1                              ? std::sin(angle)
                                                               : std::cos(angle);
    }
  }
  return values;
}

Basis products(const Columns& one, const Columns& other) {
  Basis basis;
  for (size_t a = 0; a < one.size(); ++a) {
    for (size_t b = 0; b < other.size() && a + b < std::max(one.size(), other.size()); ++b) {
      if (a + b == 0) continue;
      basis.values.emplace_back(one[a].size());
      for (size_t i = 0; i < one[a].size(); ++i) basis.values.back()[i] = one[a][i] * other[b][i];
      basis.order.push_back(static_cast<double>(a + b));
    }
  }
  return basis;
}

Basis basis_of(const SmoothField& field) {
  std::vector<std::vector<double>> x;
  for (const Covariate* covariate : field.covariates) {
    x.push_back(scaled(*covariate));
    if (x.back().empty()) return {};
  }
  const bool has_parts = !field.place->part_of_row.empty();
  const int most = has_parts ? kDegreeOfParts : kDegreeOfTwo;
  Basis basis;
  if (x.size() == 1 && !has_parts) {
    basis = waves(*field.covariates[0], x[0]);
  } else {
    const Columns level = {std::vector<double>(x[0].size(), 1)};
    basis = products(polynomials(*field.covariates[0], x[0], most),
                     x.size() == 1 ? level : polynomials(*field.covariates[1], x[1], most));
  }
  if (field.place->has_level) {
    basis.values.emplace_back(x[0].size(), 1);
    basis.order.push_back(0);
  }
  return basis;
}

// What a field may depend on.
bool is_quantity(const Covariate& covariate) {
  return !covariate.of_measured &&
         (covariate.type == Covariate::Type::smooth || covariate.type == Covariate::Type::cyclic);
}

// The root mean square of all slopes of a place where there are any.
double size_of(const FieldPlace& place) {
  double sum2 = 0, count = 0;
  for (const auto& slope : place.slopes) {
    for (const double value : slope) sum2 += value * value, count += value != 0;
  }
  return count > 0 ? std::sqrt(sum2 / count) : 1;
}

}  // namespace

std::vector<FieldPlace> places_in_channels(const Problem& problem, const Evaluation& here) {
  const Facts& facts = problem.facts();
  const std::vector<double> none(facts.scalars(), 0);
  FieldPlace channels{.slopes = Columns(facts.channels.size(), none),
                      .covariates = facts.covariates};
  FieldPlace combined{.slopes = Columns(facts.combined.size(), none),
                      .covariates = facts.covariates};
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (!here.used[i]) continue;
    const int channel = facts.channel_of[i];
    const auto row = static_cast<size_t>(facts.row_of[i]);
    const double unit = facts.channels[channel].noise / here.sigma[i];
    channels.slopes[channel][i] = unit;
    for (size_t k = 0; k < facts.combined.size(); ++k) {
      const CombinedChannel& made = facts.combined[k];
      if (channel == made.channel_a) combined.slopes[k][i] = unit * made.weight_a[row];
      if (channel == made.channel_b) combined.slopes[k][i] = unit * made.weight_b[row];
    }
  }
  std::vector<FieldPlace> places = {std::move(channels)};
  if (!facts.combined.empty()) places.push_back(std::move(combined));
  return places;
}

std::vector<SmoothField> smooth_fields(const std::vector<FieldPlace>& places) {
  std::vector<SmoothField> fields;
  for (const FieldPlace& place : places) {
    for (auto one = place.covariates.begin(); one != place.covariates.end(); ++one) {
      if (!is_quantity(*one)) continue;
      if (place.part_of_row.empty() || place.covariates.size() == 1)
        fields.push_back({&place, {&*one}});
      for (auto other = one + 1; other != place.covariates.end(); ++other) {
        if (is_quantity(*other)) fields.push_back({&place, {&*one, &*other}});
      }
    }
  }
  return fields;
}

std::vector<std::string> names_of(const SmoothField& field) {
  std::vector<std::string> names;
  for (const Covariate* covariate : field.covariates) names.push_back(covariate->name);
  if (!field.place->part.empty()) names.push_back(field.place->part);
  return names;
}

FieldColumns columns_of(const Facts& facts, const SmoothField& field) {
  const Basis basis = basis_of(field);
  const std::vector<int>& part_of_row = field.place->part_of_row;
  const size_t parts =
      part_of_row.empty()
          ? 1
          : 1 + static_cast<size_t>(*std::max_element(part_of_row.begin(), part_of_row.end()));
  if (parts > 1 && parts * basis.values.size() * field.place->slopes.size() > kMostColumns)
    return {};
  double sum2 = 0, sum4 = 0;
  for (const double order : basis.order) {
    const double fall = 1 / (1 + order * order);
    sum2 += fall, sum4 += fall * fall;
  }
  const double size = size_of(*field.place);
  FieldColumns columns;
  for (size_t part = 0; part < parts; ++part) {
    for (size_t k = 0; k < basis.values.size(); ++k) {
      const double fall = 1 / std::sqrt(1 + basis.order[k] * basis.order[k]);
      const double weight = fall / std::sqrt(sum2) / size;
      for (const std::vector<double>& slope : field.place->slopes) {
        std::vector<double>& column = columns.values.emplace_back(slope);
        columns.smoother.push_back(fall * std::sqrt(sum2 / sum4));
        for (size_t i = 0; i < column.size(); ++i) {
          const auto row = static_cast<size_t>(facts.row_of[i]);
          const bool here = parts == 1 || part_of_row[row] == static_cast<int>(part);
          column[i] *= here ? weight * basis.values[k][row] : 0;
        }
        if (field.place->arrives) field.place->arrives(column);
      }
    }
  }
  return columns;
}

}  // namespace seam::measurement
