// The way that a wheel may have rolled whose ticks were counted. A count since the start is the way
// in whole ticks: it bounds the way to within half a tick at each row, and says no more. What goes
// on between the bounds is that a wheel has mass: its speed changes by white noise, whose strength
// the counts themselves tell, of the whole log and then about each row.
//
// The way and its speed given all counts are a Gaussian process whose bounds are replaced by normal
// errors that leave the same mean and variance (expectation propagation, Minka 2001).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace seam::measurement {

// Times of rows, and ticks counted until then.
struct CountedWay {
  std::vector<double> time_s;
  std::vector<double> ticks;
};

class RolledWay {
 public:
  // `jolt`: variance of the speed's change in a second, ticks^2/s^3, by row from the one before.
  RolledWay(const CountedWay& counted, std::vector<double> jolt);
  // Where it is known over all rows alone.
  RolledWay(const CountedWay& counted, double jolt);

  // By row, what the way is in the mean, in ticks.
  const std::vector<double>& mean() const { return mean_; }

  // How the error of that mean and of its speed goes on: a share of the error at a time before, and
  // something new. Of the mean between rows is straight.
  struct Step {
    Eigen::Matrix2d kept = Eigen::Matrix2d::Identity();
    Eigen::Matrix2d fresh = Eigen::Matrix2d::Zero();  // Covariance.
  };
  Step step(double from_s, double to_s) const;
  // Covariance of the errors at the first row.
  const Eigen::Matrix2d& at_start() const { return at_start_; }

  // How likely the counts are, each after those before it: the logarithm.
  static double log_chance(const CountedWay& counted, double jolt);

 private:
  // What rows from here on say of way and speed: precision and that times the mean.
  struct Message {
    Eigen::Matrix2d precision = Eigen::Matrix2d::Zero();
    Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
  };
  // A bound in the place of which a normal error stands.
  struct Site {
    double precision = 0, weighted = 0;
  };

  // Both directions again and again, until the mean stands still.
  void settle(const CountedWay& counted);
  void forward(const CountedWay& counted);
  void backward();
  Message from(size_t row) const;  // Its own bound included.
  static Message before(const Message& after, double dt_s, double jolt);
  std::vector<double> jolts_about(const CountedWay& counted, double jolt) const;

  std::vector<double> time_s_;
  std::vector<double> jolt_;  // By row, from the one before.
  std::vector<double> mean_;
  std::vector<Site> sites_;     // By row,
  std::vector<Message> later_;  // and what those after it say.
  Eigen::Matrix2d at_start_;
};

// The strength of jolts under which counts are likeliest.
double jolt_of(const std::vector<CountedWay>& counted);

}  // namespace seam::measurement
