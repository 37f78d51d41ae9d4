// Prints the fingerprints of the golden frames: the program that scripts/bits_matrix.sh builds with
// other compilers and runs as other CPUs. An argument is the number of threads.
#include "render/golden/golden_frames.h"

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  std::fputs(seam::render::golden_frame_lines(argc > 1 ? std::atoi(argv[1]) : 1).c_str(), stdout);
  return 0;
}
