// When pictures were taken, by a table or by their names.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/files/text_table.h"

namespace seam::app {

// By the numbers in their names, so that 10 comes behind 9.
void sort_by_number(std::vector<std::filesystem::path>& pictures);

class PictureTimes {
 public:
  // `table` may be null.
  PictureTimes(const std::vector<std::filesystem::path>& pictures, const TextTable* table,
               const ImportRequest& request);
  // Stamps by the names of the pictures' files.
  PictureTimes(std::string how, std::map<std::string, int64_t> stamps_ns);

  // Whether they are known; `how` they are.
  bool known() const { return !rows_.empty() || unit_ns_ > 0; }
  const std::string& how() const { return how_; }
  // Throws InputError for a picture that the table or its name says nothing of.
  int64_t of(const std::filesystem::path& picture) const;

 private:
  void read_table(const TextTable& table, const ImportRequest& request);

  std::string how_ = "the pictures' names";
  std::map<std::string, int64_t> rows_;  // By the picture's file name.
  int64_t unit_ns_ = 0;                  // Of the numbers in names; 0: they are no times.
};

}  // namespace seam::app
