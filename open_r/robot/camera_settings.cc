#include "open_r/robot/camera_settings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace seam::open_r {
namespace {

constexpr double kDefault_K = 5000;
const double k6dB = std::pow(10, 6.0 / 20);

// What each request's parameters set.
const std::map<std::pair<OPrimitiveRequest, longword>, double>& values() {
  static const std::map<std::pair<OPrimitiveRequest, longword>, double> all{
      {{oprmreqCAM_SET_SHUTTER_SPEED, ocamparamSHUTTER_SLOW}, 2},
      {{oprmreqCAM_SET_SHUTTER_SPEED, ocamparamSHUTTER_MID}, 1},
      {{oprmreqCAM_SET_SHUTTER_SPEED, ocamparamSHUTTER_FAST}, 0.5},
      {{oprmreqCAM_SET_GAIN, ocamparamGAIN_LOW}, 1 / k6dB},
      {{oprmreqCAM_SET_GAIN, ocamparamGAIN_MID}, 1},
      {{oprmreqCAM_SET_GAIN, ocamparamGAIN_HIGH}, k6dB},
      {{oprmreqCAM_SET_WHITE_BALANCE, ocamparamWB_INDOOR_MODE}, 2856},
      {{oprmreqCAM_SET_WHITE_BALANCE, ocamparamWB_FL_MODE}, kDefault_K},
      {{oprmreqCAM_SET_WHITE_BALANCE, ocamparamWB_OUTDOOR_MODE}, 6500}};
  return all;
}

// What a black body sends at a wavelength (Planck), up to a factor.
double radiance(double wavelength_nm, double temperature_K) {
  constexpr double kSecond_nm_K = 1.4387769e7;
  return 1 /
         (std::pow(wavelength_nm, 5) * std::expm1(kSecond_nm_K / (wavelength_nm * temperature_K)));
}

// By how much a colour is raised against green, so that the light of `temperature` is white.
double balance(double wavelength_nm, double temperature_K) {
  constexpr double kGreen_nm = 540;
  const auto share = [&](double t) { return radiance(wavelength_nm, t) / radiance(kGreen_nm, t); };
  return share(kDefault_K) / share(temperature_K);
}

byte rounded(double value) {
  return static_cast<byte>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

bool CameraSettings::set(OPrimitiveRequest request, longword parameter) {
  const auto found = values().find({request, parameter});
  if (found == values().end()) return false;
  (request == oprmreqCAM_SET_SHUTTER_SPEED ? shutter_
   : request == oprmreqCAM_SET_GAIN        ? gain_
                                           : temperature_K_) = found->second;
  update();
  return true;
}

void CameraSettings::update() {
  constexpr double kRed_nm = 600, kBlue_nm = 450;
  green_ = shutter_ * gain_;
  // At the default exactly 1, whatever the functions round.
  const bool balanced = temperature_K_ == kDefault_K;
  red_ = green_ * (balanced ? 1 : balance(kRed_nm, temperature_K_));
  blue_ = green_ * (balanced ? 1 : balance(kBlue_nm, temperature_K_));
}

std::array<byte, 3> CameraSettings::applied(std::array<byte, 3> pixel) const {
  // BT.601 in the full range, as the camera's pictures are.
  const double y = pixel[0], cr = pixel[1] - 128.0, cb = pixel[2] - 128.0;
  const double red = red_ * (y + 1.402 * cr), blue = blue_ * (y + 1.772 * cb),
               green = green_ * (y - 0.714136 * cr - 0.344136 * cb);
  const double luma = 0.299 * red + 0.587 * green + 0.114 * blue;
  return {rounded(luma), rounded(128 + (red - luma) / 1.402), rounded(128 + (blue - luma) / 1.772)};
}

}  // namespace seam::open_r
