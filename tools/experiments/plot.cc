#include "tools/experiments/plot.h"

#include <cstdio>
#include <cstdlib>

#include "sim_core/base/error.h"
#include "sim_core/base/output.h"

namespace seam::tools {

bool run_gnuplot(const std::filesystem::path& folder, const std::string& file,
                 const std::string& script) {
  const std::string name = std::filesystem::path(file).stem().string();
  write_file_atomically(folder / (name + ".gp"), script);
  const std::string command =
      fmt::format("cd '{}' && gnuplot '{}.gp' 2> '{}.gnuplot.txt'", folder.string(), name, name);
  const int status = std::system(command.c_str());
  if (status == 0) {
    std::filesystem::remove(folder / (name + ".gnuplot.txt"));
    return true;
  }
  std::fprintf(stderr, "seam: %s was not drawn (is gnuplot installed? see %s.gnuplot.txt)\n",
               file.c_str(), name.c_str());
  return false;
}

bool plot(const std::filesystem::path& folder, const std::string& name, const std::string& script) {
  const std::string header = fmt::format(
      "set terminal pngcairo size 900,560 font 'DejaVu Sans,11'\nset output '{}.png'\n"
      "set datafile separator ','\nset grid lc rgb '#dddddd'\nset border 3\nset tics nomirror\n"
      "set style line 1 lc rgb '#0072b2' lw 2 pt 7\nset style line 2 lc rgb '#d55e00' lw 2 pt 5\n"
      "set style line 3 lc rgb '#009e73' lw 2 pt 9\nset style line 4 lc rgb '#777777' lw 1 dt 2\n",
      name);
  return run_gnuplot(folder, name + ".png", header + script);
}

}  // namespace seam::tools
