#include "effects/stages/noise.h"

namespace seam::effects {

EffectDefinition command_jitter() {
  return {
      .name = "command_jitter",
      .stage = Stage::joint,
      .kinds = kJoints,
      .parameters = {{.name = "sigma_s",
                      .min = 0,
                      .max = 1,
                      .scale = 0.002,
                      .help = "Standard deviation of the time by which a command acts early or "
                              "late, seconds; its mean is servo_latency's.",
                      .plausible = {0, 0.1,
                                    "adapters from USB to serial keep bytes for up to 16 ms, busy "
                                    "threads come some 10 ms late"}}},
      .help =
          "Each command acts at a time of its own: a bus or a thread that reads commands when "
          "its turn comes.",
      .formula =
          "error of the angle = its derivative by each command's time, times a draw of "
          "sigma_s for each",
      .signature = "scatter while and after the command changes, the more the larger the change",
      .example = "command_jitter: {sigma_s: 0.003}",
      .spread_only = true,
      .errors = Errors::together,
      .starts = {{kJoints, StartSearch::best_listed, {{0.0005}, {0.002}, {0.01}}}},
      .advice = {{kJoints,
                  {"joint_wander"},
                  "steps with long rests: what acts early or late scatters angles only until the "
                  "joint has arrived, a wander goes on at rest"},
                 {kJoints,
                  {"servo_lag", "servo_latency"},
                  "the same step many times: a lag is the same in each, jitter scatters them"},
                 {kJoints,
                  {},
                  "the same large step many times, with a row every few milliseconds"}},
      .noise =
          [](Values p, Noise& noise) {
            noise.command_sigma_s = std::hypot(noise.command_sigma_s, p[0]);
          },
      .proof = {{.values = {0.003},
                 .expected = {{"command_sigma_s", 0.003}, {"joint_covariance_rad2", 0}},
                 .source = "python: p[0], 0"},
                {.values = {0.02},
                 .expected = {{"command_sigma_s", 0.02}},
                 .source = "python: p[0]"}},
  };
}

}  // namespace seam::effects
