// The files of behaviours that a bundle takes along, and what they need beside them. Files that a
// program opens by itself are not seen.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace seam::app {

class BehaviourFiles {
 public:
  // Relative names, and the bundle's folder `work`, are those of this folder.
  explicit BehaviourFiles(const std::filesystem::path& working_folder);

  // The program, files among its arguments, and Python modules beside it that it imports. Throws
  // InputError where the program is not there.
  void add_command(const std::vector<std::string>& command, const std::string& robot);
  // A file, or a folder with all in it, that the user names. Throws InputError where it is not
  // there.
  void add(const std::filesystem::path& path);

  // By their names in the bundle's folder `work`.
  const std::map<std::string, std::filesystem::path>& files() const { return files_; }
  // Words of commands that are other ones there.
  const std::map<std::string, std::string>& words() const { return words_; }
  // What must be there beside the bundle: sentences for people, in alphabetical order.
  const std::set<std::string>& needs() const { return needs_; }

 private:
  std::string take(const std::filesystem::path& file);
  void take_folder(const std::filesystem::path& folder);
  void take_word(const std::string& word, const std::string& robot);
  void look_into(const std::filesystem::path& program, const std::string& robot);
  void look_at_imports(const std::filesystem::path& script, const std::string& who);

  std::filesystem::path here_;
  std::map<std::string, std::filesystem::path> files_;
  std::map<std::filesystem::path, std::string> outside_;  // Folders, and what they are called.
  std::map<std::string, std::string> words_;
  std::set<std::string> needs_;
};

}  // namespace seam::app
