// Eigen's products and decompositions of dense matrices of doubles, compiled once
// (eigen_once.cc). Every file that multiplies two matrices would compile the same kernels again: a
// seventh of the time of six batches of this folder's files. Read before all else where headers are
// compiled once (CMakeLists.txt); other builds do without.
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
  }                                                                                                \
  namespace Eigen {                                                                                \
  linkage template class LLT<MatrixXd>;                                                            \
  linkage template class LDLT<MatrixXd>;                                                           \
  linkage template class PartialPivLU<MatrixXd>;                                                   \
  linkage template class ColPivHouseholderQR<MatrixXd>;                                            \
  linkage template class CompleteOrthogonalDecomposition<MatrixXd>;                                \
  linkage template class SelfAdjointEigenSolver<MatrixXd>;                                         \
  }

SEAM_EIGEN_ONCE(extern)
