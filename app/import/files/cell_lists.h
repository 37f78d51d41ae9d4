// Lists in the cells of a table: "[0.1, 0.2]" of the joints of a robot, as Python prints them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace seam::app {

// The items between brackets, separated by commas, semicolons or blanks, without their quotes;
// false where the cell is no list. Lists in lists are none.
bool list_in(std::string_view cell, std::vector<std::string_view>& items);

}  // namespace seam::app
