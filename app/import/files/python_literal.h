// Values as Python writes them down: what .cameramodel files and the heads of .npy are made of.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace seam::app {

// Dictionaries, lists, tuples (as lists), text, bytes (as text), numbers, True, False and None,
// with comments. Throws InputError with the line, for anything else and for nests deeper than 32.
nlohmann::json python_literal(const std::string& text, const std::string& name);

}  // namespace seam::app
