// Kind `joints`: servo logs. A run of one joint is a series; the servo effects of a model predict
// the angle at each row from the commands before it.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "effects/stages/joint_track.h"
#include "effects/stages/servo.h"
#include "measurement/kinds/kinds.h"
#include "measurement/noise/driven_errors.h"
#include "measurement/noise/rounded_angle.h"
#include "measurement/problem/memo.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

class MotionLook;
class ParameterSpace;

// One joint in one run.
struct JointLog {
  std::string joint;
  effects::JointRole role = effects::JointRole::pan;  // Any joint but tilt and roll counts as pan.
  std::vector<size_t> rows;                           // In the file.
  std::vector<double> time_s;                         // Since the run's first row.
  std::vector<double> command_rad;
  std::vector<double> measured_rad;
  std::vector<char> enabled;                 // torque_enable.
  std::vector<double> kp;                    // Of the controller; 1 where the log has none.
  std::vector<double> voltage;               // Over the median of the set; likewise.
  std::vector<double> warmer_k;              // Than in the median row; 0 without a column.
  std::vector<double> late_s;                // By how much each command acts late; empty: none.
  double start_radps = 0;                    // Not 0 where the log clearly begins in motion.
  std::vector<std::vector<double>> columns;  // Extra numeric columns by their place in the set.
};

struct JointLogs {
  std::vector<JointLog> logs;
  std::vector<std::string> column_names;  // Of JointLog::columns.
};

// Reads and checks joints.csv. `measured` false: a protocol, measured_rad is not read.
JointLogs read_joint_logs(const CsvTable& table, const std::string& group_column, bool measured);

// Whatever has a motion of its own (a motor, a load on a spring) is followed through all the time
// between two rows, in steps of milliseconds: rows hours apart would take hours, and say nothing.
// Where rows are too far apart for that: file, line, how far, and what was expected; else empty.
std::string pause_too_long(const CsvTable& table, const JointLogs& set);
// Whether the effect gives a joint a motion of its own.
bool moves_by_itself(const EffectDefinition& effect);
// Throws InputError where the model has such an effect and the logs have such a pause.
void expect_no_pause(const std::string& pause, const Model& model);

// What a servo's log lacks that a motor's model would read: sentences that name file, line and
// column.
std::vector<std::string> notes_of_joint_logs(const CsvTable& table);

// The encoder's step of which all measured angles are multiples; 0: of nothing coarse.
double step_of_angles(const JointLogs& set);

// Whether a fit may move the parameter from the beginning: not what is stated, nor what waits until
// the data ask for it.
bool is_open(const effects::ModelEffect& effect, size_t i);

// What a model misses of these groups, in noise units; infinite where it predicts nothing.
double misfit_under(const Problem& problem, const Model& model, const Groups& groups);

// Models whose drive is cut off about where this one's is, by what else can do so.
std::vector<Model> cut_off_otherwise(const Model& model, const std::vector<Unknown>& unknowns);

// The model with its motor stronger and its controller softer, or the other way round, where that
// misses less.
std::optional<Model> trade_that_helps(const Model& model, const std::vector<Unknown>& unknowns,
                                      const std::function<double(const Model&)>& misfit_of);

// What the model says the log shows at each row, for a joint whose log shows `start_rad` at rest
// until the first command acts. A motor that begins in motion is under its first command already.
// `at_row` sees the joint at each row, about to go on; `drives` takes what its motor gives there,
// in acceleration of the joint, before the row's command acts.
std::vector<double> predict_joint_log(
    const Model& model, const JointLogs& set, const JointLog& log, double start_rad,
    double start_radps = 0, const std::function<void(size_t, const effects::Servo&)>& at_row = {},
    std::vector<double>* drives = nullptr);

// Of a parabola through the values around one, without that itself: its noise is not in what
// residuals are held against.
struct Around {
  double value = NAN, slope = NAN, curvature = NAN;
};
Around parabola_around(const std::vector<double>& t, const std::vector<double>& x, size_t k);

// One sigma of a single observation, from each row against a cubic through its neighbours: robust,
// without any model. Rows that repeat their neighbours do not count. The floor is rounding to the
// file's or the encoder's steps.
double noise_from_neighbours(const std::vector<std::vector<double>>& time_s,
                             const std::vector<std::vector<double>>& values);

// Of the angles between which all of the logs' rows lie.
double span_of(const JointLogs& set);

