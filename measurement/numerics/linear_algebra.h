// Decompositions of dense matrices. Compiled here once: Eigen's templates for them take seconds of
// compile time in every file that names them.
#pragma once

#include <Eigen/Core>

namespace seam::measurement {

// m = vectors * diag(values) * vectors', values ascending. Only the lower triangle of m is read.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& m);

// The inverse of a symmetric matrix whose eigenvalues under `floor` count as `floor`: directions
// that the data hardly determine get a large variance instead of an infinite one.
Eigen::MatrixXd floored_inverse(const Eigen::MatrixXd& m, double floor);

// x of m x = right, m symmetric (LDL').
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& m, const Eigen::VectorXd& right);
// The same where m must be positive definite: false, and x untouched, when it is not.
bool solve_positive(const Eigen::MatrixXd& m, const Eigen::VectorXd& right, Eigen::VectorXd& x);

// Of any square matrix that can be inverted (LU); `log_det` receives the logarithm of the amount of
// its determinant.
Eigen::MatrixXd solve_square(const Eigen::MatrixXd& m, const Eigen::MatrixXd& right,
                             double* log_det = nullptr);
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& m);

// Lower triangle L of L L' = m, m positive definite.
Eigen::MatrixXd lower_root(const Eigen::MatrixXd& m);

// The least-squares solution of least norm, for a matrix of any rank; `rank` receives the rank
// found.
Eigen::MatrixXd solve_any_rank(const Eigen::MatrixXd& m, const Eigen::MatrixXd& right,
                               Eigen::Index* rank = nullptr);
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& m);

// Orthonormal columns that span those of m: as many as its rank.
Eigen::MatrixXd column_basis(const Eigen::MatrixXd& m);
// The same of what is more than so much, by length, beside the columns taken before it.
Eigen::MatrixXd column_basis(const Eigen::MatrixXd& m, double least);

// The rotation (determinant 1) nearest to m in the sum of squares.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m);

}  // namespace seam::measurement
