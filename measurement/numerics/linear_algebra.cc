#include "measurement/numerics/linear_algebra.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace seam::measurement {

using Eigen::MatrixXd;
using Eigen::VectorXd;

SymmetricEigen symmetric_eigen(const MatrixXd& m) {
  if (m.size() == 0)
    return {VectorXd(0), MatrixXd(0, 0)};  // Eigen's solver stops the program there.
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(m);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

MatrixXd floored_inverse(const MatrixXd& m, double floor) {
  const SymmetricEigen eigen = symmetric_eigen(m);
  const VectorXd inverse = eigen.values.cwiseMax(floor).cwiseInverse();
  return eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose();
}

VectorXd solve_symmetric(const MatrixXd& m, const VectorXd& right) {
  return m.ldlt().solve(right);
}

bool solve_positive(const MatrixXd& m, const VectorXd& right, VectorXd& x) {
  const Eigen::LDLT<MatrixXd> solver(m);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return false;
  x = solver.solve(right);
  return true;
}

MatrixXd solve_square(const MatrixXd& m, const MatrixXd& right, double* log_det) {
  const Eigen::PartialPivLU<MatrixXd> solver(m);
  if (log_det) *log_det = solver.matrixLU().diagonal().array().abs().log().sum();
  return solver.solve(right);
}

MatrixXd inverse_of(const MatrixXd& m) {
  return solve_square(m, MatrixXd::Identity(m.rows(), m.cols()));
}

MatrixXd lower_root(const MatrixXd& m) {
  return Eigen::LLT<MatrixXd>(m).matrixL();
}

MatrixXd solve_any_rank(const MatrixXd& m, const MatrixXd& right, Eigen::Index* rank) {
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver(m);
  if (rank) *rank = solver.rank();
  return solver.solve(right);
}

MatrixXd pseudo_inverse(const MatrixXd& m) {
  return Eigen::CompleteOrthogonalDecomposition<MatrixXd>(m).pseudoInverse();
}

MatrixXd column_basis(const MatrixXd& m) {
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(m);
  return qr.householderQ() * MatrixXd::Identity(m.rows(), qr.rank());
}

MatrixXd column_basis(const MatrixXd& m, double least) {
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(m);
  Eigen::Index own = 0;
  const Eigen::Index most = std::min(m.rows(), m.cols());
  while (own < most && std::abs(qr.matrixR()(own, own)) > least) ++own;
  return qr.householderQ() * MatrixXd::Identity(m.rows(), own);
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * flip * svd.matrixV().transpose();
}

}  // namespace seam::measurement