class JointsProblem : public Problem {
 public:
  explicit JointsProblem(const MeasurementSet& set);

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* warm) const override;
  std::vector<std::vector<double>> jacobian(const Model& model,
                                            const std::vector<Unknown>& unknowns,
                                            const Groups& groups,
                                            const Evaluation& here) const override;
  Fit fit(const Model& start, const std::vector<Unknown>& unknowns,
          const Groups& groups) const override;
  std::vector<std::vector<double>> starts(const Model& model,
                                          const EffectDefinition& effect) const override;
  std::vector<std::vector<double>> starts_on(const Groups& groups, const Model& model,
                                             const EffectDefinition& effect,
                                             const EffectList& companions) const override;
  std::vector<std::vector<double>> starts_together(const Model& model,
                                                   const EffectDefinition& effect,
                                                   const EffectList& companions) const override;
  double looks(const Model& model, const EffectDefinition& effect) const override;
  void check_model(const Model& model) const override;
  std::string not_testable(const Model& model, const EffectDefinition& effect,
                           size_t parameter) const override;
  // A motor's motion is; rules of kinematics jump.
  bool is_smooth(const Model& model) const override;
  std::vector<std::string> formula_columns() const override { return set_.column_names; }
  std::vector<char> find_outliers(const Model& model) const override;
  // At each joint's angle and rate as the model predicts them, what repeats over the turn: in the
  // angle that is logged, and in the torque that moves a motor.
  std::vector<FieldPlace> field_places(const Model& model, const Evaluation& here) const override;
  std::vector<std::vector<double>> following(
      const Model& model, const Groups& groups, const Evaluation& here,
      std::vector<std::vector<double>> columns) const override;
  // A fall, a drive, and a duty that may saturate.
  std::vector<Groups> regimes() const override;
  // The inertia that measured torques say, where the model states none.
  std::vector<Finding> findings(const Model& model) const override;
  std::vector<std::string> remarks(const Model& model) const override;

 protected:
  // Torques take part where the given model has some.
  void place(const Model& given) override;

 private:
  // By a few rows of these groups first, where they have many.
  std::vector<std::vector<double>> starts_seen_on(const Groups& groups, const Model& model,
                                                  const EffectDefinition& effect) const;
  // `shown` first, and what it likes best on all of `training`.
  std::vector<std::vector<double>> starts_of(const Model& model, const EffectDefinition& effect,
                                             Groups shown, const Groups& training) const;
  // The strongest wave of residuals over the joint's angle: amplitude, waves in a turn, phase.
  std::vector<double> wave_over_angle(const Model& model, const effects::Parameter& per_turn,
                                      const Groups& shown) const;
  // Period and damping of the swing that would take most of what the model leaves; none where none
  // takes enough.
  std::vector<std::vector<double>> swing_seen(const Model& model, const EffectDefinition& effect,
                                              const Groups& groups) const;
  // Amplitude, waves in a turn and phase of the torque that would take most of what the model
  // leaves of short stretches; none where none takes enough.
  std::vector<std::vector<double>> torque_wave_seen(const Model& model,
                                                    const EffectDefinition& effect,
                                                    const Groups& groups) const;
  std::vector<effects::Lack> lacks() const;
  std::vector<effects::Lack> lacks_of_torques(const Model* given) const;
  void describe(const MeasurementSet& set, const CsvTable& table);
  void add_covariates();
  // A log's true start less what was measured of it.
  struct LogStart {
    double offset_rad = 0, offset_radps = 0;
    // Of how often over the rows tell it: a rule under which a log stays where it starts for a
    // while fits that many rows by it, which chance likes.
    double log_det = 0;
  };
  static constexpr size_t kStartValues = 3;  // In nuisance_values, by log, in this order.
  std::vector<double> predict_from(const Model& model, const JointLog& log, const LogStart& start,
                                   std::vector<double>* drives = nullptr) const;
  // A log's best start under a model, and the angles and drives predicted from there.
  struct Prediction {
    LogStart start;
    std::vector<double> angles, drives;
  };
  int64_t unknowns_of_start(const Model& model, const JointLog& log) const;
  // Derivatives of the log's angles by the unknowns of its start.
  std::vector<std::vector<double>> start_slopes(const Model& model, const JointLog& log,
                                                const LogStart& start,
                                                const std::vector<double>& predicted,
                                                double sigma_rad) const;
  Prediction fit_start(const Model& model, const JointLog& log, double sigma_rad) const;
  void evaluate_logs(const Model& model, const Groups& groups, double sigma_rad,
                     const Evaluation* warm, Evaluation& evaluation) const;
  // In units of the noise: so far from its measurement a start is looked for.
  static constexpr double kFarthestStart = 4;
  // Takes out of derivatives of the whitened residuals what the starts of logs can do about them.
  void take_out_starts(const Model& model, const Groups& groups, const Evaluation& here,
                       std::vector<std::vector<double>>& columns) const;
  Fit polished(Fit fit, const std::vector<Unknown>& unknowns, const Groups& groups) const;
  Fit fit_motor(const Model& start, const std::vector<Unknown>& unknowns,
                const Groups& groups) const;
  Fit fit_torque(const Model& start, const std::vector<Unknown>& unknowns,
                 const Groups& groups) const;
  Fit fit_acting(const Model& start, const std::vector<Unknown>& unknowns,
                 const Groups& groups) const;
  std::optional<Model> worth_damping(const Fit& fit, const std::vector<Unknown>& first,
                                     const std::vector<Unknown>& unknowns,
                                     const Groups& groups) const;
  // By log: whether it belongs to one of the groups.
  std::vector<char> logs_of(const Groups& groups) const;
  // The accelerations that these logs show, as far as the model can have them.
  MotionLook motion_look(const Model& model, const std::vector<char>& chosen) const;
  // Of an effect that is a limit: the value of it with which this model, near the noise, misses
  // least of whole runs; none where no value helps.
  std::optional<double> limit_that_helps(const Model& model, const EffectDefinition& effect,
                                         const Groups& groups) const;
  bool shows_torque(const Model& model, Model motor, const Groups& groups) const;
  // Where a fit of a motor to whole runs begins: a model that misses by far is fitted to short
  // stretches first.
  Model near_start(const Model& start, const std::vector<Unknown>& unknowns,
                   const Groups& groups) const;
  std::vector<std::vector<double>> differences(const ParameterSpace& space, const Model& model,
                                               const Groups& groups, const Evaluation& here,
                                               const std::vector<double>& steps,
                                               bool both_sides) const;
  void state_errors(Fit& fit, const std::vector<Unknown>& unknowns, const Groups& groups) const;
  std::vector<std::vector<double>> motor_jacobian(const Model& model,
                                                  const std::vector<Unknown>& unknowns,
                                                  const Groups& groups,
                                                  const Evaluation& here) const;

  void add_efforts(const CsvTable& table, const MeasurementSet& set);
  bool has_efforts() const { return !efforts_nm_.empty(); }
  // Of angles; torques have their own.
  void set_sigma(double sigma_rad, Evaluation& evaluation) const;
  // Adds those of torques; the inertia that they say stands last in the nuisances.
  void predict_efforts(const Model& model, const Groups& groups, const std::vector<double>& drives,
                       Evaluation& evaluation) const;
  // By row: a channel's residuals, which of the neighbours stand out of, and how far.
  std::vector<double> out_of_neighbours(const Evaluation& evaluation) const;
  // Errors that wander, and those of commands that act early or late.
  void whiten_wander(const Model& model, const Groups& groups, Evaluation& evaluation) const;
  std::vector<size_t> used_logs(const Groups& groups) const;
  // By used log.
  using LateSteps = std::vector<std::shared_ptr<const std::vector<DrivenStep>>>;
  LateSteps late_steps(const Model& model, const std::vector<size_t>& used,
                       const Evaluation& here) const;
  void whiten_late_commands(const Model& model, const effects::Noise& noise, const Groups& groups,
                            Evaluation& evaluation) const;

  void look_for_steps();
  void mark_shared_errors();
  // How a model has angles logged: with normal errors, or rounded to the steps that all angles
  // show. Beside an error that wanders the rounding counts as noise.
  struct Reading {
    double sigma_rad = 0;
    std::optional<RoundedAngle> rounded;
  };
  Reading reading_of(const Model& model) const;
  // Noise behind the steps that no set states is the likeliest of these.
  const RoundedAngle& likeliest_rounding(const Evaluation& seen) const;
  void whiten_rounded(const RoundedAngle& rounded, Evaluation& evaluation) const;
  // The density of a normal error narrower than a step gives its likeliest reading a chance above
  // 1, and a joint at rest shows that reading again and again: its chance is 1 instead.
  void bound_chances(Evaluation& evaluation) const;
  // By how much whitened residuals change, to first order, where angles do.
  std::vector<double> change_of(const Model& model, const Evaluation& here,
                                const Evaluation& there) const;

  JointLogs set_;
  std::string pause_;               // Why none of these logs shows a motor; empty: they do.
  bool efforts_read_ = false;       // The model given predicts them.
  std::vector<double> efforts_nm_;  // By row, NaN where blank; empty: none are measured.
  // Scalars of angles are numbered as the rows, those of torques follow. By row, -1: none.
  std::vector<int> effort_scalar_;
  // By log. A fit of a spread, a score after a fit and a structure test ask for the same.
  std::optional<Memo<Prediction>> predictions_;
  std::optional<Memo<std::vector<DrivenStep>>> late_steps_;
  double lattice_rad_ = 0;       // All measured angles are multiples of this; 0: of nothing coarse.
  double behind_steps_rad_ = 0;  // The noise before it is rounded to them, at most.
  std::vector<RoundedAngle> roundings_;  // With less and less of it; one where the set states it.
  double largest_step_rad_ = 0;          // Of an encoder, that the scatter of neighbours allows.
};

// Why the times of commands show nothing in this model's logs, a sentence; empty where it has no
// scatter of them, or shows it.
std::string why_late_commands_hide(const Model& model);

// Makes the log that the model would give (`seam measure`): the joint starts at rest at its first
// command.
void measure_joints(const Model& truth, const MeasurementSet& protocol,
                    const MeasureOptions& options);

Kind joints_kind();

}  // namespace seam::measurement
