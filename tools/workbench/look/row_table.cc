#include "tools/workbench/look/row_table.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace seam::tools {
namespace {

using measurement::Facts;
using measurement::Groups;
using measurement::ResidualView;

// No value equals no value.
bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

// Views of images have rows of their own: places that were chosen for plots.
size_t rows_of(const ResidualView& view) {
  size_t rows = 0;
  for (const auto& [name, values] : view.covariates) rows = std::max(rows, values.size());
  return rows;
}

}  // namespace

RowTable::RowTable(const measurement::Problem& all, const measurement::Problem& used)
    : all_(all), used_(used) {
  if (&all == &used) return;
  std::map<int, size_t> place_of_line;
  for (size_t row = 0; row < all.facts().rows(); ++row)
    place_of_line[all.facts().line_of_row[row]] = row;
  for (const int line : used.facts().line_of_row) places_.push_back(place_of_line.at(line));
}

std::string RowTable::rows(const ResidualView& of_all, const ResidualView& view,
                           const measurement::DataColumns& data) {
  const Facts& facts = all_.facts();
  const size_t n = rows_of(of_all);
  rows_ = n;
  if (n != facts.rows()) places_.clear();
  Columns columns(n);
  if (n == facts.rows()) {
    columns.add("line", {facts.line_of_row.begin(), facts.line_of_row.end()});
    columns.add("group", {facts.group_of_row.begin(), facts.group_of_row.end()});
    const Groups held = all_.scored_groups();
    std::vector<float>& held_out = columns.add("held_out");
    for (size_t row = 0; row < n; ++row)
      held_out[row] = static_cast<float>(held[static_cast<size_t>(facts.group_of_row[row])]);
    std::vector<float>& left_out = columns.add("left_out");
    std::fill(left_out.begin(), left_out.end(), places_.empty() ? 0.0f : 1.0f);
    for (const size_t place : places_) left_out[place] = 0;
    std::vector<float>& outlier = columns.add("outlier");
    std::fill(outlier.begin(), outlier.end(), 0.0f);
    for (size_t i = 0; i < used_.facts().scalars(); ++i) {
      if (used_.left_out(i)) outlier[place_of(used_.facts().row_of[i])] = 1;
    }
    for (const auto& [name, values] : data.columns) columns.add("d:" + name, values);
  }
  for (const auto& [name, values] : of_all.covariates) columns.add(name, values);
  if (of_all.channel("u_px") != nullptr && of_all.channel("v_px") != nullptr) {
    columns.add("u_px", of_all.covariate("column"));
    columns.add("v_px", of_all.covariate("row"));
  }
  for (const ResidualView::Channel& channel : view.channels) {
    columns.add("r:" + channel.name) = column_of(channel, channel.residual);
    columns.add("s:" + channel.name) = stated_[channel.name] = column_of(channel, channel.sigma);
  }
  for (const ResidualView::Channel& channel : of_all.channels) {
    if (channel.observed.empty()) continue;
    std::vector<float>& column = columns.add("d:observed " + channel.name);
    for (size_t i = 0; i < channel.row.size(); ++i)
      column[static_cast<size_t>(channel.row[i])] = static_cast<float>(channel.observed[i]);
  }
  nlohmann::json places = nlohmann::json::array();
  for (const auto& place : data.places)
    places.push_back({{"name", place.name}, {"x", place.x}, {"y", place.y}});
  auto names = data.names;
  names["group"] = facts.groups;
  return columns.bytes(
      {{"channels", channels(view)}, {"names", std::move(names)}, {"places", std::move(places)}});
}

std::string RowTable::residuals(const ResidualView& view, nlohmann::json head) const {
  Columns columns(rows_);
  for (const ResidualView::Channel& channel : view.channels) {
    columns.add("r:" + channel.name) = column_of(channel, channel.residual);
    const std::vector<float> stated = column_of(channel, channel.sigma);
    const auto before = stated_.find(channel.name);
    if (before == stated_.end() || !same_bits(stated, before->second))
      columns.add("s:" + channel.name) = stated;
  }
  head["channels"] = channels(view);
  return columns.bytes(std::move(head));
}

std::vector<std::string> RowTable::channels(const ResidualView& view) const {
  std::vector<std::string> names;
  for (const ResidualView::Channel& channel : view.channels) names.push_back(channel.name);
  return names;
}

std::vector<float> RowTable::column_of(const ResidualView::Channel& channel,
                                       const std::vector<double>& values) const {
  std::vector<float> column(rows_, std::nanf(""));
  for (size_t i = 0; i < channel.row.size(); ++i) {
    const size_t place = place_of(channel.row[i]);
    if (place < column.size()) column[place] = static_cast<float>(values[i]);
  }
  return column;
}

}  // namespace seam::tools
