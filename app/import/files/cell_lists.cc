#include "app/import/files/cell_lists.h"

namespace seam::app {

bool list_in(std::string_view cell, std::vector<std::string_view>& items) {
  constexpr std::string_view kBlank = " \t\r\n";
  items.clear();
  const size_t first = cell.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return false;
  cell = cell.substr(first, cell.find_last_not_of(kBlank) - first + 1);
  const bool framed = cell.size() >= 2 && ((cell.front() == '[' && cell.back() == ']') ||
                                           (cell.front() == '(' && cell.back() == ')'));
  if (!framed) return false;
  cell = cell.substr(1, cell.size() - 2);
  if (cell.find_first_of("[]()") != std::string_view::npos) return false;
  const std::string_view marks = cell.find_first_of(",;") != std::string_view::npos ? ",;" : kBlank;
  for (size_t start = 0; start < cell.size();) {
    const size_t end = std::min(cell.find_first_of(marks, start), cell.size());
    std::string_view item = cell.substr(start, end - start);
    start = end + 1;
    const size_t from = item.find_first_not_of(" \t\r\n'\"");
    if (from == std::string_view::npos) continue;
    items.push_back(item.substr(from, item.find_last_not_of(" \t\r\n'\"") - from + 1));
  }
  return !items.empty();
}

}  // namespace seam::app
