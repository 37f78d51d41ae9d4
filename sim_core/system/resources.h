// What the operating system must grant before a library is started that ends the process where it
// does not.
#pragma once

namespace seam {

// Throws InputError where fewer than so many threads can be started, or files opened, beside those
// that there are, or where memory is short. The limit of open files is raised as far as it may be.
void require_resources(int threads, int files);

}  // namespace seam
