// What becomes a measurement set before it is opened: the samples that come with SEAM, and files
// that a person drops on the page.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/pages/page_server.h"

namespace seam::tools {

// A set that a command makes: arguments of `seam`, run in `folder`; none where the set is there.
struct Making {
  std::filesystem::path set, folder;
  std::vector<std::string> command;
  std::filesystem::path nominal;   // Copied into the set when it is made; empty: it has its own.
  std::filesystem::path pictures;  // The set's link `pictures` leads there; empty: it has none.

  // After the command has ended.
  void finish() const;
};

class Intake {
 public:
  // `beside`: the folder that holds the sessions; what is made is put there.
  explicit Intake(std::filesystem::path beside);

  // For the state: name, path, kind, title.
  nlohmann::json samples() const;
  // Of the sample with this path; nothing where it is none.
  std::optional<Making> of_sample(const std::string& path) const;

  // Files that were dropped on the page, in a new folder: `{"set": FOLDER}` where a set is among
  // them, else what an import needs to know: `{"dropped": NAME, "kind": KIND or ""}`.
  nlohmann::json take_in(const httplib::MultipartFormDataMap& files) const;
  // An import of them, with options of `seam import` by their names. Throws UsageError.
  Making of_dropped(const std::string& dropped, const std::string& kind,
                    const std::map<std::string, std::string>& options) const;
  // The picture that a frame of the set is named after, in its folder `pictures`, which leads to
  // files that were dropped here or lies in the set; empty: none.
  std::filesystem::path picture_of(const std::filesystem::path& set,
                                   const std::string& frame) const;

 private:
  const std::filesystem::path beside_;
};

// The imports that a page may choose: their options, and the names that their --map takes.
nlohmann::json imports_json();

}  // namespace seam::tools
