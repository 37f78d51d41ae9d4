// Noise of inertial sensors in the files of programs that fuse them with cameras.
#pragma once

#include "app/exchange/exchange.h"

namespace seam::app {

// As export_model, of formats that hold the noise of a gyroscope and an accelerometer.
Exported export_imu(const effects::Model& model, const ExchangeFormat& format,
                    const ExportOptions& options);

// What these files hold of a sensor: one number for all axes, that of the noisiest.
struct PlainImu {
  double gyro_white = 0, gyro_walk = 0;    // (rad/s) / sqrt(Hz), (rad/s^2) / sqrt(Hz).
  double accel_white = 0, accel_walk = 0;  // Likewise in m.
  double rate_hz = 0;
};
std::string kalibr_imu_text(const PlainImu& imu);
std::string vins_imu_text(const PlainImu& imu);

// As export_model, of formats that hold how a camera and an inertial sensor stand to each other.
Exported export_rig(const effects::Model& model, const ExchangeFormat& format,
                    const ExportOptions& options);
std::string kalibr_rig_text(const effects::Inertial& inertial);
std::string vins_rig_text(const effects::Inertial& inertial);

}  // namespace seam::app
