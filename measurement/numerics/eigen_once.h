// Eigen's products of dense matrices of doubles, compiled once (eigen_once.cc). Every file that
// multiplies two matrices would compile the same kernels again: a seventh of the time of six
// batches of this folder's files. Read before all else where headers are compiled once
// (CMakeLists.txt); other builds do without. Decompositions are compiled where they are used, in
// linear_algebra.cc: a whole class of them takes 4 to 10 s, most of it in what nobody calls.
//
// The names are those of Eigen 3.4 (Debian 12). A declaration that nobody uses costs nothing, one
// that is missing only time.
#pragma once

#include <Eigen/Dense>

#define SEAM_EIGEN_ONCE(linkage)                                                                   \
  namespace Eigen::internal {                                                                      \
  linkage template struct gebp_kernel<                                                             \
      double, double, Index, blas_data_mapper<double, Index, 0, 0, 1>,                             \
      gebp_traits<double, double>::mr, gebp_traits<double, double>::nr, false, false>;             \
  linkage template struct general_matrix_vector_product<                                           \
      Index, double, const_blas_data_mapper<double, Index, 1>, 1, false, double,                   \
      const_blas_data_mapper<double, Index, 1>, false, 0>;                                         \
  linkage template struct general_matrix_vector_product<                                           \
      Index, double, const_blas_data_mapper<double, Index, 1>, 1, false, double,                   \
      const_blas_data_mapper<double, Index, 0>, false, 0>;                                         \
  linkage template struct general_matrix_vector_product<                                           \
      Index, double, const_blas_data_mapper<double, Index, 0>, 0, false, double,                   \
      const_blas_data_mapper<double, Index, 1>, false, 0>;                                         \
  linkage template struct general_matrix_vector_product<                                           \
      Index, double, const_blas_data_mapper<double, Index, 0>, 0, false, double,                   \
      const_blas_data_mapper<double, Index, 0>, false, 0>;                                         \
  linkage template struct general_matrix_matrix_product<Index, double, 0, false, double, 0, false, \
                                                        0, 1>;                                     \
  linkage template struct general_matrix_matrix_product<Index, double, 1, false, double, 0, false, \
                                                        0, 1>;                                     \
  linkage template struct general_matrix_matrix_product<Index, double, 0, false, double, 1, false, \
                                                        0, 1>;                                     \
  linkage template struct general_matrix_matrix_product<Index, double, 1, false, double, 1, false, \
                                                        0, 1>;                                     \
  linkage template struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, 0, 0,    \
                                                  1>;                                              \
  linkage template struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, 0, 0,    \
                                                  1>;                                              \
  linkage template struct triangular_solve_matrix<double, Index, OnTheLeft, UnitLower, false, 0,   \
                                                  0, 1>;                                           \
  }

SEAM_EIGEN_ONCE(extern)
