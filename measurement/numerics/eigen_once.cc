#include "measurement/numerics/eigen_once.h"

SEAM_EIGEN_ONCE()
