// Prints the fingerprints of the golden frames: the program that scripts/bits_matrix.sh builds with
// other compilers and runs as other CPUs. An argument is the number of threads, or "opengl" for
// frames that OpenGL draws.
#include "render/golden/golden_frames.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>

int main(int argc, char** argv) {
  const bool opengl = argc > 1 && std::strcmp(argv[1], "opengl") == 0;
  const std::string lines =
      opengl ? seam::render::opengl_frame_lines()
             : seam::render::golden_frame_lines(argc > 1 ? std::atoi(argv[1]) : 1);
  std::fputs(lines.c_str(), stdout);
  return 0;
}
