// A behaviour that is started once for many runs. Its first process stands by: it has loaded and
// prepared all that comes before the first call of the SDK, and forks a client for each run, which
// knows nothing of the runs before. Sweeps ask for it with the variable SEAM_STANDBY, a socket.
#pragma once

namespace seam::sdk {

// Returns at once where nobody asks. Else each return is a client of its own, with the environment
// of its run; the process that stands by ends with the socket.
void stand_by();

}  // namespace seam::sdk
